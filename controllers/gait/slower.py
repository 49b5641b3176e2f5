"""The greatest speed at which a motion of the legs that is too quick would be accepted."""

import math
from collections.abc import Callable
from dataclasses import replace

from controllers.gait.footsteps import LegsMotion
from controllers.motion import InfeasibleMotion
from controllers.rounding import floor

_TRIES = 12
"""Speeds that are tried for one at which a motion is accepted."""
_SLOWER = 0.98
"""Of a speed that was tried, the next one at most."""
_ABOUT = 1.05
"""The same of a speed that is looked for where longer times would not do."""
_HALFWAY = 0.6
"""Of a speed that is refused, the next one that is tried."""
_NEARLY = 1.006
"""Times the speed that a refusal names it is refused, at most."""


class TooQuick(InfeasibleMotion):
    """A motion that would be accepted more slowly.

    Attributes
    ----------
    slower : float
        Speed at which its worst instant would be within bounds.
    """

    def __init__(self, message: str, slower: float) -> None:
        super().__init__(message)
        self.slower = slower


def name_speed(accept: Callable[[LegsMotion], None], motion: LegsMotion, refused: TooQuick) -> str:
    """Say at which speed a motion would be accepted, which is tried.

    Slower, its worst instant may be another one. `accept` raises what a motion is refused with.
    """
    speed, too_quick = refused.slower, motion.speed
    for _ in range(_TRIES):
        speed = floor(speed)
        try:
            accept(replace(motion, speed=speed))
        except TooQuick as error:
            too_quick = speed
            speed = min(error.slower, _SLOWER * speed)
        except InfeasibleMotion as error:
            return f"at a speed of {speed:g} it would be refused, too: {str(error).rstrip('.')}"
        else:
            speed = _greatest(accept, motion, speed, too_quick)
            return f"at a speed of {speed:g} instead of {motion.speed:.4g} it would fit"
    return "no speed was found at which it would fit"


def slower_speed(accept: Callable[[LegsMotion], None], motion: LegsMotion) -> float | None:
    """Return a speed that is accepted, of which a twentieth more is not; None: none was found.

    For a motion that is refused with something else than the speed that would do.
    """
    too_quick = motion.speed
    for _ in range(_TRIES):
        speed = floor(_HALFWAY * too_quick)
        try:
            accept(replace(motion, speed=speed))
        except InfeasibleMotion:
            too_quick = speed
        else:
            return _greatest(accept, motion, speed, too_quick, _ABOUT)
    return None


def _greatest(
    accept: Callable[[LegsMotion], None],
    motion: LegsMotion,
    fits: float,
    too_quick: float,
    nearly: float = _NEARLY,
) -> float:
    """Return a speed that is accepted, of which a little more is not."""
    while too_quick > nearly * fits:
        speed = floor(math.sqrt(fits * too_quick))
        try:
            accept(replace(motion, speed=speed))
        except InfeasibleMotion:
            too_quick = speed
        else:
            fits = speed
    return fits
