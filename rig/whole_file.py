"""Files that are whole or not there, and never somewhere else than where they seem to be."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path


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
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o644))
        yield temporary
        temporary.replace(path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


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
