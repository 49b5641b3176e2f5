"""The best points of a sweep as rows of text, for a terminal and for Python."""

import math

from rig.config.formats import format_quantity
from rig.sweeping.data import SweepData

SHOWN = 12
"""So many rows are shown."""


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
            data.statuses[number],
            *(
                _told(column.numbers[number], column.unit or "1")
                for column in data.metrics.values()
            ),
        )
        for number in data.order(metric)[:SHOWN]
    ]
    return header, rows


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
