"""Stop a run from another process: `rig stop`, and the form on the page of `rig watch`."""

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from time import sleep

from rig.hal import RigError
from rig.run_facts import EVENTS
from rig.run_folder import RunFolder

_LOCKS = Path("/proc/locks")
_MODE, _PROCESS, _FILE = 3, 4, 5
"""Fields of a line of it: ``1: FLOCK ADVISORY WRITE 4711 fe:01:123456 0 EOF``."""
_BETWEEN = 0.02
"""Between the two signals of a stop at once, s: each is heard by itself."""


class CannotStop(RigError):
    """There is nobody to be told, or no permission to tell it."""


def request_stop(run: str | Path, *, at_once: bool) -> int:
    """Ask a run to stop, as its operator does with Ctrl-C once, or twice.

    The process is the one that holds the run's lock; it is held by a descriptor from before that
    is looked up, so that no other one that got its number meanwhile can be meant.

    Parameters
    ----------
    run : Path
        Its folder.
    at_once : bool
        Not in an orderly way.

    Returns
    -------
    int
        Number of the process that was asked.

    Raises
    ------
    CannotStop
        The run has ended, or belongs to somebody else.
    """
    path = Path(run)
    for process in _candidates(path / EVENTS):
        try:
            with _process(process) as descriptor:
                if not _has_open(process, path / EVENTS):
                    continue
                signal.pidfd_send_signal(descriptor, signal.SIGINT)
                if at_once:
                    sleep(_BETWEEN)
                    _press_again(process, descriptor, path / EVENTS)
                return process
        except ProcessLookupError:
            continue
        except PermissionError as error:
            raise CannotStop(
                f"{path.name} is run by process {process}, which is somebody else's"
            ) from error
    if not (path / EVENTS).exists():
        raise CannotStop(f"nobody can tell whether {path.name} is running: it has no {EVENTS}")
    raise CannotStop(f"{path.name} is not running: there is nothing to stop")


def wait_for_end(run: str | Path, timeout: float, step: float = 0.05) -> bool:
    """Return whether a run let go of its folder within some seconds."""
    folder = RunFolder.open(run)
    for _ in range(max(int(timeout / step), 1)):
        if not folder.is_live():
            return True
        sleep(step)
    return False


def _press_again(process: int, descriptor: int, events: Path) -> None:
    """Send another signal, for two of one kind may come as one.

    Where nothing moved yet the first one was enough: the run has ended, and whoever draws its
    report is not to be killed by the second.
    """
    if process in _candidates(events):
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(descriptor, signal.SIGTERM)


@contextlib.contextmanager
def _process(number: int) -> Iterator[int]:
    descriptor = os.pidfd_open(number)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _candidates(path: Path) -> list[int]:
    """Return the processes that hold a lock on a file of this number, on whatever device.

    One that only looks whether there is a lock takes a shared one for an instant: not WRITE.
    """
    try:
        inode = str(path.stat().st_ino)
        lines = _LOCKS.read_text(encoding="ascii").splitlines()
    except OSError:
        return []
    fields = [line.split() for line in lines if " FLOCK " in line]
    return [
        int(field[_PROCESS])
        for field in fields
        if field[_MODE] == "WRITE" and field[_FILE].rpartition(":")[2] == inode
    ]


def _has_open(process: int, path: Path) -> bool:
    """Return whether it is this very file that a process has open."""
    wanted = path.stat()
    for entry in Path(f"/proc/{process}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):
            found = entry.stat()
            if (found.st_dev, found.st_ino) == (wanted.st_dev, wanted.st_ino):
                return True
    return False
