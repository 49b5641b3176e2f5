"""The whole traceback of a bug, in the folder of the run that it ended."""

import contextlib
import traceback
from pathlib import Path
from typing import Final

_FILE: Final = "traceback.txt"
_SAID: Final = "the whole traceback: "


def keep_traceback(folder: Path, bug: BaseException) -> None:
    """Write all of a bug's traceback into a run folder, and note with the bug where it is.

    Parameters
    ----------
    folder : Path
        The run's.
    bug : BaseException
        What ended it.
    """
    path = folder / _FILE
    # Where nothing can be written the run's own books say so.
    with contextlib.suppress(OSError):
        path.write_text("".join(traceback.format_exception(bug)), encoding="utf-8")
        bug.add_note(f"{_SAID}{path}")
