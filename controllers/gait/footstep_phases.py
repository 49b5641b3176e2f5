"""From footprints to the phases of a walk: stances, how high the hips may be, shifts and swings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from controllers.gait.footprints import Footstep, SteppingSettings
from controllers.gait.footstep_checks import BeyondLeg
from controllers.gait.geometry import LEGS, LegGeometry
from controllers.gait.ground_plane import GroundPlane
from controllers.gait.kinematics import Vector
from controllers.gait.phases import DurationSetting, GaitPhase
from controllers.gait.turning import Attitude, PhaseTurning, rotation_of
from controllers.motion import InfeasibleMotion

_STAYS = 1e-3
"""m and rad; a foot that goes no farther comes down where it stood."""


class Sole(NamedTuple):
    """A footprint: the point under the ankle, m, and how the sole lies, rad."""

    at: Vector
    attitude: Attitude

    def ankle(self, geometry: LegGeometry) -> Vector:
        """Return where the ankle is, m."""
        up = [row[2] for row in rotation_of(self.attitude)]
        x, y, z = (a + geometry.ankle_height * b for a, b in zip(self.at, up, strict=True))
        return (x, y, z)


class Stance(NamedTuple):
    """The waist over one foot, while the other one goes from a print to the next.

    Parameters
    ----------
    leg : int
        That swings: 0 right, 1 left.
    support : Sole
        On which the robot stands.
    before, after : Sole
        Of the foot that swings.
    over : tuple of float
        x and y of the waist, and the height of the standing ankle, m.
    yaw : float
        Heading of the waist, rad.
    """

    leg: int
    support: Sole
    before: Sole
    after: Sole
    over: Vector
    yaw: float


@dataclass(frozen=True)
class Walk:
    """Footprints with the stances that lead over them."""

    stances: tuple[Stance, ...]
    start: tuple[Sole, Sole]
    end: tuple[Sole, Sole]


def walk_over(geometry: LegGeometry, settings: SteppingSettings, steps: Sequence[Footstep]) -> Walk:
    """Return the stances that lead over footprints.

    Raises
    ------
    InfeasibleMotion
        A foot would come down where it stands.
    """
    spacing = geometry.hip_half_spacing
    ground = GroundPlane(settings.start_pitch, settings.start_roll)
    lies: Attitude = (settings.start_roll, settings.start_pitch, 0.0)
    feet = [Sole((0.0, y, ground.height(0.0, y)), lies) for y in (-spacing, spacing)]
    start, stances, yaw = (feet[0], feet[1]), [], 0.0
    for number, step in enumerate(steps, 1):
        leg = LEGS.index(step.foot)
        before, support = feet[leg], feet[1 - leg]
        # The shorter way round: a heading of 350 degrees is one of -10.
        heading = before.attitude[2] + math.remainder(step.heading - before.attitude[2], math.tau)
        after = Sole((step.x, step.y, step.height), (step.roll, step.pitch, heading))
        gone = math.dist(before.at, after.at), math.dist(before.attitude, after.attitude)
        if max(gone) < _STAYS:
            raise InfeasibleMotion(
                f"step {number}: the {step.foot} foot would come down where it stands; leave it "
                "out, or let it go a millimetre at least."
            )
        yaw = support.attitude[2]
        x, y, z = support.ankle(geometry)
        out = (settings.sway - 1.0) * geometry.side(1 - leg)
        s, c = math.sin(yaw), math.cos(yaw)
        midway = [0.5 * (a + b) - e for a, b, e in zip(before.at, after.at, (x, y, z), strict=True)]
        along = c * midway[0] + s * midway[1]
        ahead = settings.ahead + min(max(along, -settings.follow), settings.follow)
        over = (x + c * ahead - s * out, y + s * ahead + c * out, z)
        stances.append(Stance(leg, support, before, after, over, yaw))
        feet[leg] = after
    return Walk(tuple(stances), start, (feet[0], feet[1]))


class AnkleTooFar(BeyondLeg):
    """An ankle is too far from its hip at whatever height.

    Attributes
    ----------
    step : int
        That put it there.
    """

    def __init__(self, message: str, step: int) -> None:
        super().__init__(message)
        self.step = step


class HipNeed(NamedTuple):
    """The greatest height of the hips that a foot permits.

    Parameters
    ----------
    step : int
        The number of the step that put it there, or the feet it stands among.
    hips : float
        At most, above the standing ankle, m.
    """

    step: int
    hips: float


class _Station(NamedTuple):
    """A place of the waist at an end of one of its straight ways.

    Parameters
    ----------
    words : str
        Where it is.
    at : tuple of float
        x and y, and the height of what the hips' height counts from, m.
    yaw : float
        Heading, rad.
    soles : tuple
        Of each leg that matters there: its number, the sole, and the step that put it there.
    """

    words: str
    at: Vector
    yaw: float
    soles: tuple[tuple[int, Sole, int], ...]


def _stations(geometry: LegGeometry, settings: SteppingSettings, walk: Walk) -> list[_Station]:
    """Return the ends of all ways of the waist.

    Where the foot that stays behind is farthest, it is the step before that went too far ahead.
    """
    between = "with the waist midway between the feet"
    heading = 0.5 * sum(sole.attitude[2] for sole in walk.end)
    ends = [
        _Station(
            f"{words}, {between}", _midway(geometry, settings, feet, yaw, 0.0), yaw,
            ((0, feet[0], step), (1, feet[1], step)),
        )
        for words, feet, yaw, step in (
            ("step 1, before it begins", walk.start, 0.0, 1),
            (f"step {len(walk.stances)}, in the end", walk.end, heading, len(walk.stances)),
        )
    ]  # fmt: skip
    stances = [
        _Station(
            f"step {number} ({LEGS[its.leg]}), with the waist over the standing foot", its.over,
            its.yaw,
            (
                (1 - its.leg, its.support, number),
                (its.leg, its.before, max(number - 1, 1)),
                (its.leg, its.after, number),
            ),
        )
        for number, its in enumerate(walk.stances, 1)
    ]  # fmt: skip
    return [ends[0], *stances, ends[1]]


def hip_needs(geometry: LegGeometry, settings: SteppingSettings, walk: Walk) -> list[HipNeed]:
    """Return how high each foot lets the hips be; the lowest sets the height of the whole walk.

    Along a straight way of the waist a hip is farthest from its ankle at an end, so these count.
    """
    reach = geometry.distance(settings.knee_min)
    needs: list[HipNeed] = []
    too_high = ""
    for words, (x, y, height), yaw, soles in _stations(geometry, settings, walk):
        s, c = math.sin(yaw), math.cos(yaw)
        for leg, sole, step in soles:
            side = geometry.side(leg)
            ankle = sole.ankle(geometry)
            out = math.hypot(x - s * side - ankle[0], y + c * side - ankle[1])
            most = ankle[2] - height + math.sqrt(max(reach**2 - out**2, 0.0))
            if out >= reach or most <= 0.0:
                away = f"{out * 1e3:.1f} mm away from under its hip"
                if out < reach:
                    away = f"{(height - ankle[2]) * 1e3:.1f} mm below the standing one, {away}"
                raise AnkleTooFar(
                    f"{words}: the {LEGS[leg]} ankle would be {away}; a leg with its knee at "
                    f"{math.degrees(settings.knee_min):g} deg reaches {reach * 1e3:.1f} mm.",
                    step,
                )
            if settings.hip is not None and settings.hip > most and not too_high:
                too_high = (
                    f"{words}: hips at {settings.hip * 1e3:.1f} mm over the standing ankle leave "
                    f"the {LEGS[leg]} foot out of reach"
                )
            needs.append(HipNeed(step, most))
    if too_high:
        lowest = math.floor(min(need.hips for need in needs) * 1e4) / 10
        raise InfeasibleMotion(f"{too_high}; at {lowest:.1f} mm all steps would be in reach.")
    return needs


def walk_phases(
    geometry: LegGeometry,
    settings: SteppingSettings,
    steps: Sequence[Footstep],
    walk: Walk,
    hip: float,
) -> tuple[tuple[GaitPhase, ...], tuple[int, ...]]:
    """Return the phases, and the number of the step that each belongs to."""
    feet = list(walk.start)
    yaw = 0.0
    waist = _midway(geometry, settings, walk.start, yaw, hip)
    phases: list[GaitPhase] = []
    numbers: list[int] = []

    def shift(
        number: int, to: Vector, heading: float, time: float, timing: DurationSetting
    ) -> None:
        nonlocal waist, yaw
        travel = (to[0] - waist[0], to[1] - waist[1], to[2] - waist[2])
        if math.hypot(*travel) < _STAYS and abs(heading - yaw) < _STAYS:
            return  # the same foot swings once more
        turning = PhaseTurning(yaw, heading - yaw, (feet[0].attitude, feet[1].attitude))
        phases.append(
            GaitPhase(
                f"shift {len(phases) and number}", time / settings.speed, (True, True), waist,
                travel, (feet[0].at, feet[1].at), turning=turning, timing=timing,
            )
        )  # fmt: skip
        numbers.append(max(number, 1))
        waist, yaw = to, heading

    for number, (step, stance) in enumerate(zip(steps, walk.stances, strict=True), 1):
        x, y, z = stance.over
        usual = "shift_time" if number > 1 else "first_shift_time"
        timing = DurationSetting("shift", number) if step.shift else DurationSetting(usual)
        time = step.shift or getattr(settings, usual)
        shift(number - 1, (x, y, z + hip), stance.yaw, time, timing)
        go = tuple(b - a for a, b in zip(stance.before.at, stance.after.at, strict=True))
        turn = tuple(
            b - a for a, b in zip(stance.before.attitude, stance.after.attitude, strict=True)
        )
        turning = PhaseTurning(
            yaw, 0.0, (feet[0].attitude, feet[1].attitude), (turn[0], turn[1], turn[2]),
            (go[0], go[1], go[2]),
        )  # fmt: skip
        phases.append(
            GaitPhase(
                f"swing {step.foot} {number}",
                (step.swing or settings.swing_time) / settings.speed,
                (stance.leg == 1, stance.leg == 0),
                waist,
                (0.0, 0.0, 0.0),
                (feet[0].at, feet[1].at),
                lift=step.lift or settings.lift,
                turning=turning,
                timing=DurationSetting("swing", number)
                if step.swing
                else DurationSetting("swing_time"),
            )
        )
        numbers.append(number)
        feet[stance.leg] = stance.after
    heading = 0.5 * (feet[0].attitude[2] + feet[1].attitude[2])
    end = _midway(geometry, settings, (feet[0], feet[1]), heading, hip)
    last = DurationSetting("last_shift_time")
    shift(len(steps), end, heading, settings.last_shift_time, last)
    return tuple(phases), tuple(numbers)


def _midway(
    geometry: LegGeometry,
    settings: SteppingSettings,
    feet: tuple[Sole, Sole],
    heading: float,
    hip: float,
) -> Vector:
    """Return where the waist is midway between both ankles, or as far ahead as it is to be, m."""
    ankles = [sole.ankle(geometry) for sole in feet]
    x, y, z = (0.5 * (a + b) for a, b in zip(*ankles, strict=True))
    x, y = x + settings.ahead * math.cos(heading), y + settings.ahead * math.sin(heading)
    return (x, y, z + hip)
