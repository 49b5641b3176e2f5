"""An experiment with its profile, checked as a whole before anything is opened."""

import contextlib
import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from fnmatch import fnmatchcase
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rig.assembly import REGISTRY, check_profile, make_controller, plan_motion, with_what_else
from rig.config import (
    EXPERIMENT_KEYS,
    PROFILE_KEYS,
    Experiment,
    Profile,
    ProfileError,
    find_configs,
    load_experiment,
    load_profile,
)
from rig.config.diagnostics import Diagnostic
from rig.config.document import name_under
from rig.config.dump import setting_of
from rig.config.experiment import rig_of
from rig.config.located import places_named
from rig.config.models import MetricSpec
from rig.config.setting import Setting, written
from rig.experiment.dry_measures import try_measures
from rig.experiment.measure import Measure
from rig.experiment.metrics import known_measures
from rig.experiment.unknown_names import unknown_names
from rig.hal import Column, ConfigurationError, SeveralErrors
from rig.hal.motion import Fact, Motion


class Plan(NamedTuple):
    """An experiment with its rig and controller; found possible before anything is opened.

    Parameters
    ----------
    experiment, profile : Experiment, Profile
        As loaded.
    controller : Controller
        The experiment's, with the profile's settings.
    motion : Motion
        What the controller follows.
    measures : mapping of str to Measure
        Beside those that are installed.
    sources : mapping of str to str
        Text of code that no package holds, by its path in the run folder.
    """

    experiment: Experiment
    profile: Profile
    controller: Any
    motion: Motion[object]
    measures: Mapping[str, Measure] = MappingProxyType({})
    sources: Mapping[str, str] = MappingProxyType({})


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
    named = rig or rig_of(experiment, search)
    for_experiment, for_profile = split_overrides(overrides, named, search)
    if rig is not None:
        for_experiment = [*for_experiment, Setting(f"rig={rig}", f"--rig {rig}")]
    admit_options(for_profile, named, search)
    try:
        loaded = load_experiment(experiment, REGISTRY, for_experiment, search)
    except ProfileError as error:
        errors = _errors_beside(experiment, for_experiment, named, for_profile, search)
        raise ProfileError([*error.diagnostics, *errors]) from error
    try:
        profile = load_profile(loaded.rig, REGISTRY, for_profile, search)
    except ProfileError as error:
        raise with_what_else(error) from error
    return make_plan(loaded, profile)


def simulated_otherwise(plan: Plan) -> tuple[str, ...]:
    """Return in what the simulated rig is not the one that the motion is planned for."""
    profile = plan.profile
    if profile.plant is None:
        return ()
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    told: tuple[str, ...] = mechanism.plant_unlike(
        profile.mechanism_settings, plan.experiment.reference.settings, profile.plant.settings
    )
    return told


def admit_options(options: Sequence[str], rig: str | None, search: Sequence[Path]) -> None:
    """Let take part the packages that options of a profile name: an experiment may need them."""
    if rig is not None and any(re.match(r"\s*additions\b", option) for option in options):
        with contextlib.suppress(ConfigurationError):  # said when the profile itself is loaded
            load_profile(rig, REGISTRY, options, search)


def _errors_beside(
    experiment: str | Path,
    for_experiment: Sequence[str],
    rig: str | None,
    for_profile: Sequence[str],
    search: Sequence[Path],
) -> tuple[Diagnostic, ...]:
    """Return what else can be said of an experiment with errors: of its profile, of its names."""
    if rig is None:
        return ()
    errors: tuple[Diagnostic, ...] = ()
    try:
        load_profile(rig, REGISTRY, for_profile, search)
    except ProfileError as other:
        errors = other.diagnostics
    except ConfigurationError:
        return ()  # there is no such rig: said when the experiment itself is in order
    mechanism = name_under("mechanism", rig, "rigs", search)
    if mechanism not in REGISTRY.names("mechanism"):
        return errors
    return (*errors, *unknown_names(experiment, for_experiment, search, mechanism))


def split_overrides(
    overrides: Sequence[str], rig: str | None = None, search: Sequence[Path] = ()
) -> tuple[list[str], list[str]]:
    """Return the options of the experiment and those of the profile.

    Parameters
    ----------
    overrides : sequence of str
        Each an ``a.b=c``.
    rig : str, optional
        Whose mechanism a hint names when an option lacks it.
    search : sequence of Path
        Where that rig's profile is looked for.

    Raises
    ------
    ConfigurationError
        An option starts with a key of neither.
    """
    profile_keys = {*PROFILE_KEYS, *REGISTRY.names("mechanism")} - {"name", "description"}
    for_experiment: list[str] = []
    for_profile: list[str] = []
    wrong: list[str] = []
    for option in overrides:
        key = option.partition("=")[0].partition(".")[0].strip()
        if key in EXPERIMENT_KEYS:
            for_experiment.append(option)
        elif key in profile_keys:
            for_profile.append(option)
        else:
            path = option.partition("=")[0].strip()
            near = _within_mechanism(path, rig, search) or difflib.get_close_matches(
                key, {*EXPERIMENT_KEYS, *profile_keys}, n=1
            )
            hint = f"; did you mean {near[0]!r}?" if near else ""
            wrong.append(f"{written(option)}: there is no key {key!r}{hint}")
    SeveralErrors.raise_if_any(wrong)
    return for_experiment, for_profile


def _within_mechanism(path: str, rig: str | None, search: Sequence[Path]) -> list[str]:
    """Return a key as it is called under a rig's mechanism, or nothing where that has none such."""
    if rig is None:
        return []
    try:
        mechanism = load_profile(rig, REGISTRY, (), search).mechanism
    except ConfigurationError:
        return []  # without a sound profile nobody knows its mechanism
    known = {field.name for field in fields(REGISTRY.settings("mechanism", mechanism))}
    return [f"{mechanism}.{path}"] if path.partition(".")[0] in known else []


