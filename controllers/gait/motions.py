"""What an experiment may ask of the legs."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, Le, Unit

from controllers.gait.geometry import LEGS, LegGeometry
from controllers.gait.phases import DurationSetting, GaitPhase
from controllers.motion import InfeasibleMotion

Duration = Annotated[float, Unit("s"), Gt(0)]
NEARLY_STRAIGHT = math.radians(1.0)
"""rad; of the straightest knee, if nothing else is asked for."""

Knee = Annotated[float, Unit("rad"), Ge(0), Le(1.5)]


class GaitRequest(ABC):
    """A motion that an experiment asks of the legs; what has a default need not be written."""

    __slots__ = ()

    @property
    def distance(self) -> float:
        """How far the waist is to go, m."""
        return 0.0

    def advance(self, geometry: LegGeometry) -> float:
        """Return the same for legs of these dimensions, m."""
        return self.distance

    @property
    def bob(self) -> "BobSettings | None":
        """How the waist rises while a leg swings; None: it does not."""
        return None

    def without_bob(self) -> "GaitRequest":
        """Return the same motion with the waist at constant height."""
        return self

    @abstractmethod
    def phases(self, geometry: LegGeometry) -> tuple[GaitPhase, ...]:
        """Return the phases of the motion, in their order."""


@dataclass(frozen=True, slots=True)
class BobSettings:
    """A waist that rises while one leg swings, so that the other one can straighten.

    Parameters
    ----------
    support_knee : float
        Knee angle of the leg that stands, in the middle of the swing, rad.
    share : float
        Of the swing in which the waist rises, and again sinks.

    Notes
    -----
    At half a degree the knee is near enough to straight for its torque; a leg that touches the
    straight position while the other moves on would leave it on an undetermined branch.
    """

    support_knee: Annotated[float, Unit("rad"), Interval(ge=math.radians(0.5), le=1.0)] = (
        NEARLY_STRAIGHT
    )
    share: Annotated[float, Interval(gt=0.0, le=0.5)] = 0.15


@dataclass(frozen=True, slots=True)
class WalkSettings(GaitRequest):
    """A walk that is in balance at every instant, with the hip at constant height.

    The waist moves in a straight line from over one ankle to over the next while both feet
    stand, and rests while a foot swings. A knee is nearly straight whenever a foot lands and
    whenever the waist arrives, and only then.

    Parameters
    ----------
    landings : int
        How often a foot lands. Three are right, left, right; six read the paper's "three steps"
        as three of each leg.
    step : float
        Between successive footprints, m.
    lift : float
        Of the swinging foot, half a sine, m.
    sway : float
        How far aside the waist goes, as a share of the way to the ankle.
    knee_min : float
        Angle of the straightest knee, at landings and arrivals, rad; it sets the hip's height.
    first_shift_time, shift_time, swing_time : float
        s at speed 1. With 3, 6 and 9 s the near-singular instants fall where the paper's
        photographs (a), (e) and (h) show them.
    speed : float
        By what all times, a law's ramps included, are shortened.
    fastest : bool
        Whether to go on from that speed to the highest that the balance's bound and the joints'
        rates permit.
    bob : BobSettings, optional
        None: constant height, as in the paper.
    first : str
        The foot that swings first.
    ahead : float
        How far the waist is ahead of the ankle that it is over, m; negative behind it.
    hip : float, optional
        The hips' height above the ankles, m, instead of what follows from `knee_min`.

    References
    ----------
    Kameta et al., section 5 and Fig. 5.
    """

    landings: Annotated[int, Interval(ge=1, le=50)] = 3
    step: Annotated[float, Unit("m"), Gt(0), Le(1.0)] = 0.040
    lift: Annotated[float, Unit("m"), Gt(0), Le(0.1)] = 0.020
    sway: Annotated[float, Interval(ge=0.0, le=2.0)] = 1.0
    knee_min: Knee = NEARLY_STRAIGHT
    first_shift_time: Duration = 3.0
    shift_time: Duration = 6.0
    swing_time: Duration = 9.0
    speed: Annotated[float, Gt(0), Le(100)] = 1.0
    fastest: bool = False
    bob: BobSettings | None = None
    first: Literal["right", "left"] = "right"
    ahead: Annotated[float, Unit("m"), Ge(-0.2), Le(0.2)] = 0.0
    hip: Annotated[float, Unit("m"), Gt(0)] | None = None

    @property
    def distance(self) -> float:
        """How far the feet go, m."""
        return self.landings * self.step

    def hip_height(self, geometry: LegGeometry) -> float:
        """Return the hips' height above the ankles, m.

        Raises
        ------
        InfeasibleMotion
            The step is longer than the leg permits.
        """
        if self.hip is not None:
            return self.hip
        aside = self.sway * geometry.hip_half_spacing
        farthest = self.step + abs(self.ahead)
        square = geometry.distance(self.knee_min) ** 2 - farthest**2 - aside**2
        if square <= 0.0:
            raise InfeasibleMotion(
                f"a step of {self.step * 1e3:g} mm with {aside * 1e3:g} mm of sway is out of the "
                f"reach of a leg of {geometry.reach * 1e3:g} mm."
            )
        return math.sqrt(square)

    def without_bob(self) -> "WalkSettings":
        """Return the same walk with the hip at constant height."""
        return replace(self, bob=None)

    def phases(self, geometry: LegGeometry) -> tuple[GaitPhase, ...]:
        """Return the phases of the walk, in their order."""
        hip, spacing = self.hip_height(geometry), geometry.hip_half_spacing
        height = hip + geometry.ankle_height
        aside = self.sway * spacing
        bob, share = 0.0, 0.15
        if self.bob is not None:
            reach = geometry.distance(self.bob.support_knee)
            out = math.hypot(aside, self.ahead)  # of the standing leg's hip from its ankle
            bob, share = math.sqrt(reach**2 - out**2) - hip, self.bob.share
            if bob <= 0.0:
                raise InfeasibleMotion(
                    f"bob: a support knee of {math.degrees(self.bob.support_knee):g} deg would "
                    f"lower the waist by {-bob * 1e3:.3g} mm; it is straighter without."
                )
        feet = [(0.0, -spacing, 0.0), (0.0, spacing, 0.0)]
        waist = (self.ahead, 0.0, height)
        phases = []
        other = LEGS.index(self.first) == 0
        for number in range(self.landings + 1):
            support = (number + other) % 2
            x, y, _ = feet[support]
            target = (x + self.ahead, math.copysign(aside, y), height)
            travel = (target[0] - waist[0], target[1] - waist[1], 0.0)
            timing = DurationSetting("shift_time" if number else "first_shift_time")
            time = getattr(self, timing.setting) / self.speed
            both = (feet[0], feet[1])
            phases.append(
                GaitPhase(f"shift {number}", time, (True, True), waist, travel, both, timing=timing)
            )
            waist = target
            if number == self.landings:
                break
            swing = 1 - support
            step = self.step if number == 0 else 2.0 * self.step
            phases.append(
                GaitPhase(
                    f"swing {LEGS[swing]} {number + 1}",
                    self.swing_time / self.speed,
                    (support == 0, support == 1),
                    waist,
                    (0.0, 0.0, 0.0),
                    both,
                    step,
                    self.lift,
                    bob,
                    share,
                    timing=DurationSetting("swing_time"),
                )
            )
            x, y, z = feet[swing]
            feet[swing] = (x + step, y, z)
        return tuple(phases)


@dataclass(frozen=True, slots=True)
class SquatSettings(GaitRequest):
    """Knees bends on both feet, down from and back to nearly or exactly straight knees.

    Parameters
    ----------
    depth : float
        How far the waist goes down, m.
    knee_min : float
        Knee angle at the top, rad; 0 is straight, where the literal equation of both legs in
        one system has no solution.
    time : float
        Of one way, s at speed 1.
    repeats : int
        How often down and up.
    speed : float
        By what all times, a law's ramps included, are shortened.
    """

    depth: Annotated[float, Unit("m"), Gt(0), Le(0.2)] = 0.040
    knee_min: Knee = 0.0
    time: Duration = 3.0
    repeats: Annotated[int, Interval(ge=1, le=100)] = 2
    speed: Annotated[float, Gt(0), Le(100)] = 1.0

    def phases(self, geometry: LegGeometry) -> tuple[GaitPhase, ...]:
        """Return the ways down and up, in their order."""
        spacing = geometry.hip_half_spacing
        top = geometry.distance(self.knee_min) + geometry.ankle_height
        feet = ((0.0, -spacing, 0.0), (0.0, spacing, 0.0))
        time, both, depth = self.time / self.speed, (True, True), self.depth
        timing = DurationSetting("time")
        phases = []
        for number in range(1, self.repeats + 1):
            down, up = (0.0, 0.0, top), (0.0, 0.0, top - depth)
            for name, start, travel in (("down", down, -depth), ("up", up, depth)):
                phases.append(
                    GaitPhase(
                        f"{name} {number}", time, both, start, (0.0, 0.0, travel), feet,
                        timing=timing,
                    )
                )  # fmt: skip
        return tuple(phases)
