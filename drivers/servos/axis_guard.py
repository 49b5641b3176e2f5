"""The last check of what is sent to joints: range, and speed from one cycle to the next."""

from collections.abc import Mapping
from typing import Final

from drivers.servos.axis_settings import AxisSettings
from rig.hal import LimitExceeded, Vector

_ROUNDING: Final = 1e-9  # of a limit: not worth a fault


class AxisGuard:
    """Refuse setpoints that no correct program sends, before they reach a drive.

    Mechanisms limit their commands; this is for what they got wrong: a stale position, an
    angle in degrees, not a number.

    Parameters
    ----------
    device : str
        The device's name in the profile.
    joints : mapping of str to AxisSettings
        In order.
    period : float
        Of the cycle, s.

    Attributes
    ----------
    positions : tuple of float
        The last setpoints, rad.
    """

    __slots__ = ("_device", "_names", "_ranges", "_speeds", "_steps", "positions")

    def __init__(self, device: str, joints: Mapping[str, AxisSettings], period: float) -> None:
        self._device = device
        self._names = tuple(joints)
        self._ranges = tuple(
            (low - _ROUNDING * (high - low), high + _ROUNDING * (high - low))
            for low, high in (joint.limits for joint in joints.values())
        )
        self._speeds = tuple((1.0 + _ROUNDING) * joint.max_speed for joint in joints.values())
        # Differences of positions round where speeds do not.
        self._steps = tuple(speed * period + 1e-12 for speed in self._speeds)
        self.positions: Vector = (0.0,) * len(self._names)

    def check_positions(self, positions: Vector) -> None:
        """Take the setpoints of this cycle.

        Raises
        ------
        LimitExceeded
            One is out of range, too far from the one before, or not a number; none is taken.
        """
        for k, (position, before, (low, high), step) in enumerate(
            zip(positions, self.positions, self._ranges, self._steps, strict=True)
        ):
            if not low <= position <= high:
                raise LimitExceeded(self._what(k, "position setpoint"), position, low, high, "rad")
            if not -step <= position - before <= step:
                raise LimitExceeded(
                    self._what(k, "position setpoint"),
                    position,
                    before - step,
                    before + step,
                    "rad",
                )
        self.positions = positions

    def check_velocities(self, velocities: Vector) -> None:
        """Look at the setpoints of this cycle.

        Raises
        ------
        LimitExceeded
            One is too fast, or not a number.
        """
        for k, (velocity, speed) in enumerate(zip(velocities, self._speeds, strict=True)):
            if not -speed <= velocity <= speed:
                raise LimitExceeded(
                    self._what(k, "velocity setpoint"), velocity, -speed, speed, "rad/s"
                )

    def moved(self, velocities: Vector, period: float) -> Vector:
        """Return where velocities (rad/s) take the last setpoints in a period (s), rad."""
        return tuple(
            [
                position + velocity * period
                for position, velocity in zip(self.positions, velocities, strict=True)
            ]
        )

    def _what(self, k: int, quantity: str) -> str:
        return f"{self._device} joint {self._names[k]}: {quantity}"
