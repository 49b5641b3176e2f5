"""Whether joints do what they are told."""

from collections.abc import Sequence
from typing import Final

from drivers.dynamixel import registers as table
from drivers.dynamixel.health import HealthWatch
from drivers.dynamixel.settings import DynamixelSettings
from drivers.servos.encoder_watch import EncoderWatch
from drivers.servos.following_error import FollowingWatch
from rig.hal import Reading, Vector

_JUMP: Final = 1.5  # times the greatest speed: faster is no motion that was asked for


class MotionWatch:
    """Finds joints that do not follow, and positions that cannot be true.

    Parameters
    ----------
    settings : DynamixelSettings
        Bounds.
    steps : sequence of float
        Of each joint's position, rad.
    health : HealthWatch
        Keeps the faults.

    Attributes
    ----------
    blind : set of int
        Joints whose encoders were found to lie: they cannot be held.
    jumped : dict of int to float
        Joints whose positions jumped, and where to, rad.
    """

    def __init__(
        self, settings: DynamixelSettings, steps: Sequence[float], health: HealthWatch
    ) -> None:
        joints = settings.joints.values()
        self._fastest = tuple(_JUMP * joint.max_speed for joint in joints)
        self._ranges = tuple(joint.limits for joint in joints)
        self._slacks = tuple(2.0 * abs(step) for step in steps)
        self._joints = tuple(
            FollowingWatch(settings.following_window, settings.following_time) for _ in joints
        )
        self._health = health
        self._encoders = tuple(EncoderWatch(step) for step in steps)
        self.blind: set[int] = set()
        self.jumped: dict[int, float] = {}

    def reset(self, positions: Vector, now: float) -> None:
        """Start from where the joints stand, rad."""
        for watch, position in zip(self._joints, positions, strict=True):
            watch.reset(position, now)
        self.blind.clear()
        self.jumped.clear()
        for encoder in self._encoders:
            encoder.reset()

    def drift(self, velocities: Sequence[float], positions: Vector, period: float) -> None:
        """Move the references of joints on that follow velocities (rad/s) for a period (s)."""
        for watch, velocity, position in zip(self._joints, velocities, positions, strict=True):
            watch.drift(velocity, position, period)

    def refer(self, setpoints: Vector) -> None:
        """Take the references of joints that follow positions, rad."""
        for watch, setpoint in zip(self._joints, setpoints, strict=True):
            watch.reference = setpoint

    def check(self, reading: Reading[Vector], velocities: Vector) -> None:
        """Raise if a joint is off its reference, or its encoder lies.

        Raises
        ------
        DeviceFault
            One has been farther off than it may for longer than it may.
        """
        positions, t = reading
        for k, encoder in enumerate(self._encoders):
            lie = encoder.look(t, positions[k], velocities[k])
            if lie is not None:
                self.blind.add(k)
                raise self._health.describe(k, f"cannot be trusted: {lie}", table.PRESENT_POSITION)
        for k, (watch, position) in enumerate(zip(self._joints, positions, strict=True)):
            duration = watch.exceeds(position, t)
            if duration:
                raise self._health.describe(
                    k,
                    "does not follow its setpoint; it is blocked, overloaded or without torque",
                    table.PRESENT_POSITION,
                    f"{watch.error:+.3g} rad for {duration:.2f} s",
                    f"{watch.window:g} rad for {watch.time:g} s",
                )

    def move_zeros(self, setpoints: Vector, positions: Vector, period: float) -> Vector:
        """Return the setpoints that leave joints which have jumped where they are, rad; once.

        A servo whose zero has gone turns its joint by as much, unless it is told where it stands
        by its new count. One that jumps again is not believed, and one beyond its limits would
        refuse the setpoint.
        """
        moved = list(setpoints)
        for k, then in self.jumped.items():
            low, high = self._ranges[k]
            if abs(positions[k] - then) <= self._fastest[k] * period + self._slacks[k]:
                moved[k] = min(max(positions[k], low), high)
        self.jumped.clear()
        return tuple(moved)

    def find_jump(self, before: Reading[Vector], positions: Sequence[float], t: float) -> None:
        """Latch a fault if a joint cannot have come so far since the last reading."""
        last, then = before
        elapsed = t - then
        for k, (position, fastest, slack) in enumerate(
            zip(positions, self._fastest, self._slacks, strict=True)
        ):
            reach = fastest * elapsed + slack
            if not -reach <= position - last[k] <= reach:
                self.jumped[k] = position
                self._health.latch(
                    k,
                    "jumped; somebody moved its zero, or the joint was struck",
                    table.PRESENT_POSITION,
                    f"{position - last[k]:+.3g} rad",
                    f"{reach:.3g} rad in {1e3 * elapsed:.1f} ms",
                )
