"""Two legs with an upper body on a floor: rigid bodies, contacts and twelve position servos."""

import math
from typing import Any

import numpy as np

from drivers.sim.plants.leg_sensors import FAULTS, SENSORS, LegSensors
from drivers.sim.plants.legs_model import (
    CHANNELS,
    FloorSlope,
    LegDeviations,
    LegDimensions,
    attitude,
    build_model,
    lowest_corner,
    stand_on,
)
from drivers.sim.plants.legs_settings import LegsPlantSettings
from drivers.sim.plants.push import LEVEL, Push

_KNEES = (CHANNELS.index("right_knee"), CHANNELS.index("left_knee"))
_FREE_POSITIONS, _FREE_SPEEDS = 7, 6
"""Of the waist before the joints in MuJoCo's vectors."""
_BEARING = 0.02
"""Share of the weight above which a foot bears."""
_GRAVITY = 9.81
_LIFT, _IMMOVABLE = 0.05, 1e6
"""Of a waist that is hung up, m; kg and kg m²."""
_SLIPPERY = 0.05
"""Coefficient of friction of a wet sole on tiles."""
_ROUNDING = 1e-9
"""s."""
_LOWER = ("right_floor_lower", "left_floor_lower")
_DROP, _DEEPEST = 5e-3, 30e-3
"""m."""
_STIFFNESS = 0x57
"""Seeds the draw of the stiffnesses beside the unit's own seed: nothing else of it changes."""


