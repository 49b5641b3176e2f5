"""What a motion costs, by name: every run of a pneumatic mechanism reports it."""

from collections.abc import Sequence
from typing import Final

from rig.hal.formats import format_quantity
from rig.hal.motion import Segment

REPORTED = ("air_used", "valve_reversals", "setpoint_rate", "setpoint_range")
_CYCLES: Final = 3
"""In so many there are two samples, however a segment begins between them: rates need two."""


def check_measured(segments: Sequence[Segment], period: float) -> None:
    """Refuse a motion with a segment too short for what every run reports.

    Parameters
    ----------
    segments : sequence of Segment
        Of the motion.
    period : float
        The loop's, s.

    Raises
    ------
    ValueError
        A segment is shorter than some cycles, and yet of some length.
    """
    for segment in segments:
        lasts = segment.end - segment.start
        # None at all is a procedure that finds everything done: nothing is measured.
        if 0.0 < lasts < (_CYCLES - 1e-6) * period:
            raise ValueError(
                f"segment {segment.name!r} lasts {format_quantity(lasts, 's')}: what is measured "
                f"in it takes {_CYCLES} of the loop's cycles at least, "
                f"{format_quantity(_CYCLES * period, 's')}"
            )
