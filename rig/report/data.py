"""A run as figures and reports see it: everything comes from its folder."""

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rig.assembly import REGISTRY
from rig.config.calibration import HARDWARE
from rig.config.yaml_loader import read_plain
from rig.experiment.measure import PHASE_RUN, stretch_of
from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.hal import ConfigurationError
from rig.hal.motion import Segment
from rig.run_facts import EVALUATION, MetricRow
from rig.run_folder import RunFolder
from rig.runtime.log_columns import LogColumns, read_columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DAY = len("2026-01-31")
"""Of a time stamp."""
_PROFILE = "profile.yaml"


@dataclass(frozen=True)
class RunData:
    """One run, loaded.

    Parameters
    ----------
    folder : RunFolder
        Where it came from.
    log : LogColumns
        All cycles.
    segments : tuple of Segment
        Those of its reference.
    metrics : tuple of MetricRow
        The entries of ``metrics.json``.
    """

    folder: RunFolder
    log: LogColumns
    segments: tuple[Segment, ...]
    metrics: tuple[MetricRow, ...]

    def has(self, *names: str) -> bool:
        """Return whether the log has all of these columns."""
        return all(name in self.log for name in names)

    @property
    def t(self) -> "NDArray[np.float64]":
        """Seconds since the reference started, shape (n,)."""
        name = "reference.time"
        return self.log.column(name) if name in self.log else self.log.t

    @cached_property
    def followed(self) -> "NDArray[np.bool_]":
        """Which cycles followed the reference; all of them if none did, shape (n,)."""
        if "phase" not in self.log:
            return np.ones(len(self.log.t), bool)
        run = self.log.column("phase") == PHASE_RUN
        return run if run.any() else np.ones(len(self.log.t), bool)

    @cached_property
    def _stretch(self) -> "slice | NDArray[np.bool_]":
        return stretch_of(self.followed)

    @property
    def time(self) -> "NDArray[np.float64]":
        """Seconds since the reference started, of the cycles that followed it, shape (n,)."""
        return np.asanyarray(self.t[self._stretch], order="C")

    def trace(self, name: str) -> "NDArray[np.float64]":
        """Return a column of the cycles that followed the reference, shape (n,)."""
        return np.asanyarray(self.log.column(name)[self._stretch], order="C")

    def track(self, name: str) -> "NDArray[np.float64]":
        """Return the columns ``name_x``, ``_y``, ``_z`` of the same cycles, shape (n, 3)."""
        return np.column_stack([self.trace(f"{name}_{axis}") for axis in "xyz"])

    @property
    def mechanism(self) -> str | None:
        """The rig's mechanism; None of a run that was recorded before it was noted."""
        return mechanism_of(self.folder)

    @property
    def error(self) -> "NDArray[np.float64]":
        """Reference minus reading of the position, m, shape (n,)."""
        return self.log.column("reference.position") - self.log.column("reading.position")

    @cached_property
    def settings(self) -> dict[str, Any]:
        """What the run's own profile says of its mechanism, SI."""
        settings = self._profile.get(str(self._profile.get("mechanism")))
        if not isinstance(settings, dict):
            path = self.folder.path / _PROFILE
            raise ConfigurationError(f"{path} does not say what its mechanism is")
        return settings

    @property
    def law_settings(self) -> dict[str, object]:
        """What the run's own profile says of the law that drove it, SI; nothing if it says none."""
        laws = self._profile.get("controllers")
        law = self.folder.manifest.get("law", "")
        settings = laws.get(law) if isinstance(laws, dict) else None
        return settings if isinstance(settings, dict) else {}

    @cached_property
    def _profile(self) -> dict[str, object]:
        profile = read_plain(self.folder.path / _PROFILE)
        return dict(profile) if isinstance(profile, dict) else {}


def mechanism_of(folder: RunFolder) -> str | None:
    """Return the mechanism of the rig that a run was recorded on; None if it is not noted.

    The additions that the run's profile named may take part from now on.
    """
    evaluation = folder.read_json(EVALUATION, Evaluation)
    for name in evaluation.get("additions", ()):
        with contextlib.suppress(KeyError, ConfigurationError):  # it is not installed here
            REGISTRY.admit(name)
    return evaluation.get("mechanism")


def origin_of(folder: RunFolder) -> str:
    """Say where a run's data come from: the rig itself, or which simulation of it."""
    backend, seed = folder.manifest.get("backend"), folder.manifest.get("seed")
    if backend is None or backend == HARDWARE:
        return "measured on hardware" if backend else ""
    return f"simulation ({backend})" if seed is None else f"simulation ({backend}, seed {seed})"


def imprint_of(runs: Sequence[RunFolder]) -> str:
    """Say what a figure of some runs has to say by itself: what ran, when, and on what."""
    said = [_said(folder) for folder in runs]
    told = ["/".join(dict.fromkeys(filter(None, facts))) for facts in zip(*said, strict=True)]
    return ", ".join([*filter(None, told), *dict.fromkeys(map(origin_of, runs))])


def _said(folder: RunFolder) -> tuple[str, str, str, str]:
    manifest = folder.manifest
    day = manifest.get("started", "")[:_DAY]
    return manifest.get("experiment", ""), manifest.get("rig", ""), manifest.get("law", ""), day


def load_run(path: str | Path, log: LogColumns | None = None) -> RunData:
    """Load a run folder, whatever became of the run.

    Parameters
    ----------
    path : Path
        The run folder.
    log : LogColumns, optional
        Its log, if it has been read already.

    Raises
    ------
    ConfigurationError
        It is not a run folder.
    LogError
        It has no readable log.
    """
    folder = RunFolder.open(path)
    segments, _ = evaluation_from_json(folder.read_json(EVALUATION, Evaluation))
    return RunData(folder, log or read_columns(folder.log_path), segments, folder.metrics())
