"""One phase of a motion: what waist and feet do while the path parameter grows from 0 to 1."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from controllers.compiled import PlainNumbers
from controllers.gait.geometry import LegGeometry
from controllers.gait.kinematics import UPRIGHT, Rotation, Vector
from controllers.gait.turning import (
    FLAT,
    Attitude,
    LegTurning,
    PhaseTurning,
    attitude_at,
    eased,
    hip_in_foot,
    hip_velocity,
    rotation_of,
)

_UNTURNED = LegTurning()


@dataclass(frozen=True)
class LegPath(PlainNumbers):
    """The hip centre seen from the ankle, as a curve.

    A straight line, minus a half-sine lift of the foot, plus a bob of the waist.

    Parameters
    ----------
    start, travel : tuple of float
        Where it begins, and how far it goes, m.
    lift : float
        Of the foot in the middle, m; 0 for a foot that stands.
    bob : float
        Of the waist between rise and fall, m.
    share : float
        Of the path in which the bob rises, and again falls.
    turning : LegTurning
        If present, `start` and `travel` are the waist's from the sole's start, in the ground's
        frame, and the curve is seen from a foot that turns.
    """

    start: Vector
    travel: Vector
    lift: float
    bob: float
    share: float
    turning: LegTurning = _UNTURNED

    def at(self, xi: float) -> Vector:
        """Return the hip centre from the ankle, m."""
        (x, y, z), (dx, dy, dz) = self.start, self.travel
        if self.lift:
            z -= self.lift * math.sin(math.pi * xi)
        if self.bob:
            z += self.bob * _plateau(xi, self.share)
        x, y, z = x + xi * dx, y + xi * dy, z + xi * dz
        return hip_in_foot(self.turning, xi, x, y, z) if self.turning.present else (x, y, z)

    def held(self) -> "LegPath":
        """Return the path of a leg that stays at the start of this one."""
        its = self.turning
        return replace(
            self,
            travel=(0.0, 0.0, 0.0),
            lift=0.0,
            bob=0.0,
            turning=replace(its, turn=0.0, foot_turn=FLAT, foot_travel=(0.0, 0.0, 0.0)),
        )

    def tangent(self, xi: float) -> Vector:
        """Return the derivative of `at`, m."""
        x, y, z = self.travel
        if self.lift:
            z -= self.lift * math.pi * math.cos(math.pi * xi)
        if self.bob:
            z += self.bob * _plateau_slope(xi, self.share)
        if self.turning.present:
            return hip_velocity(self.turning, xi, self.at(xi), x, y, z)
        return (x, y, z)

    def rotation(self, xi: float) -> Rotation:
        """Return the rotation foot from waist."""
        turning = self.turning
        if not turning.present:
            return UPRIGHT
        sole = rotation_of(attitude_at(turning, xi))
        yaw = turning.yaw + xi * turning.turn
        s, c = math.sin(yaw), math.cos(yaw)
        first, second, third = zip(*sole, strict=True)
        return tuple([(c * a + s * b, c * b - s * a, d) for a, b, d in (first, second, third)])  # type: ignore[return-value]


class DurationSetting(NamedTuple):
    """The entry of a motion that says how long a phase lasts.

    Parameters
    ----------
    setting : str
        Its name: ``"swing_time"``; of a step's own time ``"shift"`` or ``"swing"``.
    step : int
        Number of the step whose own it is; 0: of none.
    """

    setting: str = ""
    step: int = 0


class GaitPhase(NamedTuple):
    """The motion of waist and feet, in the ground's frame: x ahead, y to the left.

    Parameters
    ----------
    name : str
        For people: ``"swing right 1"``.
    duration : float
        s.
    standing : tuple of bool
        Whether the right and the left foot bear the robot.
    waist, waist_travel : tuple of float
        Where the waist is at the start, and its straight way, m.
    feet : tuple of tuple of float
        Where the right and the left ankle are at the start, projected on the ground, m.
    step : float
        How far the foot that does not stand goes ahead, m.
    lift : float
        How high in the middle, m.
    bob : float
        How much higher the waist is in the middle of the phase, m.
    bob_share : float
        Of the path in which it rises, and again falls.
    turning : PhaseTurning, optional
        How waist and feet turn, and where the foot goes that does not stand; `step` then counts
        for nothing. None: straight ahead on level ground.
    only : int, optional
        The one leg that moves, as if the other were not there; for laws that have each leg on its
        own.
    timing : DurationSetting
        What says its duration.
    """

    name: str
    duration: float
    standing: tuple[bool, bool]
    waist: Vector
    waist_travel: Vector
    feet: tuple[Vector, Vector]
    step: float = 0.0
    lift: float = 0.0
    bob: float = 0.0
    bob_share: float = 0.15
    turning: PhaseTurning | None = None
    only: int | None = None
    timing: DurationSetting = DurationSetting()

    def legs(self, geometry: LegGeometry) -> tuple[LegPath, LegPath]:
        """Return the path of the right and of the left hip from its ankle."""
        right, left = (
            path if self.only in (None, leg) else path.held()
            for leg, path in enumerate(self._leg(geometry, leg) for leg in (0, 1))
        )
        return right, left

    def _leg(self, geometry: LegGeometry, leg: int) -> LegPath:
        swings = not self.standing[leg]
        (wx, wy, wz), (tx, ty, tz), (fx, fy, fz) = self.waist, self.waist_travel, self.feet[leg]
        if self.turning is not None:
            return LegPath(
                (wx - fx, wy - fy, wz - fz),
                self.waist_travel,
                self.lift if swings else 0.0,
                self.bob,
                self.bob_share,
                self._turning(geometry, leg),
            )
        return LegPath(
            (wx - fx, wy + geometry.side(leg) - fy, wz - fz - geometry.ankle_height),
            (tx - (self.step if swings else 0.0), ty, tz),
            self.lift if swings else 0.0,
            self.bob,
            self.bob_share,
        )

    def _turning(self, geometry: LegGeometry, leg: int) -> LegTurning:
        its = self.turning
        if its is None:
            return _UNTURNED
        swings = not self.standing[leg]
        return LegTurning(
            True,
            geometry.side(leg),
            geometry.ankle_height,
            its.yaw,
            its.turn,
            its.feet[leg],
            its.foot_turn if swings else FLAT,
            its.foot_travel if swings else (0.0, 0.0, 0.0),
        )

    @property
    def attitudes(self) -> tuple[Attitude, Attitude]:
        """How the right and the left sole lie at the start, rad."""
        return (FLAT, FLAT) if self.turning is None else self.turning.feet

    def yaw_at(self, xi: float) -> float:
        """Return the waist's heading, rad."""
        return 0.0 if self.turning is None else self.turning.yaw + xi * self.turning.turn

    def attitude_at(self, leg: int, xi: float) -> Attitude:
        """Return how a sole lies, rad."""
        its = self.turning
        if its is None or self.standing[leg]:
            return FLAT if its is None else its.feet[leg]
        (r, p, y), (dr, dp, dy), e = its.feet[leg], its.foot_turn, eased(xi)
        return (r + e * dr, p + e * dp, y + e * dy)

    def waist_at(self, xi: float) -> Vector:
        """Return the waist's position, m."""
        (x, y, z), (dx, dy, dz) = self.waist, self.waist_travel
        bob = self.bob * _plateau(xi, self.bob_share) if self.bob else 0.0
        return (x + xi * dx, y + xi * dy, z + xi * dz + bob)

    def foot_at(self, leg: int, xi: float) -> Vector:
        """Return the position of the point of the sole that is under the ankle, m."""
        x, y, z = self.feet[leg]
        if self.standing[leg]:
            return (x, y, z)
        lift = self.lift * math.sin(math.pi * xi)
        if self.turning is None:
            return (x + xi * self.step, y, z + lift)
        (dx, dy, dz), e = self.turning.foot_travel, eased(xi)
        return (x + e * dx, y + e * dy, z + xi * dz + lift)


def _plateau(xi: float, share: float) -> float:
    """Return a smooth step up over the first share of 0 … 1 and down over the last."""
    s = min(xi, 1.0 - xi) / share
    return 1.0 if s >= 1.0 else s * s * (3.0 - 2.0 * s)


def _plateau_slope(xi: float, share: float) -> float:
    s = min(xi, 1.0 - xi) / share
    if s >= 1.0:
        return 0.0
    slope = 6.0 * s * (1.0 - s) / share
    return slope if xi < 0.5 else -slope
