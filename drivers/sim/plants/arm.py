"""A U-R-S arm of six joints with its drives, in MuJoCo.

It is built from the profile's dimensions alone and shares no kinematics with the controllers, so
that a mistake on either side shows as a distance between hand and path.
"""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from drivers.sim.plants.arm_drives import ArmDrives
from drivers.sim.plants.arm_model import (
    HAND,
    JOINTS,
    LINKS,
    MARKER,
    ArmDeviations,
    ArmDimensions,
    build_model,
)
from drivers.sim.plants.arm_settings import ArmPlantSettings
from drivers.sim.plants.push import ALONG, Push

_START = (0.0, math.pi / 6, math.pi / 2, 0.0, -math.pi / 6, 0.0)  # rad
_INSIDE = 0.02
"""Share of a range by which an arm that is not told where to start stays off its ends."""
_TUNING_POSE = (0.0, math.pi / 4, math.pi / 2, 0.0, math.pi / 4, 0.0)  # rad


class ArmPlant:
    """Physics of the arm: inertia, gravity, friction, drives, brakes, stops.

    It starts at rest, without torque and on its brakes.

    Faults: ``blocked`` and ``brake_released`` (value: joint, from 0), ``payload`` (value: kg more
    at the hand, default 2), ``repair``; and pushes at the hand, as in ``x.hand_push`` (value: N s).

    Parameters
    ----------
    settings : ArmPlantSettings
        Masses, friction, drives.
    seed : int
        Of this unit's deviations from its drawing.
    geometry : ArmDimensions
        The profile's.

    Raises
    ------
    ValueError
        It would start beyond a joint's range.
    """

    Settings = ArmPlantSettings

    channel_names = JOINTS

    own_faults = ("blocked", "brake_released", "payload", "repair")
    """What `inject` understands beside pushes."""

    truth_columns = (
        *((joint, "rad") for joint in JOINTS),
        *((f"{joint}_velocity", "rad/s") for joint in JOINTS),
        *((f"hand_{axis}", "m") for axis in "xyz"),
        *((f"torque_{joint}", "N m") for joint in JOINTS),
        *((f"marker_{axis}", "m") for axis in "xyz"),
    )
    """Names and units of `truth`."""

    def __init__(self, settings: ArmPlantSettings, seed: int, geometry: ArmDimensions) -> None:
        start = _start(settings.start, geometry)
        self.settings = settings
        self._dt = settings.timestep
        self._steps = 0
        self._asked = 0.0
        # The drives were tuned for the arm of the drawing, not for this unit.
        nominal = build_model(geometry, settings, ArmDeviations())
        self._drives = ArmDrives(settings.drives, _inertias_of(nominal), self._dt)
        self._model = build_model(geometry, settings, _draw_unit(settings, seed))
        self._data = mujoco.MjData(self._model)
        self._hand = self._model.site(HAND).id
        self._marker = self._model.site(MARKER).id
        self._tool = self._model.body(LINKS[-1]).id
        self._push = Push(self._data.xfrc_applied[self._tool, :3], ALONG, "hand_push")
        self.known_faults = (*self.own_faults, *self._push.known_faults)
        self._frictions = self._model.dof_frictionloss.copy()
        self._tool_mass = float(self._model.body_mass[self._tool])
        self._blocked = [False] * len(JOINTS)
        self._brake_broken = [False] * len(JOINTS)
        self._data.qpos[:] = start
        self._hold_on_brakes()
        mujoco.mj_forward(self._model, self._data)
        self._angles: list[float] = self._data.qpos.tolist()
        self._speeds: list[float] = self._data.qvel.tolist()

    @property
    def time(self) -> float:
        """How far the plant has been integrated, s."""
        return self._steps * self._dt

    def advance(self, t: float) -> None:
        """Integrate to the last time step that is not after `t` (s); the past is left alone."""
        if t <= self._asked:
            return
        self._asked = t
        steps = int(t / self._dt + 1e-6) - self._steps
        if steps <= 0:
            return
        model, data, drive, mj_step = self._model, self._data, self._drives.step, mujoco.mj_step
        positions, velocities, control = data.qpos, data.qvel, data.ctrl
        angles, speeds = self._angles, self._speeds
        for _ in range(steps):
            if self._steps * self._dt >= self._push.ends:
                self._push.end()
            control[:] = drive(angles, speeds, self._steps * self._dt)
            mj_step(model, data)
            angles, speeds = positions.tolist(), velocities.tolist()
            self._steps += 1
        self._angles, self._speeds = angles, speeds

    # Ports of the drives --------------------------------------------------------------

    def command_joint(
        self, channel: int, position: float | None, velocity: float, torque_on: bool
    ) -> None:
        """Give a joint's drive its reference, and switch its power stage.

        Parameters
        ----------
        channel : int
            The joint.
        position : float or None
            Where it shall be now, rad; None: it follows the velocity alone.
        velocity : float
            How fast the reference moves, rad/s.
        torque_on : bool
            Whether the power stage is on; without it the joint is on its brake.

        Raises
        ------
        ValueError
            A reference is not a finite number.
        """
        if not math.isfinite(velocity) or not (position is None or math.isfinite(position)):
            raise ValueError(f"{JOINTS[channel]}: {position} rad, {velocity} rad/s is no reference")
        drives = self._drives
        drives.command(channel, position, velocity, self._asked)
        if torque_on != drives.has_torque[channel]:
            drives.switch(channel, torque_on)
            self._set_friction(channel)

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a joint's drive, rad/s and N m."""
        self._drives.limit(channel, speed, torque)

    def joint_position(self, channel: int) -> float:
        """Return the true angle of a joint, rad."""
        return self._angles[channel]

    def joint_velocity(self, channel: int) -> float:
        """Return the true velocity of a joint, rad/s."""
        return self._speeds[channel]

    def joint_torque(self, channel: int) -> float:
        """Return the torque of a joint's drive, N m."""
        return self._drives.torques[channel]

    def pull(self, channel: str, by: float) -> None:
        """Turn a joint by hand, rad, its brake released, up to its end; a blocked one stays."""
        joint = JOINTS.index(channel)
        if self._blocked[joint]:
            return
        low, high = self._model.jnt_range[joint]
        here = self._angles[joint]
        self._data.qpos[joint] = min(max(here + by, min(here, low)), max(here, high))
        self._data.qvel[joint] = 0.0
        self._angles[joint] = float(self._data.qpos[joint])

    # What is recorded -----------------------------------------------------------------

    def hand_position(self) -> tuple[float, float, float]:
        """Return where the tool point truly is, m."""
        # A step leaves the places of the bodies as they were at its start.
        mujoco.mj_kinematics(self._model, self._data)
        x, y, z = self._data.site_xpos[self._hand].tolist()
        return x, y, z

    def truth(self) -> tuple[float, ...]:
        """Return what `truth_columns` names."""
        hand = self.hand_position()
        marker = self._data.site_xpos[self._marker].tolist()
        return (*self._angles, *self._speeds, *hand, *self._drives.torques, *marker)

    def powered(self) -> dict[str, bool]:
        """Return whether each drive has torque."""
        return dict(zip(JOINTS, self._drives.has_torque, strict=True))

    # Faults ---------------------------------------------------------------------------

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault in self._push.known_faults:
            self._push.begin(fault, value, self.time)
            return
        if fault == "payload":
            self._add_payload(2.0 if value is None else value)
        elif fault == "blocked":
            self._blocked[self._joint(value)] = True
        elif fault == "brake_released":
            self._brake_broken[self._joint(value)] = True
        elif fault == "repair":
            self._blocked = [False] * len(JOINTS)
            self._brake_broken = [False] * len(JOINTS)
            self._add_payload(0.0)
        else:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        self._hold_on_brakes()

    # Inside ---------------------------------------------------------------------------

    def _hold_on_brakes(self) -> None:
        for channel in range(len(JOINTS)):
            self._set_friction(channel)

    def _set_friction(self, channel: int) -> None:
        """Give a joint its dry friction: its own, its brake's, and of what blocks it."""
        friction = float(self._frictions[channel])
        brake = self.settings.drives.brakes[channel]
        is_braked = not self._drives.has_torque[channel] and not self._brake_broken[channel]
        if is_braked or self._blocked[channel]:
            friction += brake
        if self._blocked[channel]:
            friction += self.settings.drives.torque_limits[channel]
        self._model.dof_frictionloss[channel] = friction

    def _add_payload(self, mass: float) -> None:
        if not 0.0 <= mass < math.inf:
            raise ValueError(f"plant: a payload of {mass:g} kg is none")
        self._model.body_mass[self._tool] = self._tool_mass + mass
        mujoco.mj_setConst(self._model, mujoco.MjData(self._model))

    def _joint(self, value: float | None) -> int:
        number = 0.0 if value is None else value
        if number not in range(len(JOINTS)):
            raise ValueError(f"plant: no joint number {number:g}; there are {len(JOINTS)}, from 0")
        return int(number)


