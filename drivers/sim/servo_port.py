"""What simulated servo drives need of a plant with joints."""

from typing import Protocol


class ServoPort(Protocol):
    """Joints whose servo loops the plant closes, with its finite bandwidth and torque.

    Angles are the joint's own, as the mechanism has them; gears, counts and signs belong to
    the drive.
    """

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a joint's servo loop its reference.

        Parameters
        ----------
        channel : int
            The joint.
        position : float
            Where it shall be now, rad; drives that follow a velocity integrate it.
        velocity : float
            How fast this reference moves, rad/s. A drive repeats the call at the rate of its
            own loop while the reference moves.
        torque_on : bool
            Whether the power stage is on; without it the joint is free (or on its brake) and
            the reference means nothing.
        """

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a joint's servo loop, whatever it could do.

        Parameters
        ----------
        channel : int
            The joint.
        speed : float
            That the loop asks for at most, rad/s; infinite for no cap of its own.
        torque : float
            That it gives at most, N m; infinite for no cap of its own.
        """

    def joint_position(self, channel: int) -> float:
        """Return the true angle of a joint, rad."""

    def joint_velocity(self, channel: int) -> float:
        """Return the true velocity of a joint, rad/s."""

    def joint_torque(self, channel: int) -> float:
        """Return the torque that the drive exerts on a joint, N m."""
