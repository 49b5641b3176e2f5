"""The folder of compiled kernels, where the program may write neither beside itself nor at home.

Besides, whether there is a compiler.
"""

import os
import stat
import sys
import tempfile
from pathlib import Path

_NAME = "NUMBA_CACHE_DIR"
_TEMPORARY = ("/tmp", "/var/tmp", "/usr/tmp")


def keep_kernels() -> None:
    """Have numba keep what it compiles in the folder for temporary files, if nowhere else.

    Numba tries the folder of the sources and the user's cache by itself, and would compile in each
    process if it can write to neither. It reads this when it is imported.
    """
    if _NAME in os.environ or _is_writable(_beside()):
        return
    # What is kept there runs: a relative one would be whoever's this working folder is.
    if _at_home().is_absolute() and _is_writable(_at_home()):
        return
    try:
        temporary = Path(tempfile.gettempdir())
        if not _is_named(temporary):
            return
        folder = temporary / f"rig-kernels-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return
    # What is kept there runs: it must be nobody else's, whoever was first to make the folder.
    is_own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    if is_own and not stat.S_IMODE(found.st_mode) & 0o077:
        os.environ[_NAME] = str(folder)


def check_compiler() -> None:
    """Refuse to go on where numba is told to compile nothing: kernels do not run as Python.

    Raises
    ------
    ConfigurationError
        It is told so, by the environment or by who has imported it.
    """
    numba = sys.modules.get("numba")
    said = os.environ.get("NUMBA_DISABLE_JIT", "").strip()
    is_off = said.isdecimal() and int(said) if numba is None else numba.config.DISABLE_JIT
    if is_off:
        from rig.hal import ConfigurationError

        raise ConfigurationError(
            "NUMBA_DISABLE_JIT is set, and this program's kernels run only compiled: unset it, "
            "and import numba after that"
        )


def _is_named(temporary: Path) -> bool:
    """Return whether a folder is one for temporary files, and not where Python makes do."""
    names = (os.environ.get(name, "") for name in ("TMPDIR", "TEMP", "TMP"))
    return str(temporary) in (*_TEMPORARY, *map(os.path.normpath, names))


def _beside() -> Path:
    return Path(__file__).parents[1] / "controllers" / "__pycache__"


def _at_home() -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache, "numba")


def _is_writable(path: Path) -> bool:
    """Return whether a folder can be written, or made where it is not yet there."""
    while not path.exists() and path != path.parent:
        path = path.parent
    return path.is_dir() and os.access(path, os.W_OK | os.X_OK)
