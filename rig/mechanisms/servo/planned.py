"""Servo axes whose laws plan the whole motion before it begins."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from controllers.base import PlanningLaw
from rig.hal import Device, Freeze, Vector
from rig.hal.driver import AxisBounds
from rig.hal.motion import Followed, Motion
from rig.mechanisms.servo.axes import (
    AxisLimits,
    Command,
    Kinds,
    Reference,
    ServoAxes,
    State,
)
from rig.mechanisms.servo.settings import ServoSettings

_LONGEST_FREEZE = 10.0
"""Frozen setpoints are not looked at for longer, s."""

_SLACK = 1e-6
"""rad, and rad/s: rounding."""

Planned = TypeVar("Planned", bound=ServoSettings)


class PlannedMotion(Motion[Followed]):
    """A law's plan as the loop follows it.

    Parameters
    ----------
    rows : array-like, shape (n, columns)
        The plan's columns of the log, cycle by cycle.
    """

    waits = True
    """A late cycle holds the motion: what a law has not commanded must not be left out."""

    def __init__(self, rows: ArrayLike) -> None:
        self._rows = np.asarray(
            rows, dtype=np.float64
        )  # as tuples half an hour would be a gigabyte

    def sample(self, number: int) -> tuple[float, ...]:
        """Return the plan's columns of a cycle."""
        return tuple(self._rows[min(max(number, 0), len(self._rows) - 1)].tolist())


class PlannedAxes(ServoAxes[Planned, State, Reference, Command]):
    """Servo axes that follow what a law has planned.

    Parameters
    ----------
    settings : ServoSettings
        Devices and limits.
    devices : mapping
        The rig's devices by name.
    period : float
        The loop's period, s.

    Raises
    ------
    ConfigurationError
        The devices do not have each axis exactly once.
    """

    law = PlanningLaw

    section: ClassVar[str]
    """The mechanism's section of the profile."""

    kinds: ClassVar[Kinds[Any, Any, Any]]
    """The types of its state, reference and command."""

    def __init__(self, settings: Planned, devices: Mapping[str, Device], period: float) -> None:
        super().__init__(
            self.axis_limits(settings),
            settings.limits,
            *self.pick(self.section, settings, devices),
            self.kinds,
            period,
        )
        self.settings = settings
        self._followed = 0

    @classmethod
    @abstractmethod
    def axis_limits(cls, settings: Planned) -> AxisLimits:
        """Return the axes and what they may do."""

    @classmethod
    def longest_freeze(
        cls, settings: Planned, motion: Motion[Reference], period: float
    ) -> Freeze | None:
        """Return when the first joint would leave its limits that went on as it was.

        These are the range and `ServoLimits.following`, as in `ServoAxes.check`. Drives that
        follow positions stop sooner, at their last setpoint.
        """
        joints, slack = cls.axis_limits(settings), settings.limits.following
        found = Freeze(_LONGEST_FREEZE, 0.0, "")
        for tick in range(round(motion.duration / period) + 1):
            t = min(tick * period, motion.duration)
            reference = motion.at(t)
            for name, angle, speed, lower, upper in zip(
                joints.names, reference.positions, reference.velocities,
                joints.lower, joints.upper, strict=True,
            ):  # fmt: skip
                room = slack + (upper - angle if speed > 0.0 else angle - lower)
                if room < found.longest * abs(speed):
                    found = Freeze(max(room, 0.0) / abs(speed), t, f"range of {name}")
        return found

    @classmethod
    def beyond_drives(
        cls,
        settings: Planned,
        motion: Motion[Reference],
        drives: Mapping[str, AxisBounds],
        period: float,
    ) -> str | None:
        """Say which axis goes first where its drive does not, see `Mechanism.beyond_drives`.

        Only drives that are narrower than the axes' own limits are looked at: `limit` keeps
        setpoints within those.
        """
        joints = cls.axis_limits(settings)
        narrow = {
            k: drives[name]
            for k, (name, low, high, rate) in enumerate(zip(*joints, strict=True))
            if name in drives and not _holds(drives[name], low, high, rate)
        }
        before: Vector | None = None
        for tick in range(round(motion.duration / period) + 1 if narrow else 0):
            t = min(tick * period, motion.duration)
            wanted = motion.at(t).positions
            for k, drive in narrow.items():
                name = joints.names[k]
                angle = min(max(wanted[k], joints.lower[k]), joints.upper[k])
                if not drive.low - _SLACK <= angle <= drive.high + _SLACK:
                    return (
                        f"the motion takes {name} to {angle:.4g} rad at {t:.3f} s, "
                        f"its drive permits {drive.low:.4g} … {drive.high:.4g} rad"
                    )
                way = 0.0 if before is None else abs(wanted[k] - before[k])
                speed = min(way / period, joints.rates[k])
                if speed > drive.speed + _SLACK:
                    return (
                        f"the motion turns {name} at {speed:.4g} rad/s at {t:.3f} s, "
                        f"its drive permits {drive.speed:.4g} rad/s"
                    )
            before = wanted
        return None

    @classmethod
    def assemble(cls, settings: Planned, devices: Mapping[str, Device], period: float) -> Self:
        """Pick the devices that the settings name."""
        return cls(settings, devices, period)

    @classmethod
    def approach(cls, start: Reference, end: Reference, duration: float, t: float) -> Reference:
        """Return the minimum-jerk way between two postures at `t`."""
        return cls.approach_joints(cls.kinds.reference, start, end, duration, t)

    def start_limiting(self, state: State) -> None:
        """See `ServoAxes.start_limiting`."""
        super().start_limiting(state)
        self._followed = 0


def _holds(drive: AxisBounds, low: float, high: float, rate: float) -> bool:
    """Return whether a drive takes all that an axis may be asked for."""
    return drive.low <= low and high <= drive.high and rate <= drive.speed
