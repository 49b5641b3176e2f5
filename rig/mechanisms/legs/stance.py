"""Whether the legs stand as their encoders say, before anything moves."""

from typing import Final

import numpy as np

from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.leg_postures import Array, leg_posture
from rig.hal import SafetyError, Vector

_MIRROR: Final = np.array((-1.0, -1.0, 1.0, 1.0, 1.0, -1.0))
"""Of a leg's joints beside those of the other one, where both stand alike."""
_ALIKE: Final = 0.1
"""Legs need not stand alike, nor soles be level: it counts this much beside soles that differ."""
_OFF: Final = 1.5
"""So far an encoder may be off, rad."""


def check_stance(geometry: LegGeometry, positions: Vector, bound: float) -> None:
    """Raise if the soles of legs that stand would not both lie on the ground.

    An encoder that is off cannot be seen while its joint rests, and a walk that begins with it
    falls. Of legs that stand it shows: their soles are flat on one ground, however that slopes.

    Parameters
    ----------
    geometry : LegGeometry
        Dimensions.
    positions : tuple of float
        The twelve joints as they are, rad.
    bound : float
        Greatest angle between the soles, rad.

    Raises
    ------
    SafetyError
        With the angle, and the encoder that explains it best by being off alone.
    """
    q = np.array(positions, dtype=np.float64)
    right, left = _soles(geometry, q)
    tilt = float(np.arctan2(np.linalg.norm(np.cross(right, left)), right @ left))
    if tilt <= bound:
        return
    axis, off = _encoder_that_is_off(geometry, q)
    raise SafetyError(
        f"by the encoders the soles are {np.degrees(tilt):.3g} deg apart, at most "
        f"{np.degrees(bound):.3g} deg on a floor (legs.start_tilt): {AXIS_NAMES[axis]} would "
        f"explain it, if its encoder is off by {np.degrees(off):.3g} deg. If all encoders are "
        f"right the legs do not stand: put both soles flat on the floor, or let start_tilt be "
        f"null if they hang"
    )


def _soles(geometry: LegGeometry, q: Array) -> tuple[Array, Array]:
    """Return which way right and left sole look, seen from the waist."""
    right, left = (leg_posture(geometry, leg, q[None]).foot[0, :, 2] for leg in (0, 1))
    return right, left


def _encoder_that_is_off(geometry: LegGeometry, q: Array) -> tuple[int, float]:
    """Return the joint, and how far its encoder is off, rad, with which the legs stand best.

    Of two joints that could turn a sole as much, the one is meant with which both legs stand alike
    and the soles look up.
    """
    from scipy.optimize import minimize_scalar  # a fifth of a second, where a walk is refused

    def stands_badly(off: float, axis: int) -> float:
        tried = q.copy()
        tried[axis] -= off
        right, left = _soles(geometry, tried)
        apart = float(np.sum((right - left) ** 2))
        unlike = float(np.sum((tried[:6] - _MIRROR * tried[6:]) ** 2))
        sloping = float(np.sum((right[:2] + left[:2]) ** 2))
        return apart + _ALIKE**2 * (unlike + sloping)

    def best(axis: int) -> tuple[float, int, float]:
        found = minimize_scalar(stands_badly, args=(axis,), bounds=(-_OFF, _OFF), method="bounded")
        return float(found.fun), axis, float(found.x)

    _, axis, off = min(best(axis) for axis in range(len(q)))
    return axis, off