def _inertias_of(model: mujoco.MjModel) -> list[float]:
    """Return what each drive has to turn in the pose in which it was tuned, kg m²."""
    data = mujoco.MjData(model)
    data.qpos[:] = _TUNING_POSE
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    diagonal: list[float] = inertia.diagonal().tolist()
    return diagonal


def _draw_unit(settings: ArmPlantSettings, seed: int) -> ArmDeviations:
    """Return how a unit differs from its drawing."""
    generator = np.random.default_rng(seed)
    masses = 1.0 + settings.mass_spread * generator.uniform(-1.0, 1.0, len(LINKS))
    frictions = 1.0 + settings.friction_spread * generator.uniform(-1.0, 1.0, len(JOINTS))
    return ArmDeviations(tuple(masses.tolist()), tuple(frictions.tolist()))


def _start(asked: Sequence[float] | None, geometry: ArmDimensions) -> list[float]:
    """Return where the joints stand at first, rad."""
    ranges = list(zip(geometry.position_min, geometry.position_max, strict=True))
    if asked is None:
        insets = [_INSIDE * (high - low) for low, high in ranges]
        return [
            min(max(angle, low + inset), high - inset)
            for angle, inset, (low, high) in zip(_START, insets, ranges, strict=True)
        ]
    for name, angle, (low, high) in zip(JOINTS, asked, ranges, strict=True):
        if not low <= angle <= high:
            raise ValueError(
                f"plant.start: {name} at {math.degrees(angle):.4g} deg is outside its range, "
                f"{math.degrees(low):.4g} … {math.degrees(high):.4g} deg"
            )
    return list(asked)
