"""The fastest of a family of motions that a law still accepts."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.motions import WalkSettings
from controllers.gait.plan import GaitPlan
from controllers.motion import InfeasibleMotion

Walk = TypeVar("Walk", bound=WalkSettings | FootstepsSettings)

_RESOLUTION = 2e-3
"""Relative, of the speed that is found."""


def fastest(prepare: Callable[[Walk], GaitPlan], walk: Walk) -> Walk:
    """Return a walk at the highest speed for which a plan can be made, if it asks for that.

    Parameters
    ----------
    prepare : callable
        Makes a plan or raises `InfeasibleMotion`; what bounds the speed is up to it: joint
        rates, and the margin of the zero-moment point.
    walk : WalkSettings or FootstepsSettings
        It is only ever made faster.

    Raises
    ------
    InfeasibleMotion
        It cannot be done as it is.
    """
    if not walk.fastest:
        return walk
    prepare(walk)
    slow, factor = walk.speed, 2.0
    while _possible(prepare, replace(walk, speed=slow * factor)):
        slow *= factor
    fast = slow * factor
    while fast - slow > _RESOLUTION * slow:
        middle = 0.5 * (slow + fast)
        if _possible(prepare, replace(walk, speed=middle)):
            slow = middle
        else:
            fast = middle
    return replace(walk, speed=slow)


def _possible(prepare: Callable[[Walk], GaitPlan], walk: Walk) -> bool:
    try:
        prepare(walk)
    except InfeasibleMotion:
        return False
    return True
