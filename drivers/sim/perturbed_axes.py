"""Servo joints of a simulated rig whose drives err, as a seed draws it."""

from drivers.sim.perturbation import Draws
from drivers.sim.servo_port import ServoPort


class PerturbedAxes(ServoPort):
    """Joints of a plant as drives see them that err: ``shown = ± (1 + scale) angle - zero``.

    Parameters
    ----------
    plant : ServoPort
        The physics.
    draws : Draws
        Directions, scales and zeros.
    """

    def __init__(self, plant: ServoPort, draws: Draws) -> None:
        self._plant = plant
        self._gains = tuple(
            (-1.0 if turned else 1.0) * (1.0 + scale)
            for turned, scale in zip(draws.joints.reversed, draws.joints.scale, strict=True)
        )
        self._zeros = draws.channels["joint_zero"]

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a servo its reference as its drive means it."""
        gain = self._gains[channel]
        true = (position + self._zeros[channel]) / gain
        self._plant.command_joint(channel, true, velocity / gain, torque_on)

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a servo as its drive means it, rad/s and N m."""
        gain = abs(self._gains[channel])
        self._plant.limit_joint(channel, speed / gain, torque * gain)

    def joint_position(self, channel: int) -> float:
        """Return a joint's angle as its drive has it, rad."""
        true = float(self._plant.joint_position(channel))
        return self._gains[channel] * true - self._zeros[channel]

    def joint_velocity(self, channel: int) -> float:
        """Return a joint's velocity as its drive has it, rad/s."""
        return self._gains[channel] * float(self._plant.joint_velocity(channel))

    def joint_torque(self, channel: int) -> float:
        """Return a joint's torque as its drive has it, N m."""
        return float(self._plant.joint_torque(channel)) / self._gains[channel]
