"""What became of a point: no word in it tells where or when it ran."""

from typing import Final, TypedDict

MISSED: Final = "failed"
"""Status of points that ran to their end and missed a bound, or were flawed."""
DONE: Final = ("ok", MISSED)
"""Statuses of points that ran to their end."""
LOST: Final = "lost"
"""Status of a point whose worker died each time: it is tried again when the sweep is resumed."""


class MetricCell(TypedDict):
    """A metric of a point, SI."""

    name: str
    value: float
    unit: str
    bound: float | None
    kind: str | None


class PointFinding(TypedDict):
    """The end of a point.

    ``status`` is ``ok``, ``failed`` (a bound was missed), ``refused`` (it was never started),
    ``faulted``, ``aborted``, ``crashed`` or ``lost``; ``reason`` is a sentence, or empty.
    """

    point: str
    status: str
    reason: str
    metrics: list[MetricCell]


def refusal(point: str, error: Exception) -> PointFinding:
    """Return the finding of a point that cannot be started."""
    return PointFinding(point=point, status="refused", reason=one_line(str(error)), metrics=[])


def one_line(text: str) -> str:
    """Return a text as one line."""
    return " ".join(text.split())
