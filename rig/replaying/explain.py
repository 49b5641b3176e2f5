"""The inputs around a cycle of a log, for who looks for why a command differs."""

from rig.replaying.recorded import RecordedRun
from rig.replaying.verify import Difference

AROUND = 3
"""Cycles before and after the one in question."""

_INPUTS = ("phase", "fault", "clock", "reference", "reading")
"""Groups of columns that a law's command follows from."""


def explain(run: RecordedRun, difference: Difference) -> tuple[tuple[str, ...], list[list[str]]]:
    """Return a table of what went into the law around a difference.

    Returns
    -------
    header : tuple of str
        The column's name, then the cycles' numbers.
    rows : list of list of str
        One per column: the inputs, then the one that differs. Numbers have all their digits.
    """
    first = max(difference.row - AROUND, 0)
    here = slice(first, difference.row + AROUND + 1)
    log = run.log
    marks = ["*" if row == difference.row else "" for row in range(first, first + 2 * AROUND + 1)]
    header = (
        "column",
        *(f"{cycle}{mark}" for cycle, mark in zip(log.cycle[here].tolist(), marks, strict=False)),
    )
    names = [c.name for c in log.columns if c.name.partition(".")[0] in _INPUTS]
    if difference.column not in names:
        names.append(difference.column)
    units = {c.name: c.unit for c in log.columns}
    rows = [
        [
            f"{name} [{units[name]}]" if units[name] else name,
            *(repr(value) for value in log.column(name)[here].tolist()),
        ]
        for name in names
    ]
    return header, rows