class LegsPlant:
    """Physics of the whole robot.

    Before all twelve servos have torque for the first time the robot stands ready on a stand that
    holds it as it is; then it is on its own feet, and can slip, sag and fall.

    Parameters
    ----------
    settings : LegsPlantSettings
        Servos, floor, spreads.
    seed : int
        Of the unit's deviations: equal seeds give equal runs.
    geometry : LegDimensions
        Nominal dimensions, masses and servo limits.

    Raises
    ------
    ValueError
        The legs are not as long as the initial hip height, or the stand has not every joint.
    """

    Settings = LegsPlantSettings

    channel_names = (*CHANNELS, *SENSORS)
    truth_columns = (
        ("waist_x", "m"),
        ("waist_y", "m"),
        ("waist_z", "m"),
        ("waist_roll", "rad"),
        ("waist_pitch", "rad"),
        ("waist_yaw", "rad"),
        ("advance", "m"),
        ("slip_right", "m"),
        ("slip_left", "m"),
        ("load_right", "N"),
        ("load_left", "N"),
        ("torque_right_knee", "N m"),
        ("torque_left_knee", "N m"),
        ("saturated", "1"),
        ("fell", "1"),
        *((joint, "rad") for joint in CHANNELS),
        *((f"{joint}_velocity", "rad/s") for joint in CHANNELS),
        *((f"{leg}_foot_{axis}", "m") for leg in ("right", "left") for axis in "xyz"),
    )
    """Names and units of `truth`. ``advance`` is of the waist since the stand let go; a slip is how
    far a foot has got off the places where it came down; ``saturated`` counts the servos that are
    at their peak torque or cannot turn as fast as commanded; ``fell`` stays 1."""

    def __init__(self, settings: LegsPlantSettings, seed: int, geometry: LegDimensions) -> None:
        import mujoco

        if len(settings.stand) not in (0, len(CHANNELS)):
            raise ValueError(f"stand: {len(settings.stand)} angles for {len(CHANNELS)} joints.")
        self.settings = settings
        self.deviations = _draw(settings, seed)
        self._floor = FloorSlope(settings.floor_pitch, settings.floor_roll)
        self.model = build_model(
            geometry,
            settings.servo,
            floor_friction=settings.floor_friction,
            timestep=settings.timestep,
            deviations=self.deviations,
            terrain=settings.terrain,
            floor=self._floor,
        )
        self.data = mujoco.MjData(self.model)
        self._step: Any = mujoco.mj_step
        self._forward: Any = mujoco.mj_forward
        self._contact_force: Any = mujoco.mj_contactForce
        self._timestep = settings.timestep
        self._rate_limit = geometry.max_rate
        self._turns = np.full(len(CHANNELS), geometry.max_rate * settings.timestep)
        self._least_turn = float(self._turns.min())
        self._peaks = (*geometry.torque_peak, *geometry.torque_peak)
        self._weight = _GRAVITY * float(np.sum(self.model.body_mass))
        data, model = self.data, self.model
        self._angles = data.qpos[_FREE_POSITIONS:]
        self._speeds = data.qvel[_FREE_SPEEDS:]
        self._waist = data.qpos[:_FREE_POSITIONS]
        self._torques = data.actuator_force
        self._control = data.ctrl
        self._soles = data.site_xpos
        self._push = Push(data.xfrc_applied[model.body("waist").id, :3], LEVEL, "push")
        self.sensors = LegSensors(settings.sensors, seed, geometry, model, data)
        self.known_faults = (
            "floor_slippery", "floor_grips", "hung", *_LOWER, *FAULTS, *self._push.known_faults
        )  # fmt: skip
        blocks = [model.geom(f"terrain_{k}").id for k in range(len(settings.terrain))]
        self._ground = [model.geom("floor").id, *blocks]
        self._friction = model.geom_friction
        self._grip = float(self._friction[self._ground[0], 0])
        self._sole_geoms = (model.geom("right_sole").id, model.geom("left_sole").id)
        if settings.ground_roll or settings.ground_pitch:
            model.opt.gravity[:] = _gravity(settings.ground_roll, settings.ground_pitch)
        self._stiffness = _draw_stiffness(settings, seed)
        self._damping_share = settings.servo.damping / settings.servo.stiffness
        self._reach = np.full(len(CHANNELS), math.inf)
        self._stand_ready(geometry)
        self._command = self._angles.copy()
        self._lead = np.zeros(12)
        self._target = self._angles.copy()
        self._powered = [False] * 12
        self._standing_free = False
        self._time = 0.0
        self._stepped = 0.0
        self._origin = float(self._waist[0])
        self._slips = [0.0, 0.0]
        self._slipped = [0.0, 0.0]
        self._anchors: list[tuple[float, float] | None] = [None, None]
        self._loads = (0.5 * self._weight, 0.5 * self._weight)
        self._turning = 0
        self._fell = False
        self._set_power()

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._time

    def channel_value(self, channel: int) -> float:
        """Return what a sensor shows; see `rig.hal.MeasuredPlant`."""
        return self.sensors.show(channel - len(CHANNELS))

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Give one servo its command.

        Parameters
        ----------
        channel : int
            Index into `channel_names`.
        position : float
            rad.
        velocity : float
            Rate that goes with it, rad/s; 0 if the servo is given none.
        torque_on : bool
            Without it the joint turns freely.
        """
        self._command[channel] = position
        most = self._rate_limit
        self._lead[channel] = self._damping_share * min(max(velocity, -most), most)
        if torque_on != self._powered[channel]:
            self._powered[channel] = torque_on
            # A servo starts from where it is.
            self._target[channel] = self._angles[channel]
            self._set_power()

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
        """Cap a servo at what it is told, rad/s and N m, and at what it can."""
        self._turns[channel] = min(speed, self._rate_limit) * self._timestep
        self._least_turn = float(self._turns.min())
        # The position loop asks its velocity loop for stiffness / damping of what is left to go.
        self._reach[channel] = speed * self._damping_share if self._damping_share else math.inf
        most = min(torque, self._peaks[channel])
        self.model.actuator_forcerange[channel] = (-most, most)

    def joint_position(self, channel: int) -> float:
        """Return a joint's angle, rad."""
        return float(self._angles.item(channel))

    def joint_velocity(self, channel: int) -> float:
        """Return a joint's rate, rad/s."""
        return float(self._speeds.item(channel))

    def joint_torque(self, channel: int) -> float:
        """Return a servo's torque, N m."""
        return float(self._torques.item(channel))

    def pull(self, channel: str, by: float) -> None:
        """Turn a joint by hand, press a load cell or lean the waist; rad or N."""
        if channel in SENSORS:
            self.sensors.press(channel, by)
        else:
            self._angles[CHANNELS.index(channel)] += by
            self._speeds[:] = 0.0  # hands hold the others

    def advance(self, t: float) -> None:
        """Integrate up to `t` (s); what is less than a time step is left for the next call."""
        self._time = t
        if not self._standing_free:
            self._stepped = t
            self.sensors.sample(t)
            return
        moved = False
        while self._stepped + self._timestep <= t + _ROUNDING:
            if self._stepped >= self._push.ends:
                self._push.end()
            self._turn_targets()
            self._step(self.model, self.data)
            self._stepped += self._timestep
            moved = True
        if moved:
            self._look()
            self.sensors.sample(t)

    def inject(self, fault: str, value: float | None = None) -> None:
        """Push the upper body, as in ``left.push`` (value: N s), or change the floor's grip.

        ``right_floor_lower`` and ``left_floor_lower`` (value: m, default 5 mm) put the floor lower
        for one foot, which had better be in the air; `leg_sensors.FAULTS` break a sensor.
        ``hung`` hangs it up by its waist, feet in the air. ``floor_slippery`` gives the floor
        another coefficient of friction (default 0.05), and ``floor_grips`` its own again.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault not in self.known_faults:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        if fault.endswith(".push"):
            self._push.begin(fault, value, self._stepped)
        elif fault in FAULTS:
            self.sensors.break_by(fault, value)
        elif fault in _LOWER:
            by = _DROP if value is None else value
            if not abs(by) <= _DEEPEST:
                raise ValueError(f"plant: {fault} takes at most {_DEEPEST:g} m, not {by:g}")
            # A floor that is lower for one foot alone is a sole that is as much higher.
            self.model.geom_pos[self._sole_geoms[_LOWER.index(fault)], 2] += by
        elif fault == "hung":
            self._hang()
        elif fault == "floor_grips":
            self._friction[self._ground, 0] = self._grip
        else:
            friction = _SLIPPERY if value is None else value
            if not 0.0 <= friction < math.inf:
                raise ValueError(f"plant: a floor's friction is no {friction:g}")
            self._friction[self._ground, 0] = friction

    def _hang(self) -> None:
        """Lift the waist, and make it too heavy to be moved by anything that the legs do."""
        self._waist[2] += _LIFT
        self.model.dof_armature[:_FREE_SPEEDS] = _IMMOVABLE
        self._forward(self.model, self.data)

    def truth(self) -> tuple[float, ...]:
        """Return what no device measures, as `truth_columns` names it."""
        x, y, z, *_ = position = self._waist.tolist()
        return (
            x,
            y,
            z,
            *attitude(*position[3:]),
            x - self._origin,
            *self._slips,
            *self._loads,
            self.joint_torque(_KNEES[0]),
            self.joint_torque(_KNEES[1]),
            float(self._turning + self._at_peak()),
            float(self._fell),
            *self._angles.tolist(),
            *self._speeds.tolist(),
            *self._soles[0].tolist(),
            *self._soles[1].tolist(),
        )

    def powered(self) -> dict[str, bool]:
        """Return whether each drive has torque."""
        return dict(zip(CHANNELS, self._powered, strict=True))

    def _stand_ready(self, geometry: LegDimensions) -> None:
        """Put the robot on its stand: both soles flat on the floor, or as the settings have it."""
        waist, joints = stand_on(geometry, self.settings.initial_hip_height, self._floor)
        self._angles[:] = self.settings.stand or joints
        self._waist[:] = (*waist, 1.0, 0.0, 0.0, 0.0)
        self._forward(self.model, self.data)
        if self.settings.stand:  # which a jig holds as high as its soles need, not in the floor
            self._waist[2] -= lowest_corner(self.model, self.data, self._sole_geoms, self._floor)
            self._forward(self.model, self.data)

    def _set_power(self) -> None:
        damping = self.settings.servo.damping
        for channel, powered in enumerate(self._powered):
            stiffness = self._stiffness[channel]
            self.model.actuator_gainprm[channel, 0] = stiffness if powered else 0.0
            self.model.actuator_biasprm[channel, 1] = -stiffness if powered else 0.0
            self.model.actuator_biasprm[channel, 2] = -damping if powered else 0.0
        if all(self._powered):
            self._standing_free = True

    def _turn_targets(self) -> None:
        """Let each servo's target follow its command, no faster than the servo can turn."""
        away = self._command - self._target
        most = self._least_turn
        if away.max() <= most and away.min() >= -most:  # as good as always
            self._target[:] = self._command
            self._turning = 0
        else:
            turn = np.clip(away, -self._turns, self._turns)
            self._target += turn
            self._turning = int(np.count_nonzero(turn != away))
        asked, angles, reach = self._target + self._lead, self._angles, self._reach
        self._control[:] = np.minimum(np.maximum(asked, angles - reach), angles + reach)

    def _at_peak(self) -> int:
        return sum(
            abs(torque) >= 0.999 * peak
            for torque, peak in zip(self._torques.tolist(), self._peaks, strict=True)
        )

    def _look(self) -> None:
        """Note what the feet bear, how far they slipped, and whether the robot has fallen."""
        self._loads = self._measure_loads()
        for foot, load in enumerate(self._loads):
            anchor = self._anchors[foot]
            if load < _BEARING * self._weight:
                self._anchors[foot] = None
                continue
            x, y, _ = self._soles[foot].tolist()
            if anchor is None:
                self._anchors[foot] = (x, y)
                self._slipped[foot] = self._slips[foot]
            else:
                here = math.hypot(x - anchor[0], y - anchor[1])
                self._slips[foot] = self._slipped[foot] + here
        if not self._fell:
            x, y, z, *turned = self._waist.tolist()
            height = z - self._floor.height(x, y)
            roll, pitch, _ = attitude(*turned)
            lean = math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))
            low = 0.5 * self.settings.initial_hip_height
            self._fell = lean > self.settings.fallen_tilt or height < low

    def _measure_loads(self) -> tuple[float, float]:
        loads = [0.0, 0.0]
        force = np.zeros(6)
        for number, geoms in enumerate(self.data.contact.geom.tolist()):
            for foot, geom in enumerate(self._sole_geoms):
                if geom in geoms:
                    self._contact_force(self.model, self.data, number, force)
                    loads[foot] += force.item(0)
        return loads[0], loads[1]


