"""The encoder that a servo drive closes its position loop over, and how it may lie."""

import random
from collections.abc import Callable

from drivers.sim.servo_port import ServoPort

SERVO_PERIOD = 1e-3
"""Of a drive's own loop, s; one whose encoder lies repeats its command as often."""

_JUMP, _DRIFT, _SCALE, _NOISE = 0.5, 0.05, 1.5, 5e-3


class ServoEncoder(ServoPort):
    """One joint of a plant as its drive sees it.

    The drive's position loop makes what the encoder shows follow the reference, so that a lie
    moves the joint. The velocity loop has a sensor of its own, as most drives take it from the
    motor's commutation; velocity and torque stay true, and a drive that follows velocities alone
    is not led astray. Lies:

    ``encoder_jump`` (value: rad, default 0.5)
        From now on every angle is off by this much.
    ``encoder_frozen``
        It repeats its angle.
    ``encoder_mirrored``
        From here on it counts backwards.
    ``encoder_drift`` (value: rad/s, default 0.05)
        Its zero wanders.
    ``encoder_scale`` (value: ratio, default 1.5)
        From here on it counts so many times the way.
    ``encoder_noisy`` (value: rad, default 0.005)
        Each sample is off by normal noise of this standard deviation.

    Parameters
    ----------
    port : ServoPort
        The plant.
    now : callable
        Returns the time, s.

    Attributes
    ----------
    closes_position : bool
        Whether the drive's position loop is closed; else its reference is the motor's own angle.
    """

    lies = (
        "encoder_jump",
        "encoder_frozen",
        "encoder_mirrored",
        "encoder_drift",
        "encoder_scale",
        "encoder_noisy",
    )

    def __init__(self, port: ServoPort, now: Callable[[], float]) -> None:
        self._port = port
        self._now = now
        self.closes_position = True
        self.repair()

    def repair(self) -> None:
        """Show the truth again."""
        self.lying = False
        self._offset = self._drift = self._pivot = self._since = 0.0
        self._gain = 1.0
        self._noise = 0.0
        self._random = random.Random("noise of an encoder")

    def lie(self, channel: int, how: str, value: float | None = None) -> None:
        """Begin one of `lies`; what is shown does not step but in a jump."""
        if how == "encoder_noisy":
            self.lying, self._noise = True, _NOISE if value is None else value
            return
        shown = self.joint_position(channel)
        self._offset, self._since = shown, self._now()
        self._pivot = self._port.joint_position(channel)
        self.lying = True
        if how == "encoder_jump":
            self._offset += _JUMP if value is None else value
        elif how == "encoder_drift":
            self._drift += _DRIFT if value is None else value
        else:
            gains = {"encoder_frozen": 0.0, "encoder_mirrored": -1.0}
            self._gain *= gains.get(how, _SCALE if value is None else value)

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give the joint the reference that moves what is shown to where the drive wants it."""
        if self.lying and torque_on and self.closes_position:
            position += self._port.joint_position(channel) - self.joint_position(channel)
        self._port.command_joint(channel, position, velocity, torque_on)

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap the joint's servo loop."""
        self._port.limit_joint(channel, speed, torque)

    def joint_position(self, channel: int) -> float:
        """Return the angle that the encoder shows, rad."""
        true = self._port.joint_position(channel)
        if not self.lying:
            return true
        wandered = self._drift * (self._now() - self._since)
        shown = self._offset + self._gain * (true - self._pivot) + wandered
        return shown + self._random.gauss(0.0, self._noise) if self._noise else shown

    def motor_position(self, channel: int) -> float:
        """Return the angle that a drive's velocity loop starts from, rad."""
        shows = self.joint_position if self.closes_position else self._port.joint_position
        return shows(channel)

    def joint_velocity(self, channel: int) -> float:
        """Return the velocity that the motor's own sensor shows, rad/s."""
        return self._port.joint_velocity(channel)

    def joint_torque(self, channel: int) -> float:
        """Return the torque that the drive exerts, N m."""
        return self._port.joint_torque(channel)
