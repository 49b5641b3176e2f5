"""What can be said of a phase before it has a timing: reach, ranges, and what a foot meets."""

import math
from typing import NamedTuple

from controllers.gait.balance import sole_corners
from controllers.gait.geometry import AXIS_NAMES, LEGS, LegGeometry
from controllers.gait.kinematics import inverse
from controllers.gait.phases import GaitPhase
from controllers.gait.turning import Attitude, rotation_of
from controllers.motion import InfeasibleMotion

_POINTS = 100
"""Of a phase's path that are looked at."""
_ROUNDING = 1e-9
_EVEN = 2e-5
"""m; ground that differs by less is one. It is twice what the prints of a foot are apart that are
said in hundredths of a millimetre and of a degree."""

Corners = list[tuple[float, float]]


class BeyondLeg(InfeasibleMotion):
    """A leg does not reach, or a joint leaves its range: with other hips it might not."""


class MeetsGround(InfeasibleMotion):
    """A swinging sole is too low to clear the ground of its own footprints."""


class TwoHeights(InfeasibleMotion):
    """Two prints of a foot overlap and do not lie on one ground."""


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
    BeyondLeg, MeetsGround, TwoHeights, InfeasibleMotion
        With the phase, the share of its path, the number and its bound.
    """
    limits = geometry.limits
    legs = phase.legs(geometry)
    swings = not all(phase.standing)
    if swings:
        _check_prints(geometry, phase)
        _check_overlap(geometry, phase)
    lowest = bent = _Worst()
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
                beyond = max(low - angle, angle - high)
                if beyond > max(_ROUNDING, bent.by):
                    words = (
                        f"{where}: {AXIS_NAMES[joint]} would be at {math.degrees(angle):.5g} deg, "
                        f"outside {math.degrees(low):g} … {math.degrees(high):g} deg"
                    )
                    bent = _Worst(beyond, words)
        if swings:
            lowest = max(lowest, _lowest(geometry, phase, xi, where))
    if bent.by:
        raise BeyondLeg(f"{bent.words}.")
    if lowest.by > _EVEN:
        raise MeetsGround(f"{lowest.words}.")


class _Worst(NamedTuple):
    """The instant of a phase that is farthest beyond a bound.

    Parameters
    ----------
    by : float
        How far, m or rad.
    words : str
        The same in words.
    """

    by: float = 0.0
    words: str = ""


def _check_prints(geometry: LegGeometry, phase: GaitPhase) -> None:
    """Raise if the prints before and after a swing overlap and are not on one ground."""
    leg = 0 if phase.standing[1] else 1
    places = [(phase.foot_at(leg, xi), phase.attitude_at(leg, xi)) for xi in (0.0, 1.0)]
    soles = [sole_corners(geometry, at, lies) for at, lies in places]
    gap = _gap(*soles)
    if gap >= 0.0:
        return
    apart = max(
        abs(one - other)
        for sole in soles
        for one, other in zip(*(_heights(at, lies, sole) for at, lies in places), strict=True)
    )
    if apart > _EVEN:
        raise TwoHeights(
            f"{phase.name}: the {LEGS[leg]} print overlaps the one before it by "
            f"{-gap * 1e3:.1f} mm, and the ground there would have two heights, "
            f"{apart * 1e3:.3g} mm apart."
        )


def _check_overlap(geometry: LegGeometry, phase: GaitPhase) -> None:
    """Raise if the sole that swings comes over the one that stands, with where it does most."""
    swings = 0 if phase.standing[1] else 1
    stands = 1 - swings
    other = sole_corners(geometry, phase.feet[stands], phase.attitude_at(stands, 0.0))
    gaps = []
    for k in range(_POINTS + 1):
        xi = k / _POINTS
        sole = sole_corners(geometry, phase.foot_at(swings, xi), phase.attitude_at(swings, xi))
        gaps.append((_gap(sole, other), xi))
    gap, xi = min(gaps)
    if gap < 0.0:
        raise InfeasibleMotion(
            f"{phase.name}, {100.0 * xi:.0f} % of the way: seen from above the {LEGS[swings]} sole "
            f"would overlap the {LEGS[stands]} one by {-gap * 1e3:.3g} mm."
        )


def _lowest(geometry: LegGeometry, phase: GaitPhase, xi: float, where: str) -> _Worst:
    """Return how far the sole that swings is in the ground of its own prints."""
    swings = 0 if phase.standing[1] else 1
    lowest = _Worst()
    at, attitude = phase.foot_at(swings, xi), phase.attitude_at(swings, xi)
    sole = sole_corners(geometry, at, attitude)
    heights = _heights(at, attitude, sole)
    for share in (0.0, 1.0):
        place, lies = phase.foot_at(swings, share), phase.attitude_at(swings, share)
        apart = _gap(sole, sole_corners(geometry, place, lies))
        if apart >= 0.0:
            continue
        levels = _heights(place, lies, sole)
        below = max(level - height for height, level in zip(heights, levels, strict=True))
        words = (
            f"{where}: the {LEGS[swings]} sole would be {below * 1e3:.3g} mm below where it "
            f"{'is to stand' if share else 'stood'}"
        )
        lowest = max(lowest, _Worst(below, words))
    return lowest


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
