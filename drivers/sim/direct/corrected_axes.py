"""What a calibrated servo driver makes of drives, for drives that have no driver (`--on sim`)."""

from typing import Any

from drivers.servos.axis_settings import AxisSettings


class CorrectedAxes:
    """The joints of a plant, as calibrated settings have them.

    The drives are mounted as the nominal settings say; a driver reads their counts by the
    calibrated ones. Here the two meet in straight lines between angles.

    Parameters
    ----------
    plant : object
        The physics.
    lines : mapping of int to tuple of float
        By the plant's joint, gain and offset from an angle by the nominal settings to the same
        counts' angle by the calibrated ones, 1 and rad.
    """

    def __init__(self, plant: Any, lines: dict[int, tuple[float, float]]) -> None:
        self._plant = plant
        self._lines = lines

    @classmethod
    def of(
        cls, nominal: Any, settings: Any, plant: Any, channels: tuple[int, ...]
    ) -> "CorrectedAxes":
        """Return the port of a servo device."""
        return cls(
            plant,
            {
                channel: _line(nominal.joints[name], settings.joints[name])
                for name, channel in zip(settings.joints, channels, strict=True)
            },
        )

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def command_joint(
        self, channel: int, position: float | None, velocity: float, torque_on: bool
    ) -> None:
        """Give a drive the reference that the driver's counts mean to it."""
        gain, offset = self._lines[channel]
        wanted = None if position is None else (position - offset) / gain
        self._plant.command_joint(channel, wanted, velocity / gain, torque_on)

    def joint_position(self, channel: int) -> float:
        """Return the angle that the driver reads, rad."""
        gain, offset = self._lines[channel]
        return gain * float(self._plant.joint_position(channel)) + offset

    def joint_velocity(self, channel: int) -> float:
        """Return the velocity that the driver reads, rad/s."""
        return self._lines[channel][0] * float(self._plant.joint_velocity(channel))

    def joint_torque(self, channel: int) -> float:
        """Return the torque that the driver reads, N m."""
        return float(self._plant.joint_torque(channel)) / self._lines[channel][0]


def _line(nominal: AxisSettings, settings: AxisSettings) -> tuple[float, float]:
    gain = nominal.turns_per_radian / settings.turns_per_radian
    return gain, settings.offset - gain * nominal.offset
