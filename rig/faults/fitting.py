"""Which experiments a rig can carry out: those that its limits and its plant let be planned."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import monotonic
from typing import Final, NamedTuple

from rig.config import find_configs, find_file
from rig.config.names import SHIPPED
from rig.experiment.plan import load_plan
from rig.faults.survey import experiments_of
from rig.hal import ConfigurationError

_PATIENCE: Final = 20.0
"""For so long experiments are planned only to see whether they can be, s; the others may do."""
_TOLD: Final = 4
"""So many are named."""


class Fitting(NamedTuple):
    """Experiments that can be planned on a rig, and the reasons of the others.

    Parameters
    ----------
    names : tuple of str
        Experiments.
    refused : mapping
        The first line of what each other one is refused with.
    """

    names: tuple[str, ...]
    refused: Mapping[str, str]


def fit(names: Sequence[str], rig: str, configs: Path | None) -> Fitting:
    """Plan experiments on a rig, and return which can be."""
    fits, refused = [], {}
    began = monotonic()
    for name in names:
        if monotonic() - began < _PATIENCE:
            try:
                load_plan(name, rig=rig, configs=configs)
            except ConfigurationError as error:
                refused[name] = str(error).partition("\n")[0]
                continue
        fits.append(name)
    return Fitting(tuple(fits), refused)


def experiments_for(rig: str, configs: Path | None, say: Callable[[str], None]) -> tuple[str, ...]:
    """Return the experiments that a rig is broken in if nobody says which.

    Parameters
    ----------
    rig : str
        A name, or the path of a file. Those of a rig that ships are known to fit.
    configs : Path or None
        The folder of configurations.
    say : callable
        Hears which are left out.

    Raises
    ------
    ConfigurationError
        There is none; with those of its mechanism that could be asked for.
    """
    try:
        found = experiments_of(rig, configs)
    except ConfigurationError as error:
        raise ConfigurationError(f"{error}\n    {_instead(rig, configs)}".rstrip()) from error
    if SHIPPED in find_file(rig, "rigs", find_configs(configs)).resolve().parents:
        return found
    fitting = fit(found, rig, configs)
    if not fitting.names:
        why = next(iter(fitting.refused.values()))
        raise ConfigurationError(
            f"no experiment runs on {rig}: none of {', '.join(found)} can be planned on it; {why}"
        )
    if fitting.refused:
        why = next(iter(fitting.refused.values()))
        say(f"left out, as they cannot be planned on {rig}: {', '.join(fitting.refused)}; {why}")
    return fitting.names


def check_chosen(names: Sequence[str], rig: str, configs: Path | None) -> None:
    """Refuse experiments that somebody chose and that a rig cannot carry out.

    Raises
    ------
    ConfigurationError
        With those that it can.
    """
    search = find_configs(configs)
    for name in names:
        find_file(name, "experiments", search)  # a name that there is not has a nearest one
        try:
            load_plan(name, rig=rig, configs=configs)
        except ConfigurationError as error:
            raise ConfigurationError(f"{error}\n    {_instead(rig, configs)}".rstrip()) from error


def _instead(rig: str, configs: Path | None) -> str:
    """Return which experiments of a rig's mechanism could be asked for, in a line."""
    try:
        fitting = fit(experiments_of(rig, configs, any_world=True), rig, configs)
    except ConfigurationError:  # there is none of its mechanism
        return ""
    if not fitting.names:
        return (
            f"none of {', '.join(fitting.refused)} can be planned on it: `rig new experiment NAME "
            f"--rig {shlex.quote(rig)}` begins one"
        )
    more = len(fitting.names) - _TOLD
    others = f", and {more} more" if more > 0 else ""
    return f"what can be planned on it: {', '.join(fitting.names[:_TOLD])}{others}"
