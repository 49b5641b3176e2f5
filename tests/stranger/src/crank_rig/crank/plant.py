"""The physics of the crank: two flywheels on servo drives, and the rod between them."""

import math
import random
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from crank_rig.crank.types import AXES
from rig.hal import MeasuredPlant, Plant
from rig.hal.plant import PhysicsSettings


@dataclass(frozen=True, slots=True)
class CrankPlantSettings(PhysicsSettings):
    """What is true of the simulated cranks.

    Parameters
    ----------
    inertia : float
        Of each crank with its drive, kg m².
    friction : float
        Dry friction of each crank, N m.
    rod_stiffness : float
        Torque for a twist of the rod, where the cranks stand across it, N m/rad.
    radius : float
        Of the cranks, m.
    rod_zero : float
        The right crank's lead at which the rod is unstrained, rad.
    drive_stiffness, drive_damping : float
        Of the drives' own loops, N m/rad and N m s/rad.
    torque_noise : float
        Standard deviation of the drives' torque in each time step, N m.
    timestep : float
        Of the integration, s.
    """

    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = 0.05
    friction: Annotated[float, Unit("N m"), Ge(0)] = 0.5
    rod_stiffness: Annotated[float, Unit("N m"), Gt(0)] = 400.0
    radius: Annotated[float, Unit("m"), Gt(0)] = 0.05
    rod_zero: Annotated[float, Unit("rad")] = 0.015
    drive_stiffness: Annotated[float, Unit("N m"), Gt(0)] = 800.0
    drive_damping: Annotated[float, Unit("N m s"), Ge(0)] = 12.0
    torque_noise: Annotated[float, Unit("N m"), Ge(0)] = 0.2
    timestep: Annotated[float, Unit("s"), Gt(0)] = 5e-4


class CrankPlant(Plant, MeasuredPlant):
    """Two cranks, integrated in steps, with the port that simulated servo drives need.

    Fault: ``rod_broken``.

    Parameters
    ----------
    settings : CrankPlantSettings
        See there.
    seed : int
        Of the noise.
    """

    channel_names = (*AXES, "rod")
    known_faults = ("rod_broken",)
    truth_columns = (
        ("position_left", "rad"),
        ("position_right", "rad"),
        ("rod_torque", "N m"),
    )

    def __init__(self, settings: CrankPlantSettings, seed: int) -> None:
        self.settings = settings
        self._noise = random.Random(seed)
        self._steps = 0
        self._now = 0.0
        self._angles = [0.0, settings.rod_zero]
        self._speeds = [0.0, 0.0]
        self._torques = [0.0, 0.0]
        # Of each drive: the reference, its speed, since when; None without torque.
        self._orders: list[tuple[float, float, float] | None] = [None, None]
        self._rod = settings.rod_stiffness

    def advance(self, t: float) -> None:
        """Integrate to the last time step that is not after `t`, s."""
        self._now = t
        for _ in range(int(t / self.settings.timestep + 1e-6) - self._steps):
            self._steps += 1
            self._step(self._steps * self.settings.timestep)

    def truth(self) -> tuple[float, ...]:
        """Return what `truth_columns` names."""
        return (*self._angles, self._rod_torque())

    def powered(self) -> dict[str, bool]:
        """Return whether each drive has torque."""
        return {axis: order is not None for axis, order in zip(AXES, self._orders, strict=True)}

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""
        if fault not in self.known_faults:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        self._rod = 0.0

    # What simulated servo drives need: see drivers.sim.servo_port.

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a drive its reference, which moves on by itself."""
        self._orders[channel] = (position, velocity, self._now) if torque_on else None

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Do nothing: these drives have no caps of their own."""

    def joint_position(self, channel: int) -> float:
        """Return the true angle of a crank, rad."""
        return self._angles[channel]

    def joint_velocity(self, channel: int) -> float:
        """Return the true speed of a crank, rad/s."""
        return self._speeds[channel]

    def joint_torque(self, channel: int) -> float:
        """Return the torque of a crank's drive, N m."""
        return self._torques[channel]

    def channel_value(self, channel: int) -> float:
        """Return what a sensor on a channel measures: on the rod its force, N; else an angle."""
        if channel < len(AXES):
            return self._angles[channel]
        return self._rod_torque() / self.settings.radius

    def _rod_torque(self) -> float:
        """Return the rod's torque on the left crank, N m; at its dead centres it has no lever."""
        left, right = self._angles
        lever = math.sin(0.5 * (left + right))
        return self._rod * lever * lever * (right - left - self.settings.rod_zero)

    def _step(self, t: float) -> None:
        settings, rod = self.settings, self._rod_torque()
        for k, pull in enumerate((rod, -rod)):
            angle, speed, order = self._angles[k], self._speeds[k], self._orders[k]
            torque = 0.0
            if order is not None:
                reference = order[0] + order[1] * (t - order[2])
                torque = settings.drive_stiffness * (reference - angle)
                torque += settings.drive_damping * (order[1] - speed)
                torque += self._noise.gauss(0.0, settings.torque_noise)
            self._torques[k] = torque
            free = speed + (torque + pull) / settings.inertia * settings.timestep
            # Dry friction takes at most the speed that there is: the crank then sticks.
            most = settings.friction / settings.inertia * settings.timestep
            speed = math.copysign(max(abs(free) - most, 0.0), free)
            self._speeds[k] = speed
            self._angles[k] = angle + speed * settings.timestep
