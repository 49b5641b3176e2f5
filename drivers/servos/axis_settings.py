"""What every servo driver's settings say of a joint, whatever the drive."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi
from typing import Annotated, Final, Self

from annotated_types import Gt, Interval, Unit

from rig.hal.driver import AxisBounds
from rig.hal.rising import Rising

_RISING: Final = Rising("limits")
SHORT: Final = 0.03
"""For so long an axis that nobody trusts may be away from its setpoint, s."""
_CAP: Final = 1.15
"""A drive needs more than the greatest speed to catch up with its setpoints, and its loop swings
over its cap by up to 7 % where an encoder lies to it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisSettings:
    """One joint: its mounting on the drive, and its limits.

    The joint's angle is ``± (turns of the drive's shaft) · 2π / gear + offset``.

    Parameters
    ----------
    gear : float
        Turns of the drive's shaft for one turn of the joint.
    reversed : bool
        The joint turns against its drive.
    offset : float
        The joint's angle where the drive counts 0, rad; found by calibration.
    limits : tuple of float
        The angles that may be commanded, rad.
    max_speed : float
        The fastest that may be commanded, rad/s. A reading that implies twice as much is a
        fault, and the drive is told to go no faster than 15 % more.
    """

    gear: Annotated[float, Unit("1"), Interval(ge=1e-3, le=1e5)] = 1.0
    reversed: bool = False
    offset: Annotated[float, Unit("rad"), Interval(ge=-1e3, le=1e3)] = 0.0
    limits: Annotated[tuple[float, float], Unit("rad"), _RISING] = (-pi, pi)
    max_speed: Annotated[float, Unit("rad/s"), Gt(0)] = 2.0

    def __post_init__(self) -> None:
        _RISING.check(self.limits)

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings of an axis that nobody trusts yet; see `DriverSettings.gentle`."""
        return replace(self, max_speed=min(self.max_speed, speed))

    @property
    def speed_cap(self) -> float:
        """Where the drive itself limits the joint's speed, rad/s: no setpoint comes near it."""
        return _CAP * self.max_speed

    @property
    def turns_per_radian(self) -> float:
        """Signed turns of the drive's shaft for one radian of the joint."""
        turns = self.gear / (2.0 * pi)
        return -turns if self.reversed else turns


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowingAxisSettings(AxisSettings):
    """One joint whose drive brakes it, and watches how well it follows.

    Parameters
    ----------
    deceleration : float
        With which the joint is brought to a standstill, rad/s².
    following_window, following_time : float
        How far (rad) and for how long (s) the joint may be from its reference.
    """

    deceleration: Annotated[float, Unit("rad/s^2"), Gt(0)] = 10.0
    following_window: Annotated[float, Unit("rad"), Interval(ge=1e-4, le=pi)] = 0.1
    following_time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 0.1

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings of an axis that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = AxisSettings.gentle(self, speed, window, effort)
        if window >= self.following_window:
            return slow
        short = min(self.following_time, SHORT)
        return replace(slow, following_window=window, following_time=short)


def bounds_of(axes: Mapping[str, AxisSettings]) -> dict[str, AxisBounds]:
    """Return beyond what `AxisGuard` refuses setpoints of axes, by their names."""
    return {name: AxisBounds(*axis.limits, axis.max_speed) for name, axis in axes.items()}
