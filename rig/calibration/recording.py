"""What a procedure recorded, stretch by stretch; the simulation's truth is not in it."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from rig.calibration.arrays import Array
from rig.experiment.measure import PHASE_RUN
from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.hal import ConfigurationError, RigError
from rig.hal.motion import Segment
from rig.run_facts import EVALUATION
from rig.run_folder import RunFolder
from rig.runtime.log import Log, LogError, read_log

TRUTH = "truth."


class CalibrationRefused(RigError):
    """The data do not suffice, or their fit is worse than the one in force; nothing was changed."""


class RigLacks(CalibrationRefused):
    """The rig has not what the procedure takes; nothing was moved."""


class NoFiles(CalibrationRefused):
    """There are no files to read; what is in force stays."""


class Stretch(Mapping[str, Array]):
    """The rows of one segment, column by column; ``"t"`` is seconds since its reference began."""

    def __init__(self, columns: dict[str, Array]) -> None:
        self._columns = columns

    def __getitem__(self, name: str) -> Array:
        try:
            return self._columns[name]
        except KeyError:
            raise CalibrationRefused(f"the log has no column {name!r}") from None

    def __iter__(self) -> "Iterable[str]":  # type: ignore[override]
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def mean(self, name: str) -> float:
        """Return the mean of a column."""
        return float(self[name].mean())


class Recording:
    """One or several runs of a procedure: a later one completes what an earlier one left out."""

    def __init__(
        self, runs: Sequence[tuple[Log, Sequence[Segment]]], paths: Sequence[Path] = ()
    ) -> None:
        self.paths = tuple(paths)
        self._stretches: dict[str, Stretch] = {}
        for log, segments in runs:
            self._take(log, segments)

    @classmethod
    def of(cls, folders: Sequence[Path]) -> "Recording":
        """Read run folders.

        Raises
        ------
        CalibrationRefused
            One has no readable log.
        ConfigurationError
            One is not a run folder.
        """
        runs, paths = [], []
        for path in folders:
            folder = RunFolder.open(path)
            try:
                log = read_log(folder.log_path)
            except LogError as error:
                raise CalibrationRefused(str(error)) from error
            segments, _ = evaluation_from_json(folder.read_json(EVALUATION, Evaluation))
            runs.append((log, segments))
            paths.append(folder.log_path)
        return cls(runs, paths)

    def _take(self, log: Log, segments: Sequence[Segment]) -> None:
        if not len(log.t):
            return
        run = log.column("phase") == PHASE_RUN
        t = log.column("reference.time")
        last = float(t[run].max()) if run.any() else -np.inf
        columns = {c.name: log.column(c.name) for c in log.columns if not c.name.startswith(TRUTH)}
        for segment in segments:
            inside = run & (t >= segment.start) & (t < segment.end)
            # A stretch that was cut short is none: it would be judged as if it were whole.
            if last >= segment.end - 0.02 and inside.any():
                part = {name: values[inside] for name, values in columns.items()}
                self._stretches[segment.name] = Stretch({**part, "t": t[inside]})

    @property
    def names(self) -> tuple[str, ...]:
        """The stretches that are there as a whole."""
        return tuple(self._stretches)

    @property
    def samples(self) -> int:
        """Rows of all stretches."""
        return sum(len(stretch["t"]) for stretch in self._stretches.values())

    def __getitem__(self, name: str) -> Stretch:
        return self._stretches[name]

    def require(self, names: Iterable[str]) -> None:
        """Raise if a stretch is missing.

        Raises
        ------
        CalibrationRefused
            With what is missing.
        """
        wanted = list(names)
        missing = [name for name in wanted if name not in self._stretches]
        if missing:
            listed = ", ".join(missing[:4]) + (", …" if len(missing) > 4 else "")
            raise CalibrationRefused(
                f"{len(missing)} of {len(wanted)} stretches are missing or cut short: {listed}"
            )

    def sha256(self) -> str:
        """Return the digest of the raw logs, in hexadecimal digits."""
        digest = hashlib.sha256()
        for path in self.paths:
            digest.update(path.read_bytes())
        return digest.hexdigest()


def with_cycles(folders: Sequence[Path]) -> list[Path]:
    """Return the run folders whose log holds a cycle: of others there is nothing to go on from."""
    return [folder for folder in folders if _has_cycles(folder)]


def _has_cycles(folder: Path) -> bool:
    try:
        return len(read_log(RunFolder.open(folder).log_path).t) > 0
    except (LogError, ConfigurationError):
        return False
