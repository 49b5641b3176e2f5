"""What is asked of a sweep, checked before anything runs."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from rig.assembly import Backend
from rig.config.setting import Setting
from rig.hal import ConfigurationError
from rig.run_names import RUNS
from rig.sweeping.axis import Axis
from rig.sweeping.design import AnyAxis
from rig.sweeping.stop_rule import StopRule
from rig.sweeping.written import Written

SWEEPS: Final = "sweeps"
"""Where sweeps live among the runs, unless they are told otherwise."""
SIMULATED: Final = ("sim", "virtual")
"""Backends on which points do not disturb each other."""


@dataclass(frozen=True, slots=True)
class SweepRequest:
    """A sweep as it was asked for.

    Parameters
    ----------
    experiment : str
        A name, or the path of a file.
    axes : tuple of Axis, DrawnAxis or Variations
        What is varied.
    seeds : Axis, optional
        Seeds of the simulation.
    on : str
        The backend.
    options : tuple of str
        Settings of every point, as for ``--set``.
    rig : str, optional
        Another rig than the experiment's.
    configs : Path, optional
        The folder of the configurations.
    workers : int
        How many points at once, on this machine; 0: one for each processor.
    dask : str, optional
        A scheduler's address or file.
    serial : bool
        One point after the other, in this process.
    cool_down : float
        Rest between two points of `serial`, s.
    out : Path, optional
        The sweep's folder; default: of the experiment's and the backend's name, below `runs`.
    runs : Path
        Where run folders live, sweeps among them.
    draw_seed : int
        Of drawn axes.
    stop_when : StopRule, optional
        Ends the sweep with the first point of which it is true.
    seconds, points : float or None
        The budget.
    best : str, optional
        The metric that the best points are best in; default: the first one.
    keep : int
        Of how many of the best the run folder is kept; -1: of all.
    uncommissioned : str, optional
        Why hardware that is not commissioned goes at its whole speed.
    """

    experiment: str
    axes: tuple[AnyAxis, ...] = ()
    seeds: Axis | None = None
    on: str = "virtual"
    options: tuple[str, ...] = ()
    rig: str | None = None
    configs: Path | None = None
    workers: int = 0
    dask: str | None = None
    serial: bool = False
    cool_down: float = 0.0
    out: Path | None = None
    runs: Path = RUNS
    draw_seed: int = 0
    stop_when: StopRule | None = None
    seconds: float | None = None
    points: float | None = None
    best: str | None = None
    keep: int = 3
    uncommissioned: str | None = None

    @property
    def folder(self) -> Path:
        """The sweep's folder."""
        return self.out or self.runs / SWEEPS / f"{Path(self.experiment).stem}-{self.on}"

    def checked(self) -> "SweepRequest":
        """Return the request.

        Raises
        ------
        ConfigurationError
            It asks for what does not go together.
        """
        if not self.axes and self.seeds is None:
            raise ConfigurationError("nothing is varied: --vary a.b=1..5:9, or --seeds 0:20")
        if self.on not in list(Backend):
            raise ConfigurationError(
                f"a sweep runs on one of {', '.join(SIMULATED)}; with --serial on one of "
                f"{', '.join(Backend)}, and not on {self.on!r}"
            )
        if self.on not in SIMULATED and not self.serial:
            raise ConfigurationError(
                f"a sweep on {self.on} has one rig for all of its points: --serial runs them one "
                "after the other"
            )
        if self.serial and self.dask is not None:
            raise ConfigurationError("--serial runs here, --dask elsewhere: leave out one")
        if not 0 <= self.workers <= 1024:
            raise ConfigurationError(f"--workers {self.workers}: expected 1 to 1024")
        if self.draw_seed < 0:
            raise ConfigurationError(f"draw_seed is {self.draw_seed}: expected 0 or more")
        return self


def as_options(settings: Mapping[str, object], written: Written) -> tuple[str, ...]:
    """Return settings as options for ``--set``, which know how they were written."""
    return tuple(
        Setting(f"{key}={as_text(value)}", written("set", key, value))
        for key, value in settings.items()
    )


def as_text(value: object) -> str:
    """Write a Python value as ``--set`` reads it.

    Raises
    ------
    ConfigurationError
        It is none that a setting can have.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    try:
        return json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise ConfigurationError(f"{value!r} is no value of a setting ({error})") from error
