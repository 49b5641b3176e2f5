"""What would fit instead of a step that cannot be done; tried in the digits that are said."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

from controllers.bisection import bisect
from controllers.gait.footprints import Footstep
from controllers.gait.footstep_checks import BeyondLeg, MeetsFoot, MeetsGround, TwoHeights
from controllers.gait.ground_plane import GroundPlane
from controllers.gait.turning import Attitude, Three

_ROUNDS = 12
_LEAST = 0.1
"""Share of a step that is tried at least, and between the shares that are tried first."""
_HIGHEST = 300
"""Lift, mm."""
HIGHER = (1.125, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0)
LOWER = (0.9, 0.8, 0.6, 0.4, 0.2)
"""Of the lift that is asked for, what is tried first."""
_FARTHER = (5, 10, 15, 20, 30, 40, 60)
"""By how much farther on or aside a print is tried, mm."""

Fits = Callable[[Footstep], bool]


class SwingSoles(NamedTuple):
    """Three soles of a step, each with its place (m) and attitude (rad).

    Parameters
    ----------
    support : tuple
        That stands.
    before, after : tuple
        Of the foot that swings.
    aside : float
        Where the foot that swings has its place beside the other one, m to the left.
    """

    support: tuple[Three, Attitude]
    before: tuple[Three, Attitude]
    after: tuple[Three, Attitude]
    aside: float


def advise(
    fits: Fits, asked: Footstep, lift: float, place: SwingSoles, name: str, error: object
) -> str:
    """Say what would fit instead of a step; empty if nothing that is tried does.

    Parameters
    ----------
    fits : callable
        Whether a step can be done in the place of this one.
    asked : Footstep
        The step.
    lift : float
        Of all steps that have none of their own, m.
    place : SwingSoles
        Where it begins and is to end.
    name : str
        ``"step 3 by itself"``.
    error : InfeasibleMotion
        Why it cannot be done.
    """
    if isinstance(error, TwoHeights):
        level = _on_ground_before(fits, asked, place, name)
        return level + _farther(fits, asked, place, name)[0]
    if isinstance(error, MeetsGround):
        # A foot that is lifted far more bends its knee and its ankle far more.
        farther, near = _farther(fits, asked, place, name)
        times = HIGHER[:3] if near else HIGHER
        said = _other_lift(fits, asked, lift, times, name) + farther
        return said or _shorter(fits, asked, place, name)
    said = _shorter(fits, asked, place, name)
    if isinstance(error, MeetsFoot):
        said += _aside(fits, asked, place, name)
    if not said and isinstance(error, BeyondLeg):
        said = _other_lift(fits, asked, lift, LOWER, name)
    return said


def _rounded(step: Footstep) -> Footstep:
    """Return a step in hundredths of millimetres and degrees, as it is said."""

    def angle(value: float) -> float:
        return math.radians(round(math.degrees(value), 2))

    return replace(
        step,
        x=round(step.x, 5),
        y=round(step.y, 5),
        height=round(step.height, 5),
        heading=angle(step.heading),
        pitch=angle(step.pitch),
        roll=angle(step.roll),
    )


def _words(step: Footstep, *, tilts: bool, heading: bool = True) -> str:
    words = f"x {step.x * 1e3:.2f} mm, y {step.y * 1e3:.2f} mm"
    if heading:
        words += f", heading {math.degrees(step.heading):.2f} deg"
    words += f", height {step.height * 1e3:.2f} mm"
    if tilts:
        pitch, roll = math.degrees(step.pitch), math.degrees(step.roll)
        words += f", pitch {pitch:.2f} deg, roll {roll:.2f} deg"
    return words


def nearest_lift(fits: Callable[[float], bool], own: float, times: Iterable[float]) -> int | None:
    """Return the lift that is nearest to the one that is asked for, of those that fit, mm.

    Parameters
    ----------
    fits : callable
        Whether a lift, m, would do.
    own : float
        The one that is asked for, m, which does not.
    times : iterable of float
        What it is multiplied by in the tries that come first.
    """
    fails = own = 1e3 * own

    def may(mm: int) -> bool:
        return 0 < mm <= _HIGHEST and fits(1e-3 * mm)

    for share in times:
        found = math.ceil(own * share) if share > 1.0 else math.floor(own * share)
        if not may(found):
            fails = found
            continue
        while abs(found - fails) > 1.0:
            middle = math.floor(0.5 * (found + fails) + 0.5)
            if middle == found:
                break
            if may(middle):
                found = middle
            else:
                fails = middle
        return found
    return None


def _other_lift(fits: Fits, asked: Footstep, lift: float, times: Iterable[float], name: str) -> str:
    """Return the lift of its own with which a step fits."""
    own = asked.lift or lift
    found = nearest_lift(lambda tried: fits(replace(asked, lift=tried)), own, times)
    if found is None:
        return ""
    return f" Lifted by {found} mm instead of {own * 1e3:.4g} mm {name} would fit."


def _farther(fits: Fits, asked: Footstep, place: SwingSoles, name: str) -> tuple[str, bool]:
    """Return the nearest print farther on, on the same ground, that fits; and if it is near."""
    (x, y, _), (bx, by, _) = place.after[0], place.before[0]
    way = math.hypot(x - bx, y - by)
    if way == 0.0:
        return "", False
    found = _moved(fits, asked, place, ((x - bx) / way, (y - by) / way))
    if found is None:
        return "", False
    far, its = found
    words = _words(its, tilts=False, heading=False)
    return f" {name.capitalize()} would fit {far} mm farther on, at {words}.", far <= _FARTHER[1]


def _aside(fits: Fits, asked: Footstep, place: SwingSoles, name: str) -> str:
    """Return the nearest print farther from the foot that stands, on the same ground, that fits."""
    yaw = place.support[1][2]
    side = math.copysign(1.0, place.aside)
    found = _moved(fits, asked, place, (-side * math.sin(yaw), side * math.cos(yaw)))
    if found is None:
        return ""
    far, its = found
    words = _words(its, tilts=False, heading=False)
    return f" {name.capitalize()} would fit {far} mm farther aside, at {words}."


def _moved(
    fits: Fits, asked: Footstep, place: SwingSoles, way: tuple[float, float]
) -> tuple[int, Footstep] | None:
    """Return by how many millimetres a print has to be moved along a way, on the same ground."""
    yaw = place.after[1][2]
    s, c = math.sin(yaw), math.cos(yaw)
    ground = GroundPlane(asked.pitch, asked.roll)

    def at(mm: int) -> Footstep:
        dx, dy = 1e-3 * mm * way[0], 1e-3 * mm * way[1]
        up = ground.height(c * dx + s * dy, c * dy - s * dx)
        moved = replace(asked, x=asked.x + dx, y=asked.y + dy, height=asked.height + up)
        its = _rounded(moved)
        return replace(asked, x=its.x, y=its.y, height=its.height)

    high = next((mm for mm in _FARTHER if fits(at(mm))), 0)
    if not high:
        return None
    low = max((mm for mm in _FARTHER if mm < high), default=0)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if fits(at(middle)) else (middle, high)
    return high, at(high)


def _on_ground_before(fits: Fits, asked: Footstep, place: SwingSoles, name: str) -> str:
    """Return the print on the ground on which the foot stood, if it fits there."""
    (bx, by, bz), (roll, pitch, yaw) = place.before
    (x, y, _), (_, _, heading) = place.after
    ground = GroundPlane(pitch, roll)
    s, c = math.sin(yaw), math.cos(yaw)
    up = ground.height(c * (x - bx) + s * (y - by), c * (y - by) - s * (x - bx))
    tilt = ground.tilt(heading - yaw)
    level = replace(asked, height=bz + up)
    its = _rounded(replace(level, pitch=tilt.pitch, roll=tilt.roll))
    level = replace(asked, height=its.height)
    tilted = replace(level, pitch=its.pitch, roll=its.roll)
    for step, tilts in ((level, False), (tilted, True)):
        if fits(step):
            words = f"a height of {step.height * 1e3:.2f} mm"
            if tilts:
                words += f", a pitch of {math.degrees(step.pitch):.2f} deg"
                words += f" and a roll of {math.degrees(step.roll):.2f} deg"
            return f" With {words} it would lie on the same ground, and {name} would fit."
    return ""


def _shorter(fits: Fits, asked: Footstep, place: SwingSoles, name: str) -> str:
    """Return how much of a step fits, from beside the standing foot to where it was to go."""
    (x, y, z), (roll, pitch, yaw) = place.support
    up = GroundPlane(pitch, roll).height(0.0, place.aside)
    s, c = math.sin(yaw), math.cos(yaw)
    beside = (x - s * place.aside, y + c * place.aside, z + up, yaw, pitch, roll)
    there = (*place.after[0], place.after[1][2], asked.pitch, asked.roll)
    tilts = (pitch, roll) != (asked.pitch, asked.roll)

    def part(share: float) -> Footstep:
        x, y, height, heading, pitch, roll = (
            a + share * (b - a) for a, b in zip(beside, there, strict=True)
        )
        step = replace(asked, x=x, y=y, height=height, heading=heading, pitch=pitch, roll=roll)
        its = _rounded(step)
        # What is not said stays as it is asked for.
        return its if tilts else replace(its, pitch=asked.pitch, roll=asked.roll)

    # Not all that is less fits: on the edge of a tread a short step is none.
    shares = (1.0 - _LEAST * k for k in range(1, round(1.0 / _LEAST)))
    share = next((share for share in shares if fits(part(share))), None)
    if share is None:
        return ""
    most = part(bisect(lambda at: fits(part(at)), share, share + _LEAST, _ROUNDS)[0])
    return f" From beside the standing foot {name} would fit as far as {_words(most, tilts=tilts)}."
