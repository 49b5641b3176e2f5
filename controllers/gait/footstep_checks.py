"""What can be said of a phase before it has a timing: reach, ranges, and what a foot meets."""

import math

from controllers.gait.balance import sole_corners
from controllers.gait.geometry import AXIS_NAMES, LEGS, LegGeometry
from controllers.gait.kinematics import inverse
from controllers.gait.phases import GaitPhase
from controllers.gait.turning import Attitude, rotation_of
from controllers.motion import InfeasibleMotion

_POINTS = 100
"""Of a phase's path that are looked at."""
_ROUNDING = 1e-9

Corners = list[tuple[float, float]]


class BeyondLeg(InfeasibleMotion):
    """A leg does not reach, or a joint leaves its range: with other hips it might not."""


class MeetsGround(InfeasibleMotion):
    """A swinging sole is too low to clear the ground of its own footprints."""


def check_phase(geometry: LegGeometry, phase: GaitPhase) -> None:
    """Raise if a leg does not reach, a joint leaves its range, or a foot meets something.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    phase : GaitPhase
        Looked at in steps of its path.

    Raises
    ------
    BeyondLeg, InfeasibleMotion
        With the phase, the share of its path, the number and its bound.
    """
    limits = geometry.limits
    legs = phase.legs(geometry)
    for k in range(_POINTS + 1):
        xi = k / _POINTS
        where = f"{phase.name}, {100.0 * xi:.0f} % of the way"
        for leg, path in enumerate(legs):
            try:
                angles = inverse(geometry, path.at(xi), path.rotation(xi))
            except InfeasibleMotion as error:
                raise BeyondLeg(f"{where}, {LEGS[leg]} leg: {error}") from error
            for joint, angle in enumerate(angles, 6 * leg):
                low, high = limits[joint]
                if not low - _ROUNDING <= angle <= high + _ROUNDING:
                    raise BeyondLeg(
                        f"{where}: {AXIS_NAMES[joint]} would be at {math.degrees(angle):.2f} deg, "
                        f"outside {math.degrees(low):g} … {math.degrees(high):g} deg."
                    )
        if not all(phase.standing):
            _check_feet(geometry, phase, xi, where)


def _check_feet(geometry: LegGeometry, phase: GaitPhase, xi: float, where: str) -> None:
    swings = 0 if phase.standing[1] else 1
    stands = 1 - swings
    at, attitude = phase.foot_at(swings, xi), phase.attitude_at(swings, xi)
    sole = sole_corners(geometry, at, attitude)
    other = sole_corners(geometry, phase.feet[stands], phase.attitude_at(stands, xi))
    gap = _gap(sole, other)
    if gap < 0.0:
        raise InfeasibleMotion(
            f"{where}: seen from above the {LEGS[swings]} sole would overlap the {LEGS[stands]} "
            f"one by {-gap * 1e3:.1f} mm."
        )
    heights = _heights(at, attitude, sole)
    for share in (0.0, 1.0):
        place, lies = phase.foot_at(swings, share), phase.attitude_at(swings, share)
        apart = _gap(sole, sole_corners(geometry, place, lies))
        if apart >= 0.0:
            continue
        levels = _heights(place, lies, sole)
        below = max(level - height for height, level in zip(heights, levels, strict=True))
        if below <= _ROUNDING:
            continue
        if xi in (0.0, 1.0):
            raise InfeasibleMotion(
                f"{where}: the {LEGS[swings]} print overlaps the one before it by "
                f"{-apart * 1e3:.1f} mm, and the ground there would have two heights, "
                f"{below * 1e3:.3g} mm apart."
            )
        raise MeetsGround(
            f"{where}: the {LEGS[swings]} sole would be {below * 1e3:.3g} mm below where it "
            f"{'is to stand' if share else 'stood'}."
        )


def _heights(at: tuple[float, ...], attitude: Attitude, points: Corners) -> list[float]:
    """Return the height of a sole's plane at points of the ground, m."""
    normal = [row[2] for row in rotation_of(attitude)]
    return [
        at[2] - (normal[0] * (x - at[0]) + normal[1] * (y - at[1])) / normal[2] for x, y in points
    ]


def _gap(one: Corners, other: Corners) -> float:
    """Return how far two convex shapes are apart along the edge's normal that parts them best, m.

    Negative by how much they overlap. (Separating axes.)
    """
    best = -math.inf
    for first, second in ((one, other), (other, one)):
        for (ax, ay), (bx, by) in zip(first, first[1:] + first[:1], strict=True):
            length = math.hypot(bx - ax, by - ay)
            nx, ny = (by - ay) / length, (ax - bx) / length  # outwards: corners are anticlockwise
            best = max(best, min(nx * (x - ax) + ny * (y - ay) for x, y in second))
    return best
