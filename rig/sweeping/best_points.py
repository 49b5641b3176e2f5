"""The best points of a sweep as rows of text, for a terminal and for Python."""

import math

from rig.hal.formats import format_quantity
from rig.sweeping.data import SweepData

SHOWN = 12
"""So many rows are shown."""
_BETWEEN = 3
"""Characters that a drawn table has beside each column."""


def best_points(
    data: SweepData, metric: str | None
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return a header and the rows of the best points, the best first.

    Parameters
    ----------
    data : SweepData
        Of the points, with a metric at least.
    metric : str or None
        What they are best in; default: the first one.
    """
    header = (*data.settings, "status", *data.metrics)
    rows = [
        (
            *(str(values[number]) for values in data.settings.values()),
            data.ending(number),
            *(
                _told(column.numbers[number], column.unit or "1")
                for column in data.metrics.values()
            ),
        )
        for number in data.order(metric)[:SHOWN]
    ]
    return header, rows


def fitting(
    header: tuple[str, ...], rows: list[tuple[str, ...]], wanted: str, room: float
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the columns that fit beside each other; a number that is folded cannot be read.

    Parameters
    ----------
    header, rows
        As of `best_points`.
    wanted : str
        The metric that stays whatever room there is, as settings and status do.
    room : float
        Characters of a line.
    """
    widths = [max(map(len, column)) + _BETWEEN for column in zip(header, *rows, strict=True)]
    first = header.index("status") + 1
    kept = {*range(first), header.index(wanted)}
    left = room - sum(widths[number] for number in kept)
    for number in range(first, len(header)):
        if number not in kept:
            left -= widths[number]
            if left < 0:
                break
            kept.add(number)
    order = sorted(kept)
    return tuple(header[k] for k in order), [tuple(row[k] for k in order) for row in rows]


def _told(value: float, unit: str) -> str:
    return "never" if math.isinf(value) else format_quantity(value, unit)


def as_columns(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return lines of text whose columns stand below each other."""
    lines = [header, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
