"""The physics, for `--on sim` and `--on virtual`: say here what is true of your mechanism."""

import math
import random
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from rig.hal import Plant
from rig.hal.plant import PhysicsSettings
from rig.scaffolding.templates.mechanism.types import AXES


@dataclass(frozen=True, slots=True)
class MyRigPlantSettings(PhysicsSettings):
    """An arm that hangs from each axis, and the drive's own loop.

    Parameters
    ----------
    inertia : float
        Of axis, drive and load, kg m².
    imbalance : float
        Greatest torque of the load's weight, N m.
    friction : float
        Dry friction, N m.
    drive_stiffness, drive_damping : float
        Of the drive's own loop, N m/rad and N m s/rad.
    torque_noise : float
        Standard deviation of the drive's torque in each time step, N m.
    timestep : float
        Of the integration, s.
    """

    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = 0.05
    imbalance: Annotated[float, Unit("N m"), Ge(0)] = 2.0
    friction: Annotated[float, Unit("N m"), Ge(0)] = 0.5
    drive_stiffness: Annotated[float, Unit("N m"), Gt(0)] = 800.0
    drive_damping: Annotated[float, Unit("N m s"), Ge(0)] = 12.0
    torque_noise: Annotated[float, Unit("N m"), Ge(0)] = 0.2
    timestep: Annotated[float, Unit("s"), Gt(0)] = 5e-4


class MyRigPlant(Plant):
    """Integrates in steps, and has the port that simulated servo drives need.

    Fault: ``load_lost``.

    Parameters
    ----------
    settings : MyRigPlantSettings
        See there.
    seed : int
        Of the noise.
    """

    channel_names = AXES
    known_faults = ("load_lost",)
    truth_columns = tuple((f"position_{name}", "rad") for name in AXES)

    def __init__(self, settings: MyRigPlantSettings, seed: int) -> None:
        self.settings = settings
        self._noise = random.Random(seed)
        self._steps = 0
        self._now = 0.0
        self._imbalance = settings.imbalance
        self._angles = [0.0] * len(AXES)
        self._speeds = [0.0] * len(AXES)
        self._torques = [0.0] * len(AXES)
        # Of each drive: the reference, its speed, since when; None without torque.
        self._orders: list[tuple[float, float, float] | None] = [None] * len(AXES)

    def advance(self, t: float) -> None:
        """Integrate to the last time step that is not after `t`, s."""
        self._now = t
        for _ in range(int(t / self.settings.timestep + 1e-6) - self._steps):
            self._steps += 1
            for k in range(len(AXES)):
                self._step(k, self._steps * self.settings.timestep)

    def truth(self) -> tuple[float, ...]:
        """Return what `truth_columns` names."""
        return tuple(self._angles)

    def powered(self) -> dict[str, bool]:
        """Return whether each drive has torque."""
        return {axis: order is not None for axis, order in zip(AXES, self._orders, strict=True)}

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""
        if fault not in self.known_faults:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        self._imbalance = 0.0

    # What simulated servo drives need: see drivers.sim.servo_port.

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give a drive its reference, which moves on by itself."""
        self._orders[channel] = (position, velocity, self._now) if torque_on else None

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Do nothing: these drives have no caps of their own."""

    def joint_position(self, channel: int) -> float:
        """Return the true angle of an axis, rad."""
        return self._angles[channel]

    def joint_velocity(self, channel: int) -> float:
        """Return the true speed of an axis, rad/s."""
        return self._speeds[channel]

    def joint_torque(self, channel: int) -> float:
        """Return the torque of a drive, N m."""
        return self._torques[channel]

    def _step(self, k: int, t: float) -> None:
        settings, angle, speed, order = (
            self.settings,
            self._angles[k],
            self._speeds[k],
            self._orders[k],
        )
        torque = 0.0
        if order is not None:
            reference = order[0] + order[1] * (t - order[2])
            torque = settings.drive_stiffness * (reference - angle)
            torque += settings.drive_damping * (order[1] - speed)
            torque += self._noise.gauss(0.0, settings.torque_noise)
        self._torques[k] = torque
        pull = torque - self._imbalance * math.sin(angle)
        free = speed + pull / settings.inertia * settings.timestep
        # Dry friction takes at most the speed that there is: the axis then sticks.
        most = settings.friction / settings.inertia * settings.timestep
        self._speeds[k] = speed = math.copysign(max(abs(free) - most, 0.0), free)
        self._angles[k] = angle + speed * settings.timestep
