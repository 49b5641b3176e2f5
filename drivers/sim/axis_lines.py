"""Servo joints of a plant as something sees them whose angles lie on other straight lines."""

from collections.abc import Mapping
from typing import Protocol

from drivers.servos.axis_settings import AxisSettings
from drivers.sim.perturbation import Draws, Line
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed


class ChainSettings(Protocol):
    """The settings of a chain of joints."""

    @property
    def joints(self) -> Mapping[str, AxisSettings]:
        """The joints by name."""


class AxisLines(ServoPort):
    """Joints of a plant that are seen, and sent, by straight lines: ``seen = gain angle + offset``.

    Parameters
    ----------
    plant : ServoPort
        The physics.
    lines : mapping of int to tuple of float
        Gain and offset of each of the plant's joints, 1 and rad.
    """

    def __init__(self, plant: ServoPort, lines: Mapping[int, Line]) -> None:
        self._plant = plant
        self._lines = lines

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a joint the reference that is meant by one on its line."""
        gain, offset = self._lines[channel]
        self._plant.command_joint(channel, (position - offset) / gain, velocity / gain, torque_on)

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a joint as it is meant on its line, rad/s and N m."""
        gain = abs(self._lines[channel][0])
        self._plant.limit_joint(channel, speed / gain, torque * gain)

    def joint_position(self, channel: int) -> float:
        """Return a joint's angle on its line, rad."""
        gain, offset = self._lines[channel]
        return gain * float(self._plant.joint_position(channel)) + offset

    def joint_velocity(self, channel: int) -> float:
        """Return a joint's velocity on its line, rad/s."""
        return self._lines[channel][0] * float(self._plant.joint_velocity(channel))

    def joint_torque(self, channel: int) -> float:
        """Return a joint's torque on its line, N m."""
        return float(self._plant.joint_torque(channel)) / self._lines[channel][0]


def correct_axes(of: Installed[ChainSettings, ServoPort]) -> AxisLines:
    """Return the joints as calibrated settings have them; see `drivers.sim.wiring.Wiring`."""
    nominal = of.built.joints
    lines = {
        channel: _line(nominal[name], joint)
        for channel, (name, joint) in zip(of.channels, of.settings.joints.items(), strict=True)
    }
    return AxisLines(of.plant, lines)


def perturb_axes(plant: ServoPort, draws: Draws) -> AxisLines:
    """Return joints whose drives err in direction, scale and zero, as a seed draws it."""
    joints, zeros = draws.joints, draws.channels["joint_zero"]
    lines = [
        ((-1.0 if turned else 1.0) * (1.0 + scale), -zero)
        for turned, scale, zero in zip(joints.reversed, joints.scale, zeros, strict=True)
    ]
    return AxisLines(plant, dict(enumerate(lines)))


def _line(nominal: AxisSettings, settings: AxisSettings) -> Line:
    gain = nominal.turns_per_radian / settings.turns_per_radian
    return gain, settings.offset - gain * nominal.offset