def _draw(settings: LegsPlantSettings, seed: int) -> LegDeviations:
    """Draw a unit; the draws are always made, whatever the spreads are."""
    rng = np.random.default_rng(seed)
    masses, frictions = rng.uniform(-1.0, 1.0, 13), rng.uniform(-1.0, 1.0, 12)
    floor = float(rng.uniform(-1.0, 1.0))
    return LegDeviations(
        tuple((1.0 + settings.mass_spread * masses).tolist()),
        tuple((1.0 + settings.friction_spread * frictions).tolist()),
        1.0 + settings.friction_spread * floor,
    )


def _draw_stiffness(settings: LegsPlantSettings, seed: int) -> list[float]:
    """Draw each servo's stiffness, N m/rad."""
    draws = np.random.default_rng((_STIFFNESS, seed % 2**32)).uniform(-1.0, 1.0, len(CHANNELS))
    return [
        settings.servo.stiffness * (1.0 + settings.stiffness_spread * d) for d in draws.tolist()
    ]


def _gravity(roll: float, pitch: float) -> tuple[float, float, float]:
    """Return gravity as seen from ground that is inclined, m/s²."""
    down = _GRAVITY * math.cos(pitch)
    return (_GRAVITY * math.sin(pitch), -down * math.sin(roll), -down * math.cos(roll))
