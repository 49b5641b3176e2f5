"""An experiment with its profile, checked as a whole before anything is opened."""

import difflib
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY, check_profile
from rig.config import (
    EXPERIMENT_KEYS,
    PROFILE_KEYS,
    Experiment,
    Profile,
    find_configs,
    load_experiment,
    load_profile,
)
from rig.experiment.measures import MEASURES
from rig.experiment.references import Reference
from rig.hal import ConfigurationError


class Plan(NamedTuple):
    """What is to be done, on what."""

    experiment: Experiment
    profile: Profile

    @property
    def reference(self) -> Reference:
        """The desired motion."""
        settings: Reference = self.experiment.reference.settings
        return settings


def load_plan(
    experiment: str | Path,
    overrides: Sequence[str] = (),
    *,
    rig: str | None = None,
    configs: Path | None = None,
) -> Plan:
    """Load an experiment and its profile, with ``a.b=c`` options for either.

    Parameters
    ----------
    experiment : str or Path
        A name or the path of a file.
    overrides : sequence of str
        Each goes to the file whose key it starts with.
    rig : str, optional
        Another profile than the one that the experiment names.
    configs : Path, optional
        The folder of the configurations.

    Raises
    ------
    ConfigurationError
        Anything that can be found wrong without opening a device.
    """
    search = find_configs(configs)
    for_experiment, for_profile = split_overrides(overrides)
    if rig is not None:
        for_experiment = [*for_experiment, f"rig={rig}"]
    loaded = load_experiment(experiment, REGISTRY, for_experiment, search)
    profile = load_profile(loaded.rig, REGISTRY, for_profile, search)
    plan = Plan(loaded, profile)
    check_plan(plan)
    return plan


def split_overrides(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the options of the experiment and those of the profile.

    Raises
    ------
    ConfigurationError
        An option starts with a key of neither.
    """
    profile_keys = {*PROFILE_KEYS, *REGISTRY.names("mechanism")} - {"name", "description"}
    for_experiment, for_profile = [], []
    for option in overrides:
        key = option.partition("=")[0].partition(".")[0].strip()
        if key in EXPERIMENT_KEYS:
            for_experiment.append(option)
        elif key in profile_keys:
            for_profile.append(option)
        else:
            near = difflib.get_close_matches(key, {*EXPERIMENT_KEYS, *profile_keys}, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ConfigurationError(f"--set {option}: there is no key {key!r}{hint}")
    return for_experiment, for_profile


def check_plan(plan: Plan) -> None:
    """Find what is wrong with an experiment on its rig, before anything is opened.

    Raises
    ------
    ConfigurationError
        The profile lacks the controller, the reference leaves the permitted positions, or a
        metric cannot be computed.
    """
    experiment, profile = plan
    check_profile(profile)
    if experiment.controller not in profile.controllers:
        raise ConfigurationError(
            f"{experiment.name}: the profile {profile.name} has no controller "
            f"{experiment.controller!r}; it has {', '.join(profile.controllers)}"
        )
    _check_reference(plan)
    _check_metrics(plan)


def _check_reference(plan: Plan) -> None:
    reference, period = plan.reference, plan.profile.loop.period
    lower, upper = plan.profile.mechanism_settings.limits.position
    for tick in range(int(reference.duration / period) + 1):
        t = tick * period
        position = reference.at(t).position
        if not lower <= position <= upper:
            raise ConfigurationError(
                f"{plan.experiment.name}: after {t:.3g} s the reference is at "
                f"{position * 1e3:.4g} mm, outside limits.position of {plan.profile.name}, "
                f"{lower * 1e3:.4g} … {upper * 1e3:.4g} mm"
            )


def _check_metrics(plan: Plan) -> None:
    names = [segment.name for segment in plan.reference.segments]
    for name, spec in plan.experiment.metrics.items():
        measure = MEASURES.get(spec.measure or name)
        if measure is None:
            near = difflib.get_close_matches(spec.measure or name, MEASURES, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(MEASURES)}"
            raise ConfigurationError(
                f"{plan.experiment.name}: metric {name}: no measure is called "
                f"{spec.measure or name!r}{hint}"
            )
        if spec.unit is not None and spec.unit != (measure.unit or "1"):
            raise ConfigurationError(
                f"{plan.experiment.name}: metric {name}: its bound is in {spec.unit}, "
                f"{spec.measure or name} is in {measure.unit or 'no unit'}"
            )
        if not any(fnmatchcase(segment, spec.segments) for segment in names):
            raise ConfigurationError(
                f"{plan.experiment.name}: metric {name}: no segment matches "
                f"{spec.segments!r}; there are {', '.join(names)}"
            )
