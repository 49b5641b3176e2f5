"""What can be said of a phase before it has a timing: reach, ranges, balance, what a foot meets."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from controllers.gait.balance import from_edge, link_centres, margin, support_polygon
from controllers.gait.geometry import AXIS_NAMES, LEGS, LegGeometry
from controllers.gait.kinematics import inverse
from controllers.gait.phases import GaitPhase
from controllers.gait.soles import gap_between, heights_of, sole_corners
from controllers.motion import InfeasibleMotion

_POINTS = 100
"""Of a phase's path that are looked at."""
_ROUNDING = 1e-9
_EVEN = 2e-5
"""m; ground that differs by less is one. It is twice what the prints of a foot are apart that are
said in hundredths of a millimetre and of a degree."""


class BeyondLeg(InfeasibleMotion):
    """A leg does not reach, or a joint leaves its range: with other hips it might not."""


class MeetsGround(InfeasibleMotion):
    """A swinging sole is too low to clear the ground of its own footprints."""


class TwoHeights(InfeasibleMotion):
    """Two prints of a foot overlap and do not lie on one ground."""


class MeetsFoot(InfeasibleMotion):
    """A swinging sole comes over the one that stands."""


class OutOfBalance(InfeasibleMotion):
    """The robot would tip over though it stood still."""


def check_phase(
    geometry: LegGeometry, phase: GaitPhase, min_margin: float, points: int = _POINTS
) -> None:
    """Raise if a leg does not reach, a joint leaves its range, a foot meets something, or it tips.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    phase : GaitPhase
        Looked at in steps of its path.
    min_margin : float
        Least distance of the centre of mass from the edge of what the feet stand on, m.
    points : int
        Of its path that are looked at, beside its start.

    Raises
    ------
    BeyondLeg, MeetsGround, TwoHeights, MeetsFoot, OutOfBalance
        With the phase, the share of its path, the number and its bound.
    """
    limits = geometry.limits
    legs = phase.legs(geometry)
    swings = not all(phase.standing)
    if swings:
        _check_prints(geometry, phase)
        _check_overlap(geometry, phase, points)
    lowest = bent = _Worst()
    postures: list[list[float]] = []
    for k in range(points + 1):
        xi = k / points
        where = _where(phase, xi)
        posture: list[float] = []
        for leg, path in enumerate(legs):
            try:
                angles = inverse(geometry, path.at(xi), path.rotation(xi))
            except InfeasibleMotion as error:
                raise BeyondLeg(f"{where}, {LEGS[leg]} leg: {error}") from error
            posture += angles
            for joint, angle in enumerate(angles, 6 * leg):
                low, high = limits[joint]
                beyond = max(low - angle, angle - high)
                if beyond > max(_ROUNDING, bent.by):
                    words = (
                        f"{where}: {AXIS_NAMES[joint]} would be at {math.degrees(angle):.5g} deg, "
                        f"outside {math.degrees(low):g} … {math.degrees(high):g} deg"
                    )
                    bent = _Worst(beyond, words)
        postures.append(posture)
        if swings:
            lowest = max(lowest, _lowest(geometry, phase, xi, where))
    if bent.by:
        raise BeyondLeg(f"{bent.words}.")
    if lowest.by > _EVEN:
        raise MeetsGround(f"{lowest.words}.")
    _check_balance(geometry, phase, postures, min_margin)


def _where(phase: GaitPhase, xi: float) -> str:
    return f"{phase.name}, {100.0 * xi:.0f} % of the way"


def _check_balance(
    geometry: LegGeometry,
    phase: GaitPhase,
    postures: Sequence[Sequence[float]],
    min_margin: float,
) -> None:
    """Raise if the centre of mass is too near the edge of the feet that stand, were it at rest."""
    path = [k / (len(postures) - 1) for k in range(len(postures))]
    waist = np.array([phase.waist_at(xi) for xi in path])
    yaw = np.array([phase.yaw_at(xi) for xi in path])
    centre = link_centres(geometry, np.array(postures), waist, yaw).centre
    stands = support_polygon(geometry, phase.feet, phase.standing, phase.attitudes)
    inside = margin(stands, centre[:, :2])
    worst = int(np.argmin(inside))
    if inside[worst] < min_margin:
        raise OutOfBalance(
            f"{_where(phase, path[worst])}: the centre of mass would be "
            f"{from_edge(float(inside[worst]))}, were it ever so slow; the bound is "
            f"{min_margin * 1e3:g} mm inside."
        )


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
    gap = gap_between(*soles)
    if gap >= 0.0:
        return
    apart = max(
        abs(one - other)
        for sole in soles
        for one, other in zip(*(heights_of(at, lies, sole) for at, lies in places), strict=True)
    )
    if apart > _EVEN:
        raise TwoHeights(
            f"{phase.name}: the {LEGS[leg]} print overlaps the one before it by "
            f"{-gap * 1e3:.1f} mm, and the ground there would have two heights, "
            f"{apart * 1e3:.3g} mm apart."
        )


def _check_overlap(geometry: LegGeometry, phase: GaitPhase, points: int) -> None:
    """Raise if the sole that swings comes over the one that stands, with where it does most."""
    swings = 0 if phase.standing[1] else 1
    stands = 1 - swings
    other = sole_corners(geometry, phase.feet[stands], phase.attitude_at(stands, 0.0))
    gaps = []
    for k in range(points + 1):
        xi = k / points
        sole = sole_corners(geometry, phase.foot_at(swings, xi), phase.attitude_at(swings, xi))
        gaps.append((gap_between(sole, other), xi))
    gap, xi = min(gaps)
    if gap < 0.0:
        raise MeetsFoot(
            f"{_where(phase, xi)}: seen from above the {LEGS[swings]} sole "
            f"would overlap the {LEGS[stands]} one by {-gap * 1e3:.3g} mm."
        )


def _lowest(geometry: LegGeometry, phase: GaitPhase, xi: float, where: str) -> _Worst:
    """Return how far the sole that swings is in the ground of its own prints."""
    swings = 0 if phase.standing[1] else 1
    lowest = _Worst()
    at, attitude = phase.foot_at(swings, xi), phase.attitude_at(swings, xi)
    sole = sole_corners(geometry, at, attitude)
    heights = heights_of(at, attitude, sole)
    for share in (0.0, 1.0):
        place, lies = phase.foot_at(swings, share), phase.attitude_at(swings, share)
        apart = gap_between(sole, sole_corners(geometry, place, lies))
        if apart >= 0.0:
            continue
        levels = heights_of(place, lies, sole)
        below = max(level - height for height, level in zip(heights, levels, strict=True))
        words = (
            f"{where}: the {LEGS[swings]} sole would be {below * 1e3:.3g} mm below where it "
            f"{'is to stand' if share else 'stood'}"
        )
        lowest = max(lowest, _Worst(below, words))
    return lowest
