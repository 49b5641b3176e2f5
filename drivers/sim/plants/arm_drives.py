"""The loops inside six servo drives: position, velocity, torque; as a maker would tune them."""

import math
from collections.abc import Sequence

from drivers.sim.plants.arm_settings import ArmDriveSettings


class ArmDrives:
    """Six cascaded servo loops with velocity feedforward and a limit of torque.

    The position loop is proportional; the velocity loop is proportional with an integral that
    stops where the torque is at its limit; the torque loop is a first-order lag. Nothing knows
    of gravity: it is the integral that carries the arm.

    Parameters
    ----------
    settings : ArmDriveSettings
        Bandwidths and limits.
    inertias : sequence of float
        What each loop was tuned for, motor and load, kg m².
    timestep : float
        Of the loops, s.

    Attributes
    ----------
    torques : list of float
        Of the motors at the joints, N m.
    has_torque : list of bool
        Whether each power stage is on.
    """

    def __init__(
        self, settings: ArmDriveSettings, inertias: Sequence[float], timestep: float
    ) -> None:
        velocity_corner = math.tau * settings.velocity_bandwidth
        self._stiffness = math.tau * settings.position_bandwidth
        self._gains = [inertia * velocity_corner for inertia in inertias]
        corner = velocity_corner / settings.integral_ratio
        self._integral_gains = [gain * corner * timestep for gain in self._gains]
        self._share = 1.0 - math.exp(-math.tau * settings.torque_bandwidth * timestep)
        self._strongest = settings.torque_limits
        self._limits = list(settings.torque_limits)
        self._fastest = [math.inf] * len(inertias)
        self._hold_after = settings.hold_after
        count = len(self._gains)
        self._positions: list[float | None] = [0.0] * count
        self._velocities = [0.0] * count
        self._since = [0.0] * count
        self._integrals = [0.0] * count
        self.torques = [0.0] * count
        self.has_torque = [False] * count

    def command(self, k: int, position: float | None, velocity: float, now: float) -> None:
        """Take a reference of drive `k`: rad (None: velocity alone), rad/s, and since when, s."""
        self._positions[k] = position
        self._velocities[k] = velocity
        self._since[k] = now

    def limit(self, k: int, speed: float, torque: float) -> None:
        """Cap drive `k` at what it is told, rad/s and N m, and at what it can."""
        self._fastest[k] = speed
        self._limits[k] = min(torque, self._strongest[k])

    def switch(self, k: int, has_torque: bool) -> None:
        """Switch a power stage on or off; its loops start from nothing."""
        self.has_torque[k] = has_torque
        self._integrals[k] = 0.0
        self.torques[k] = 0.0

    def step(self, angles: Sequence[float], speeds: Sequence[float], now: float) -> list[float]:
        """Return the torques of the next time step, N m.

        Parameters
        ----------
        angles, speeds : sequence of float
            Of the joints, rad and rad/s.
        now : float
            s.
        """
        stiffness, share, hold_after = self._stiffness, self._share, self._hold_after
        torques, integrals, fastest = self.torques, self._integrals, self._fastest
        for k, has_torque in enumerate(self.has_torque):
            if not has_torque:
                continue
            velocity, position = self._velocities[k], self._positions[k]
            elapsed = now - self._since[k]
            is_over = elapsed > hold_after
            error = (0.0 if is_over else velocity) - speeds[k]
            if position is not None:
                reference = position + velocity * (hold_after if is_over else elapsed)
                error += stiffness * (reference - angles[k])
            if abs(error + speeds[k]) > fastest[k]:
                error = math.copysign(fastest[k], error + speeds[k]) - speeds[k]
            limit = self._limits[k]
            wanted = self._gains[k] * error + integrals[k]
            if -limit < wanted < limit:
                integrals[k] += self._integral_gains[k] * error
            else:
                wanted = limit if wanted > 0.0 else -limit
            torques[k] += share * (wanted - torques[k])
        return torques