def make_plan(experiment: Experiment, profile: Profile) -> Plan:
    """Find what is wrong with an experiment on its rig, before anything is opened.

    Raises
    ------
    ConfigurationError
        The profile lacks the controller, the motion is not possible or not permitted, or a
        metric cannot be computed.
    """
    found: list[ConfigurationError] = []
    columns: tuple[Column, ...] = ()
    try:
        columns = check_profile(profile)
    except SeveralErrors as error:
        found.append(error)
    try:
        _check_figures(experiment, profile.mechanism, columns)
    except SeveralErrors as error:
        found.append(_of_experiment(error, experiment, profile))
    try:
        experiment = _with_metrics_that_apply(experiment, profile)
        controller = make_controller(profile, experiment.controller)
        motion = plan_motion(profile, experiment.reference.settings, controller)
        if motion.segments:
            experiment = _with_reported_metrics(experiment, profile.mechanism)
        _check_metrics(experiment, motion, profile, columns)
    except ConfigurationError as error:
        found.append(_of_experiment(error, experiment, profile))
        if experiment.unitless and not isinstance(error, SeveralErrors):
            found[-1] = type(error)("\n".join([str(found[-1]), *experiment.unitless]))
            found[-1].__cause__ = error
    if len(found) == 1:
        raise found[0]
    SeveralErrors.raise_if_any([text for error in found for text in SeveralErrors.told_by(error)])
    return Plan(experiment, profile, controller, motion)


def _of_experiment(
    error: ConfigurationError, experiment: Experiment, profile: Profile
) -> ConfigurationError:
    """Return an error with the experiment's name, and the place of each key that it names."""
    told = [
        f"{experiment.name}: "
        f"{places_named(text, experiment.places, profile.places, profile.mechanism)}"
        for text in SeveralErrors.told_by(error)
    ]
    made = SeveralErrors(told) if isinstance(error, SeveralErrors) else type(error)(told[0])
    made.__cause__ = error
    return made


def _with_metrics_that_apply(experiment: Experiment, profile: Profile) -> Experiment:
    """Return the experiment without the metrics that are for other settings than these."""
    applying = {}
    for name, spec in experiment.metrics.items():
        try:
            settings = {key: setting_of(key, profile, experiment) for key in spec.when}
        except ConfigurationError as error:
            raise ConfigurationError(f"metric {name}: {error}") from error
        if settings == spec.when:
            applying[name] = spec
    return replace(experiment, metrics=applying)


def _with_reported_metrics(experiment: Experiment, mechanism: str) -> Experiment:
    """Return the experiment with what every run of a mechanism reports."""
    reported = {name: MetricSpec() for name in REGISTRY.reported(mechanism)}
    return replace(
        experiment,
        metrics={
            **experiment.metrics,
            **{name: spec for name, spec in reported.items() if name not in experiment.metrics},
        },
    )


def constants_of(profile: Profile) -> Mapping[str, float]:
    """Return what measures need to know of a rig beside its log, SI."""
    view = REGISTRY.load("mechanism", profile.mechanism)
    constants: Mapping[str, float] = view.constants_of(profile.mechanism_settings)
    return constants


def _check_metrics(
    experiment: Experiment, motion: Motion[object], profile: Profile, columns: Sequence[Column]
) -> None:
    names = [segment.name for segment in motion.segments]
    facts, measures = motion.facts, known_measures(profile.mechanism)
    known: dict[str, Measure | Fact] = {**measures, **facts}
    wrong: list[str] = []
    for name, spec in experiment.metrics.items():
        measure = known.get(spec.measure or name)
        if measure is None:
            near = difflib.get_close_matches(spec.measure or name, known, n=1)
            offered = ", ".join((*facts, *REGISTRY.own_measures(profile.mechanism)))
            hint = f"; did you mean {near[0]!r}?" if near else f"; there are {offered}"
            wrong.append(f"metric {name}: no measure is called {spec.measure or name!r}{hint}")
            continue
        if spec.unit is not None and spec.unit != (measure.unit or "1"):
            wrong.append(
                f"metric {name}: its bound is in {spec.unit}, "
                f"{spec.measure or name} is in {measure.unit or 'no unit'}"
            )
        if not any(fnmatchcase(segment, spec.segments) for segment in names):
            wrong.append(
                f"metric {name}: no segment matches {spec.segments!r}; there are {', '.join(names)}"
            )
    SeveralErrors.raise_if_any(wrong)
    if not columns:
        return  # the profile is wrong, which is said
    taken = {name: measure for name, measure in measures.items() if name not in facts}
    try_measures(experiment.metrics, taken, motion.segments, columns, constants_of(profile))


def _check_figures(experiment: Experiment, mechanism: str, columns: Sequence[Column]) -> None:
    from rig.report.figures import figure_kind, known_figures

    known = known_figures(mechanism) if experiment.figures else {}
    logged = [column.name for column in columns]
    wrong: list[str] = []
    for name in experiment.figures:
        kind = figure_kind(name, known)
        if kind is None:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
            wrong.append(f"figures: no figure is called {name!r}; {hint}")
        elif name not in known and logged and not _is_logged(name, logged):
            near = difflib.get_close_matches(name, logged, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            wrong.append(f"figures: the log of this rig has no column {name!r}{hint}")
    SeveralErrors.raise_if_any(wrong)


def _is_logged(pattern: str, logged: Sequence[str]) -> bool:
    """Return whether a log has such a column; what is known of every run is always there."""
    groups = ("reference.time", "timing.", "truth.")
    return pattern.startswith(groups) or any(fnmatchcase(name, pattern) for name in logged)
