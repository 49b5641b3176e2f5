"""Serial lines, told from other devices before they are opened."""

import os
import re
from pathlib import Path
from typing import Final

_TERMINAL: Final = re.compile(r"/dev/(?:tty[A-Za-z]|pts/|rfcomm|cu\.).*")


def check_terminal(path: str) -> None:
    """Refuse what is no serial line, or is none any more behind its links.

    Raises
    ------
    OSError
        Only to open some other devices does something already: a watchdog starts.
    """
    real = os.path.realpath(path.partition("@")[0])
    if Path(real).exists() and not _TERMINAL.fullmatch(real):
        raise OSError(f"{path} is no serial line")
