"""What a calibrated servo driver makes of drives, for drives that have no driver (`--on sim`)."""

from collections.abc import Mapping
from typing import Protocol

from drivers.servos.axis_settings import AxisSettings
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed


class ChainSettings(Protocol):
    """The settings of a chain of joints."""

    @property
    def joints(self) -> Mapping[str, AxisSettings]:
        """The joints by name."""


class CorrectedAxes(ServoPort):
    """The joints of a plant, as calibrated settings have them.

    The drives are mounted as the nominal settings say; a driver reads their counts by the
    calibrated ones. Here the two meet in straight lines between angles.

    Parameters
    ----------
    plant : ServoPort
        The physics.
    lines : mapping of int to tuple of float
        By the plant's joint, gain and offset from an angle by the nominal settings to the same
        counts' angle by the calibrated ones, 1 and rad.
    """

    def __init__(self, plant: ServoPort, lines: dict[int, tuple[float, float]]) -> None:
        self._plant = plant
        self._lines = lines

    @classmethod
    def of(cls, of: Installed[ChainSettings, ServoPort]) -> "CorrectedAxes":
        """Return the port of a servo device."""
        nominal = of.built.joints
        lines = {
            channel: _line(nominal[name], joint)
            for channel, (name, joint) in zip(of.channels, of.settings.joints.items(), strict=True)
        }
        return cls(of.plant, lines)

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a drive the reference that the driver's counts mean to it."""
        gain, offset = self._lines[channel]
        self._plant.command_joint(channel, (position - offset) / gain, velocity / gain, torque_on)

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a drive as the driver's counts mean it, rad/s and N m."""
        gain = abs(self._lines[channel][0])
        self._plant.limit_joint(channel, speed / gain, torque * gain)

    def joint_position(self, channel: int) -> float:
        """Return the angle that the driver reads, rad."""
        gain, offset = self._lines[channel]
        return gain * self._plant.joint_position(channel) + offset

    def joint_velocity(self, channel: int) -> float:
        """Return the velocity that the driver reads, rad/s."""
        return self._lines[channel][0] * self._plant.joint_velocity(channel)

    def joint_torque(self, channel: int) -> float:
        """Return the torque that the driver reads, N m."""
        return self._plant.joint_torque(channel) / self._lines[channel][0]


def _line(nominal: AxisSettings, settings: AxisSettings) -> tuple[float, float]:
    gain = nominal.turns_per_radian / settings.turns_per_radian
    return gain, settings.offset - gain * nominal.offset
