"""What is finished of a sweep: one line for each point, on the disk before the next one counts."""

import contextlib
import fcntl
import json
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, TypedDict, cast

from rig.hal import ConfigurationError, RigError
from rig.hal.files import is_folder, open_regular
from rig.spare_room import SpareRoom, append_line
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import PointFinding
from rig.typed_json import checked, parse
from rig.whole_file import refuse_link

JOURNAL = "points.jsonl"
_LOCK = ".lock"
_LONGEST: Final = 1 << 20
"""Bytes of a line: a hundred metrics and a reason take a hundredth of it."""


class _Metric(TypedDict):
    """A metric of a line; its value may be one that JSON does not have."""

    name: str
    value: object
    unit: str
    bound: float | None
    kind: str | None


class _Line(TypedDict):
    """A line of a journal."""

    point: str
    status: str
    reason: str
    metrics: list[_Metric]


class Journal:
    """The finished points of a sweep's folder, which one process at a time may add to.

    A line that a killed process left unfinished is cut off. Of each point the place of its line
    is kept in memory, and nothing else.

    Parameters
    ----------
    folder : Path
        The sweep's; made if it is not there.

    Raises
    ------
    ConfigurationError
        The folder cannot be made or written to.
    SweepStopped
        Another process works in it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._places: dict[bytes, int] = {}
        self._made = [path for path in (folder, *folder.parents) if not is_folder(path)]
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = _take_lock(folder / _LOCK, folder)
            self._spare = SpareRoom(folder)
            self._spare.take()
            self._fd = _open_own(folder / JOURNAL, os.O_APPEND)
            self._reader: BinaryIO = open_regular(folder / JOURNAL)
        except OSError as error:
            raise ConfigurationError(
                f"cannot keep a sweep in {folder}: {error.strerror or error}; choose another place "
                "with --out"
            ) from error
        try:
            self.read()
        except ConfigurationError:
            self.close()
            raise

    def __contains__(self, name: str) -> bool:
        return bytes.fromhex(name) in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, name: str) -> PointFinding:
        self._reader.seek(self._places[bytes.fromhex(name)])
        return cast("PointFinding", json.loads(self._reader.readline()))

    def add(self, finding: PointFinding) -> None:
        """Keep what became of a point; it is on the disk when this returns.

        Raises
        ------
        SweepStopped
            It cannot be written; what was kept before stays.
        """
        line = (json.dumps(finding, ensure_ascii=False) + "\n").encode()
        try:
            place = os.fstat(self._fd).st_size
            append_line(self._fd, line)
            os.fdatasync(self._fd)
        except OSError as error:
            self._spare.give_back()  # for the table of what is finished
            raise SweepStopped(
                str(self.folder / JOURNAL),
                f"{error.strerror or error}; what is finished is kept, and the same command "
                "goes on from there",
            ) from error
        self._places[bytes.fromhex(finding["point"])] = place

    def close(self) -> None:
        """Let go of the folder."""
        self._spare.give_back()
        self._reader.close()
        os.close(self._fd)
        os.close(self._lock)

    @contextlib.contextmanager
    def provisional(self, beside: Path) -> Iterator[None]:
        """Leave no trace of a sweep that is refused meanwhile, if nothing of it is finished.

        Parameters
        ----------
        beside : Path
            A folder that is made meanwhile, which goes as well.
        """
        try:
            yield
        except RigError:
            if not self._places:
                shutil.rmtree(beside, ignore_errors=True)
                self._spare.give_back()
                with contextlib.suppress(OSError):  # where somebody keeps something, it stays
                    for name in (JOURNAL, _LOCK):
                        (self.folder / name).unlink()
                    for path in self._made:
                        path.rmdir()
            raise

    def read(self) -> None:
        """Find again what is finished: an interrupt may have come between a line and its place.

        Raises
        ------
        ConfigurationError
            The file is no journal.
        """
        whole = 0
        self._reader.seek(0)
        count = 0
        try:
            for line in self._lines():
                self._places[_name_in(line)] = whole
                whole += len(line)
                count += 1
        except (ConfigurationError, ValueError, RecursionError) as error:
            raise ConfigurationError(
                f"{self.folder / JOURNAL} is no journal of a sweep, or of another version, after "
                f"line {count}: {error}; choose another folder with --out"
            ) from error
        os.ftruncate(self._fd, whole)

    def _lines(self) -> Iterator[bytes]:
        while line := self._reader.readline(_LONGEST + 1):
            if len(line) > _LONGEST:
                raise ValueError(f"a line of it has more than {_LONGEST} bytes")
            if line.endswith(b"\n"):
                yield line


def _name_in(line: bytes) -> bytes:
    """Return the name of the point that a line tells of.

    Raises
    ------
    ConfigurationError, ValueError, RecursionError
        It is no line of a journal.
    """
    finding = checked(parse(line.decode()), _Line, "the next")
    for metric in finding["metrics"]:
        if not isinstance(metric["value"], float | int):
            raise ValueError(f"the next has no number for {metric['name']}")
    return bytes.fromhex(finding["point"])


def _open_own(path: Path, flags: int = 0) -> int:
    """Open a file of a sweep's folder for writing, and no other to which a link there leads.

    Raises
    ------
    OSError
        It cannot be opened.
    """
    refuse_link(path)
    how = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC | flags
    descriptor = os.open(path, how, 0o644)
    if stat.S_ISREG(os.fstat(descriptor).st_mode):
        return descriptor
    os.close(descriptor)
    raise OSError(f"{path.name} is not a regular file")


def _take_lock(path: Path, folder: Path) -> int:
    descriptor = _open_own(path)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        who = os.read(descriptor, 32).decode(errors="replace").strip() or "unknown"
        os.close(descriptor)
        raise SweepStopped(
            str(folder), f"another sweep works here (process {who}); wait for it, or take another "
            "folder with --out"
        ) from None  # fmt: skip
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"{os.getpid()}\n".encode())
    return descriptor
