"""Files that are whole or not there, and never somewhere else than where they seem to be."""

import contextlib
import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Final

_TEMPORARY: Final = re.compile(r"\.([0-9]+)\.(.+)")
"""Of a process by its number, for a file of that name."""


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the name of a new file to write, which takes its place at the end of the block.

    Whoever sends a folder may have put links into it: what is written must not follow one out.

    Parameters
    ----------
    path : Path
        Its place: a file's, or nobody's.

    Raises
    ------
    OSError
        There is a link, or it cannot be written; what was there is as it was.
    """
    refuse_link(path)
    if path.exists() and not path.is_file():
        raise OSError("there is something else than a file")
    temporary = path.with_name(f".{os.getpid()}.{path.name}")  # writers look at the suffix
    temporary.unlink(missing_ok=True)
    try:
        with _held(temporary):
            yield temporary
            temporary.replace(path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def clear_left_over(folder: Path, name: str | None = None) -> None:
    """Take away what processes that were killed had begun to write in a folder.

    Parameters
    ----------
    folder : Path
        It need not be there; where a link leads is not looked at.
    name : str, optional
        Of the file that was to be written; default: any.
    """
    if folder.is_symlink():
        return
    with contextlib.suppress(OSError):
        for path in list(folder.iterdir()):
            found = _TEMPORARY.fullmatch(path.name)
            if found is not None and name in (None, found[2]) and _is_left_over(path, found[1]):
                path.unlink()


def _is_left_over(path: Path, process: str) -> bool:
    """Return whether nobody writes a file any more, here or where processes count otherwise."""
    if Path("/proc", process).exists() or path.is_symlink() or not path.is_file():
        return False
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # a container has it, say
        return False
    finally:
        os.close(descriptor)
    return True


@contextlib.contextmanager
def _held(temporary: Path) -> Iterator[None]:
    """Make a file, and lock it for as long as it is being written: nobody takes it away."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
    descriptor = os.open(temporary, flags, 0o644)
    try:
        with contextlib.suppress(OSError):  # not every file system can
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Give a folder to fill, which takes its place at the end of the block, or is gone.

    Parameters
    ----------
    path : Path
        Its place, which is nobody's yet.

    Raises
    ------
    OSError
        There is something, or it cannot be written; nothing is left.
    """
    temporary = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        temporary.mkdir()
        yield temporary
        temporary.rename(path)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text, whole or not at all; it is on the disk when this returns.

    Raises
    ------
    OSError
        See `whole_file`.
    """
    with whole_file(path) as temporary, temporary.open("w", encoding="utf-8") as stream:
        stream.write(text)
        stream.flush()
        os.fsync(stream.fileno())


def refuse_link(path: Path) -> None:
    """Refuse a link in the place of a file or a folder that is to be written.

    Raises
    ------
    OSError
        It is one.
    """
    if path.is_symlink():
        raise OSError(f"it is a link to {path.readlink()}; remove it")
