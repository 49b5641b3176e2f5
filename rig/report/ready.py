"""A run's report by a copy of this process that is ready to draw when the run has ended.

What draws takes as long to import as to draw. While a simulation keeps one processor busy, a copy
of its process imports it on another.
"""

import contextlib
import multiprocessing
import os
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Self

from rig.hal import RigError
from rig.report.copies import begin, end_when_told, ending_quietly, may_copy
from rig.whole_file import clear_left_over


class ReadyReporter:
    """Writes a report at once; a context manager from before the run to after its report.

    Parameters
    ----------
    ahead : bool
        Get ready now, in a copy of this process if there can be one. False: nothing may disturb
        what goes on meanwhile, and the report is written in this process.
    """

    def __init__(self, *, ahead: bool) -> None:
        self._ahead = ahead

    def __enter__(self) -> Self:
        self._asking: Connection | None = None
        self._path: Path | None = None
        if self._ahead and may_copy():
            self._asking, asked = multiprocessing.Pipe()
            context = multiprocessing.get_context("fork")
            self._copy = context.Process(
                target=_write_when_asked, args=(self._asking, asked, os.getpid())
            )
            begin(self._copy)
            asked.close()
        return self

    def write(self, path: Path) -> list[str]:
        """Write the report of a run folder; return what it lacks, in sentences."""
        self._path = path
        if self._asking is not None:
            with contextlib.suppress(EOFError, OSError):  # whatever has ended it ends no report
                self._asking.send(path)
                told: list[str] = self._asking.recv()
                return told
        return written(path)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        if self._asking is not None:
            self._asking.close()
            self._copy.terminate()  # it has written its report, or is to write none
            self._copy.join()
            if self._path is not None and error is not None:  # it may have had no time to
                clear_left_over(self._path)


def written(path: Path) -> list[str]:
    """Write the report of a run folder; return what it lacks, in sentences."""
    from rig.report.regenerate import write_report

    try:
        made = write_report(path)
    except (RigError, OSError) as error:
        return [f"there is no report: {error}; draw it later with: rig report {path}"]
    return [*made.failures, *made.notes]


def _write_when_asked(asking: Connection, asked: Connection, parent: int) -> None:
    """Get ready, and write the report that is asked for, if one is, before this process ends."""
    end_when_told(parent)
    asking.close()  # else its end would never be seen
    with ending_quietly():
        from rig.report.figures import import_once

        try:
            import_once()
        except ImportError:  # whoever waits finds that out as well, and says it
            return
        with contextlib.suppress(EOFError, BrokenPipeError):  # nobody waits for it any more
            asked.send(written(asked.recv()))
