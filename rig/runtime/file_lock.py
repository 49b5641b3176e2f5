"""Whether somebody still writes a file. Imports nothing that is slow."""

import fcntl
import os
from pathlib import Path


def is_locked(path: str | Path) -> bool:
    """Return whether a living process holds the file (see `LogRecorder`); False if it is absent."""
    try:
        fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe must not hold it up
    except OSError:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(fd)
    return False
