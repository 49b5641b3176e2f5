"""Files that somebody else may have written, read so that none can hang the program or fill it."""

import errno
import os
import pwd
import shlex
import stat
from pathlib import Path
from typing import BinaryIO, Final

from rig.hal.errors import ConfigurationError

_PIECE: Final = 1 << 20
"""Bytes that are read at once."""


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading, and nothing else: no pipe that waits, no endless device.

    Raises
    ------
    ConfigurationError
        It cannot be opened, or is something else.
    """
    try:
        # Looked at before it is opened: to open a device may already do something.
        if stat.S_ISREG(path.stat().st_mode):
            stream = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")
            if stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                return stream
            stream.close()
        what = "a directory" if path.is_dir() else "not a regular file"
        raise ConfigurationError(f"cannot read {path}: it is {what}")
    except OSError as error:
        raise ConfigurationError(f"cannot read {path}: {reason_unread(path, error)}") from error
    except ValueError as error:  # a NUL in the name
        raise ConfigurationError(f"cannot read {str(path)!r}: {error}") from error


def reason_unread(path: Path, error: OSError) -> str:
    """Return why a file or folder cannot be read; without permission, also what gives it."""
    reason = error.strerror or str(error)
    if not isinstance(error, PermissionError):
        return reason
    places = (*reversed(path.absolute().parents), path)
    closed = next((p for p in places if not _is_open(p)), path)
    return f"{reason}; give it: sudo chmod a+rX {shlex.quote(str(closed))}"


def _is_open(place: Path) -> bool:
    """Return whether a file may be read, or a folder be entered."""
    return os.access(place, os.X_OK if is_folder(place) else os.R_OK)


def reason_unwritten(path: Path, error: OSError) -> str:
    """Return why a file cannot be written; without permission, also what gives it."""
    reason = error.strerror or str(error)
    if not isinstance(error, PermissionError) and error.errno != errno.EROFS:
        return reason
    there = path.absolute()
    while not os.access(there, os.F_OK):
        there = there.parent
    if is_file(there) and not os.access(there.parent, os.W_OK):
        there = there.parent  # what is written whole replaces the file: the folder decides
    return f"{reason}; {how_to_write(there)}"


def how_to_write(there: Path) -> str:
    """Return what lets this user write in a folder, or over a file, that may not be written."""
    mount = there
    while not os.path.ismount(mount) and mount != mount.parent:
        mount = mount.parent
    if os.statvfs(there).f_flag & os.ST_RDONLY:
        return (
            "its file system is read-only: take another place, or sudo mount -o remount,rw "
            f"{shlex.quote(str(mount))}"
        )
    if os.access(there, os.W_OK):  # and yet it is refused, as by /sys: another owner may no more
        return "take another place"
    return f"take it: sudo chown $USER {shlex.quote(str(there))}"


def check_writable(folder: Path, what: str) -> None:
    """Find out whether files can be written below a folder, before anything moves for them.

    Parameters
    ----------
    folder : Path
        It need not be there yet.
    what : str
        Files, in the message: ``"calibrations of cylinder"``.

    Raises
    ------
    ConfigurationError
        They could not be written.
    """
    there = folder.absolute()
    while not os.access(there, os.F_OK):
        there = there.parent
    if not is_folder(there) or not os.access(there, os.W_OK | os.X_OK):
        raise ConfigurationError(
            f"{what} cannot be kept in {folder}: {there} cannot be written to; "
            f"{how_to_write(there)}; nothing has moved"
        )


def is_file(path: Path) -> bool:
    """Return whether there is a regular file; no where none can be, as with a name too long."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_folder(path: Path) -> bool:
    """Return whether there is a folder; no where none can be, as with a name too long."""
    try:
        return path.is_dir()
    except OSError:
        return False


def users_folder(variable: str, *below: str) -> Path:
    """Return a folder in which this user keeps something.

    Parameters
    ----------
    variable : str
        Of the environment; it may name the folder. A relative path counts for nothing: it would be
        another folder wherever somebody works, and filled by whoever filled that one.
    *below : str
        Where it is in the user's home otherwise.
    """
    said = Path(os.environ.get(variable, ""))
    if said.is_absolute():
        return said
    home = Path.home()
    return Path(home if home.is_absolute() else pwd.getpwuid(os.getuid()).pw_dir, *below)


def read_regular(path: Path, most: int) -> bytes:
    """Return the content of a regular file.

    Parameters
    ----------
    path : Path
        The file.
    most : int
        Bytes that it may have.

    Raises
    ------
    ConfigurationError
        It cannot be read, is no regular file, or is longer.
    """
    with open_regular(path) as stream:
        try:
            # By pieces: room for all that it may have would be taken, however short it is.
            pieces, left = [], most + 1
            while left and (piece := stream.read(min(_PIECE, left))):
                pieces.append(piece)
                left -= len(piece)
        except OSError as error:
            raise ConfigurationError(f"cannot read {path}: {error.strerror or error}") from error
    if not left:
        raise ConfigurationError(f"cannot read {path}: it has more than {most} bytes")
    return b"".join(pieces)
