"""The folder that a run leaves behind: everything that was used, happened and came out."""

import contextlib
import fcntl
import json
import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol, TypeVar, cast

from rig import provenance
from rig.hal import ConfigurationError, RigError
from rig.hal.files import reason_unwritten
from rig.json_file import plain, write_json
from rig.plug_ins import plug_ins
from rig.run_facts import (
    EVENTS,
    FORMAT,
    LOG,
    MANIFEST,
    METRICS,
    TIMING,
    Event,
    Manifest,
    MetricRow,
    RunStatus,
    read_events,
    read_manifest,
    read_metrics,
)
from rig.runtime.file_lock import is_locked
from rig.spare_room import SpareRoom, append_line
from rig.typed_json import read_json
from rig.whole_file import refuse_link

Kind = TypeVar("Kind")

_CLOSED = (RunStatus.OK, RunStatus.FAILED, RunStatus.ABORTED)
"""After these the log is whole. A fault may have been that it could not be written."""


class _AsJson(Protocol):
    def as_json(self) -> Mapping[str, object]: ...


class RunFolderError(RigError):
    """A run folder cannot be read or written."""


class RunFolder:
    """One run on disk.

    `create` starts one, `open` looks at an existing one. The process that created the folder
    holds a lock on its events file until `finish`, so that everybody else can tell a run that
    goes on from one whose process was killed.

    Parameters
    ----------
    path : Path
        The folder.
    manifest : Manifest
        The content of its ``manifest.json``.
    """

    def __init__(self, path: Path, manifest: Manifest, events_fd: int | None = None) -> None:
        self.path = path
        self.manifest = manifest
        self._events_fd = events_fd
        self._spare = SpareRoom(path)

    @classmethod
    def create(
        cls,
        out: str | Path,
        experiment: str,
        backend: str,
        *,
        inputs: Mapping[str, str],
        seed: int | None = None,
        command: Sequence[str] = (),
        rig: str = "",
        law: str = "",
        now: datetime | None = None,
    ) -> "RunFolder":
        """Make a new folder ``<out>/<UTC stamp>-<experiment>-<backend>``.

        Parameters
        ----------
        out : Path
            Where run folders live; made if it is not there.
        experiment, backend : str
            Parts of the name.
        inputs : mapping of str to str
            Resolved input files by their path in the folder: ``profile.yaml``,
            ``experiment.yaml``, ``calibration/…``. They are written and hashed.
        seed : int, optional
            Seed of the simulation.
        command : sequence of str
            The words of the command line that repeats this run.
        rig, law : str
            Names of the profile and of its controller.
        now : datetime, optional
            Start; default: now.

        Raises
        ------
        ConfigurationError
            The folder cannot be made or written to.
        """
        started = datetime.now(UTC) if now is None else now.astimezone(UTC)
        path: Path | None = None
        try:
            path = make_unique(Path(out), f"{started:%Y-%m-%dT%H%M%SZ}-{experiment}-{backend}")
            events_fd = os.open(path / EVENTS, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            with contextlib.suppress(OSError):  # no locks on some network file systems
                fcntl.flock(events_fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for name, text in inputs.items():
                target = path / name
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(text, encoding="utf-8")
            manifest: Manifest = {
                "format": FORMAT,
                "status": RunStatus.RUNNING.value,
                "experiment": experiment,
                "backend": backend,
                "seed": seed,
                "rig": rig,
                "law": law,
                "command": list(command),
                "started": started.isoformat(timespec="milliseconds"),
                "ended": None,
                "exit_code": None,
                "message": None,
                "git": provenance.git_state(),
                "versions": provenance.versions(),
                "plug_ins": plug_ins(),
                "machine": provenance.machine(),
                "files": provenance.file_hashes(inputs),
            }
            write_json(path / MANIFEST, manifest)
            SpareRoom(path).take()
        except OSError as error:
            if path is not None:  # half of one looks like a run that goes on
                shutil.rmtree(path, ignore_errors=True)
            raise ConfigurationError(
                f"cannot make a run folder in {out}: {error.strerror or error}; "
                "choose another place with --out"
            ) from error
        return cls(path, manifest, events_fd)

    @classmethod
    def open(cls, path: str | Path) -> "RunFolder":
        """Open an existing folder; mark it crashed if its process died while it ran.

        Raises
        ------
        ConfigurationError
            It is not a run folder, or one that a later version recorded.
        """
        path = Path(path)
        folder = cls(path, read_manifest(path))
        if folder.status is RunStatus.RUNNING and not folder.is_live():
            # It may have finished since then.
            folder.manifest = read_manifest(path)
            if folder.status is RunStatus.RUNNING:
                folder._mark_crashed()
        return folder

    @property
    def status(self) -> RunStatus:
        """How the run stands or ended."""
        return RunStatus(self.manifest["status"])

    @property
    def log_path(self) -> Path:
        """Where the log is or will be."""
        return self.path / LOG

    def missing_end(self, *, complete: bool) -> str | None:
        """Say that a log lacks the end that its run came to; None if it has it, or had none.

        Parameters
        ----------
        complete : bool
            Whether the log says that it was closed.
        """
        if complete or self.status not in _CLOSED:
            return None
        return f"{self.log_path} was cut off: its run came to its end, and the log does not"

    def is_live(self) -> bool:
        """Return whether a living process still works on this run."""
        return is_locked(self.path / EVENTS) or is_locked(self.log_path)

    def record_event(self, t: float | None, kind: str, message: str, **data: object) -> None:
        """Append one line to the events; the kernel has it when this returns.

        Parameters
        ----------
        t : float or None
            Time on the rig's clock, s; None before there is one.
        kind : str
            ``"state"``, ``"limit"``, ``"fault"``, ``"mark"``, …
        message : str
            One sentence.
        **data
            Numbers and names that belong to it.

        Raises
        ------
        RunFolderError
            The line cannot be written.
        """
        if self._events_fd is None:
            raise RunFolderError(f"{self.path} is not open for writing")
        event = {"t": t, "kind": kind, "message": message, "data": data}
        line = (json.dumps(plain(event), ensure_ascii=False) + "\n").encode()
        descriptor = self._events_fd
        self._store(EVENTS, lambda: append_line(descriptor, line))

    def place(self, name: str) -> Path:
        """Return where a file of the folder is written, which is in no other folder.

        Raises
        ------
        ConfigurationError
            There is a link.
        """
        path = self.path
        try:
            for part in Path(name).parts:
                path /= part
                refuse_link(path)
        except OSError as error:
            raise ConfigurationError(f"cannot write {path}: {error}") from error
        return path

    def events(self) -> list[Event]:
        """Return the events; a line that is none, the torn last one say, is left out."""
        return read_events(self.path)

    def write_json(self, name: str, content: Mapping[str, object]) -> None:
        """Write one of the folder's JSON files, whole or not at all.

        Numbers that JSON does not have (infinite, not a number) are written as null.

        Raises
        ------
        RunFolderError
            It cannot be written.
        """
        self._store(name, lambda: write_json(self.path / name, content))

    def read_json(self, name: str, kind: type[Kind]) -> Kind:
        """Return the content of one of the folder's JSON files, ``{}`` if it is absent.

        Parameters
        ----------
        name : str
            The file's.
        kind : type
            A TypedDict of which no entry need be there.

        Raises
        ------
        ConfigurationError
            It holds something else.
        """
        path = self.path / name
        return read_json(path, kind) if os.path.lexists(path) else cast("Kind", {})

    def metrics(self) -> tuple[MetricRow, ...]:
        """Return the entries of ``metrics.json``."""
        return tuple(read_metrics(self.path))

    def write_metrics(self, metrics: Iterable[_AsJson]) -> None:
        """Write ``metrics.json`` from objects with an ``as_json`` method."""
        self.write_json(METRICS, {"metrics": [metric.as_json() for metric in metrics]})

    def write_timing(self, timing: Mapping[str, object]) -> None:
        """Write ``timing.json``: facts of the wall clock, which differ from run to run."""
        self.write_json(TIMING, timing)

    def finish(
        self,
        status: RunStatus,
        exit_code: int,
        message: str | None = None,
        facts: Mapping[str, object] | None = None,
    ) -> None:
        """Say how the run ended and let go of the folder.

        Parameters
        ----------
        status : RunStatus
            How it ended.
        exit_code : int
            Of the process.
        message : str, optional
            One sentence, e.g. the fault.
        facts : mapping, optional
            More for the manifest, e.g. the buses' counters.

        Raises
        ------
        RunFolderError
            The manifest cannot be written; the folder will be found crashed.
        """
        self.manifest.update(cast("Manifest", facts or {}))
        self.manifest["status"] = status.value
        self.manifest["exit_code"] = exit_code
        self.manifest["message"] = message
        self.manifest["ended"] = datetime.now(UTC).isoformat(timespec="milliseconds")
        try:
            self.write_json(MANIFEST, self.manifest)
        finally:
            self._spare.give_back()
            if self._events_fd is not None:
                os.close(self._events_fd)
                self._events_fd = None

    def _store(self, name: str, write: Callable[[], None]) -> None:
        try:
            self._spare.helping(write)
        except OSError as error:
            path = self.path / name
            raise RunFolderError(f"cannot write {path}: {reason_unwritten(path, error)}") from error

    def _mark_crashed(self) -> None:
        self._spare.give_back()
        last = self.log_path if self.log_path.exists() else self.path / EVENTS
        with contextlib.suppress(OSError):
            ended = datetime.fromtimestamp(last.stat().st_mtime, UTC)
            self.manifest["ended"] = ended.isoformat(timespec="milliseconds")
        self.manifest["status"] = RunStatus.CRASHED.value
        self.manifest["message"] = "the process died while the run went on"
        # A folder on read-only storage can still be looked at.
        with contextlib.suppress(OSError):
            write_json(self.path / MANIFEST, self.manifest)


def make_unique(out: Path, name: str) -> Path:
    """Make a folder that was not there; a second one of the name gets a suffix."""
    out.mkdir(parents=True, exist_ok=True)
    suffix = 1
    while True:
        path = out / (name if suffix == 1 else f"{name}-{suffix}")
        try:
            path.mkdir()
        except FileExistsError:
            suffix += 1
            continue
        return path
