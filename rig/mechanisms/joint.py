"""The spherical joint: a ring on a ball, turned by four wires and their cylinders."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from controllers.spherical_joint.feasibility import FeasibilityCheck, JointBounds, refuse
from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import tilt_of
from controllers.spherical_joint.types import (
    CameraSample,
    JointCommand,
    JointEstimate,
    JointModel,
    JointReference,
    JointState,
    Lap,
)
from rig.hal import (
    ConfigurationError,
    EmergencyStop,
    EmergencyStopInput,
    LimitExceeded,
    LinearEncoder,
    MarkerCamera,
    PressureRegulator,
    SafetyError,
    StaleReading,
)
from rig.mechanisms.base import Margin, pick_device
from rig.mechanisms.joint_diagnosis import explain_disagreement, explain_residual
from rig.mechanisms.joint_settings import JointSettings
from rig.runtime.columns import Column
from rig.runtime.limits import VectorLimiter
from rig.runtime.motion import Motion, Segment

CHANNELS = ("ch1", "ch2", "ch3", "ch4")

_SPEED_WINDOW = 0.01
"""Speeds are judged over this time, s: over one cycle, an encoder step would look fast."""
_POSE_EVERY = 4
"""The pose is worked out for the checks every so many cycles: faults last longer."""
_PLAN_STEP = 0.01
"""Poses of a motion are checked at this distance, s."""
_ZERO = (0.0, 0.0, 0.0)


class PoseController(Protocol):
    """A controller that shows what it believes of the joint."""

    @property
    def estimate(self) -> JointEstimate:
        """Marker, residual, wanted rods and tensions."""
        ...


class _LapMotion:
    """A motion whose references say where in a lap they are."""

    def __init__(self, motion: Any, period: float) -> None:
        self._motion = motion
        self._period = period
        self._repetitions = [
            (start, laps, round(lap / period))
            for start, lap, laps in getattr(motion, "repetitions", ())
            if laps > 1
        ]

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self._motion.duration)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Those of the motion."""
        segments: tuple[Segment, ...] = self._motion.segments
        return segments

    def at(self, t: float) -> JointReference:
        """Return the reference at `t`, with its lap if it is in one."""
        reference: JointReference = self._motion.at(t)
        for start, laps, ticks in self._repetitions:
            tick = round((t - start) / self._period)
            if 0 <= tick < laps * ticks:
                return reference._replace(lap=Lap(tick // ticks, tick % ticks, ticks))
        return reference


class _Pose(NamedTuple):
    """What the checks know of the joint: its axis and how well the wires agree."""

    axis: tuple[float, float, float]
    residual: float


class SphericalJoint:
    """The loop's view of the spherical joint.

    Parameters
    ----------
    settings : JointSettings
        Geometry and limits.
    regulators : PressureRegulator
        Channels ch1 … ch4.
    encoders : sequence of LinearEncoder
        One for each channel, in order.
    camera : MarkerCamera, optional
        Sees the marker.
    emergency_stop : EmergencyStopInput, optional
        The device that reads the emergency-stop contact.
    period : float
        The loop's period, s.

    Raises
    ------
    ConfigurationError
        The devices have other channels, or ranges that do not hold the limits.
    """

    Settings = JointSettings

    columns = (
        *(Column(f"reading.rod_{name}", "m", "shortening of its wire") for name in CHANNELS),
        *(Column(f"reading.pressure_{name}", "Pa", "chamber pressure, gauge") for name in CHANNELS),
        Column("reading.age", "s", "age of the oldest reading when it was used"),
        *(Column(f"reading.marker_{axis}", "m", "marker as the camera saw it") for axis in "xyz"),
        Column("reading.marker_age", "s", "age of that sample; -1 before the first"),
        *(Column(f"reference.axis_{axis}", "1", "desired axis of the ring") for axis in "xyz"),
        *(Column(f"reference.marker_{axis}", "m", "desired marker") for axis in "xyz"),
        *(Column(f"reference.rod_{name}", "m", "where control wants the rod") for name in CHANNELS),
        *(Column(f"estimate.marker_{axis}", "m", "encoders and camera") for axis in "xyz"),
        *(Column(f"estimate.encoder_marker_{axis}", "m", "encoders alone") for axis in "xyz"),
        Column("estimate.residual", "m", "how far the wires are from agreeing on a pose"),
        *(Column(f"estimate.tension_{name}", "N", "pull of the chamber") for name in CHANNELS),
        *(Column(f"command.{name}", "Pa", "wanted setpoint, gauge") for name in CHANNELS),
        *(Column(f"applied.{name}", "Pa", "setpoint that was sent, gauge") for name in CHANNELS),
    )

    def __init__(
        self,
        settings: JointSettings,
        *,
        regulators: PressureRegulator,
        encoders: tuple[LinearEncoder, ...],
        camera: MarkerCamera | None,
        emergency_stop: EmergencyStopInput | None,
        period: float,
    ) -> None:
        _check_devices(settings, regulators, encoders)
        self.settings = settings
        self.controller: PoseController | None = None
        self._regulators = regulators
        self._encoders = encoders
        self._camera = camera
        self._emergency_stop = emergency_stop
        self._limits = limits = settings.limits
        self._limiter = VectorLimiter(
            "pressure", *limits.pressure, limits.pressure_rate, period, "Pa"
        )
        self._kinematics = ForwardKinematics(settings.geometry)
        self._diagnosis = ForwardKinematics(settings.geometry)
        self._pose = _Pose((0.0, 0.0, 1.0), 0.0)
        self._cycle = 0
        self._age = 0.0
        self._speed_from: tuple[float, Quadruple] | None = None
        self._agreed: Quadruple = (0.0,) * 4
        self._agreed_at = self._seen_alike_at = -math.inf
        self._tensions: Quadruple = (0.0,) * 4

    @classmethod
    def assemble(
        cls, settings: JointSettings, devices: Mapping[str, Any], period: float
    ) -> "SphericalJoint":
        """Pick the devices that the settings name.

        Raises
        ------
        ConfigurationError
            A device is not there, or cannot do what its role asks for.
        """

        def pick(role: str, name: str | None, kind: type[Any]) -> Any:
            return None if name is None else pick_device(f"joint.{role}", name, kind, devices)

        return cls(
            settings,
            regulators=pick("regulators", settings.regulators, PressureRegulator),
            encoders=tuple(pick("encoders", name, LinearEncoder) for name in settings.encoders),
            camera=pick("camera", settings.camera, MarkerCamera),
            emergency_stop=pick("emergency_stop", settings.emergency_stop, EmergencyStopInput),
            period=period,
        )

    @staticmethod
    def wiring(settings: JointSettings) -> dict[str, str]:
        """Return which channel of the plant each single-channel device measures."""
        return dict(zip(settings.encoders, CHANNELS, strict=True))

    @classmethod
    def model_of(cls, settings: JointSettings) -> JointModel:
        """Return what the controllers are told of the joint."""
        friction, response, limits = settings.friction, settings.regulator_response, settings.limits
        return JointModel(
            geometry=settings.geometry,
            area=settings.area,
            mass=settings.moving_mass,
            base_pressure=settings.base_pressure,
            pressure_min=limits.pressure[0],
            pressure_max=limits.pressure[1],
            regulator_bandwidth=response.bandwidth,
            regulator_damping=response.damping,
            coulomb=friction.coulomb,
            breakaway=friction.breakaway,
            stribeck_velocity=friction.stribeck_velocity,
            viscous=friction.viscous,
            ring_friction=friction.ring,
            wire_friction=friction.wire,
            wire_stiffness=settings.wire_stiffness,
            least_tension=limits.tension[0],
            most_tension=limits.tension[1],
        )

    @classmethod
    def plan(
        cls, settings: JointSettings, reference: Any, controller: Any, period: float
    ) -> Motion[JointReference]:
        """Return the motion, if every pose of it is possible and permitted.

        Raises
        ------
        ValueError
            A pose is out of reach of wires or rods, slackens a wire or unseats the ring; with
            the instant, the number and the pose.
        """
        motion = _LapMotion(reference, period)
        if not isinstance(motion.at(0.0), JointReference):
            raise ValueError("the reference is not one for the spherical joint")
        limits = settings.limits
        check = FeasibilityCheck(
            settings.geometry,
            JointBounds(
                max_tilt=limits.tilt,
                extension=(0.0, settings.stroke),
                home_extension=settings.home,
                least_tension=limits.tension[0],
                most_tension=limits.tension[1],
                total_tension=4.0 * settings.area * settings.base_pressure,
                seat_margin=limits.seat_margin,
                free_wires=limits.free_wires,
            ),
            controller.settings.wire,
            controller.settings.pose,
        )
        refuse(check.check_geometry())
        for number in range(int(motion.duration / _PLAN_STEP) + 1):
            t = number * _PLAN_STEP
            try:
                refuse(check.check_pose(motion.at(t).axis))
            except ValueError as error:
                raise ValueError(f"after {t:.2f} s: {error}") from error
        return motion

    @classmethod
    def approach(
        cls, start: JointReference, end: JointReference, duration: float, t: float
    ) -> JointReference:
        """Return the shortest minimum-jerk way between two poses at `t`."""
        return great_circle(start.axis, end.axis, duration, t)

    def read(self, now: float) -> JointState:
        """Assemble the joint's state; see `Mechanism.read`."""
        home = self.settings.home
        regulators = self._regulators
        pressures, oldest = regulators.pressure()
        device: Any = regulators
        rods = []
        for encoder in self._encoders:
            (extension,), t = encoder.position()
            rods.append(home - extension)
            if t < oldest:
                oldest, device = t, encoder
        self._age = now - oldest
        if self._age > self._limits.reading_age:
            raise StaleReading(device.name, self._age, self._limits.reading_age)
        sample = None
        if self._camera is not None:
            markers, t = self._camera.markers()
            if markers.positions:
                sample = CameraSample(markers.positions[0], t)
        area = self.settings.area
        self._tensions = tuple([area * p for p in pressures])  # type: ignore[assignment]
        return JointState(now, (*rods,), (*pressures,), sample)  # type: ignore[arg-type]

    def check(self, state: JointState, now: float) -> None:
        """Raise if the state is not safe; see `Mechanism.check`."""
        if self._emergency_stop is not None:
            pressed, t = self._emergency_stop.emergency_stop()
            if pressed:
                raise EmergencyStop("the emergency stop is pressed or its circuit is open")
            if now - t > self._limits.reading_age:
                raise StaleReading("emergency stop", now - t, self._limits.reading_age)
        if not math.isfinite(sum(state.rods) + sum(state.pressures)):
            raise SafetyError(f"a reading is not a number: {state}")
        self._check_speed(state.rods, now)
        self._cycle += 1
        if self._cycle % _POSE_EVERY == 0:
            self._check_pose(state, now)
            if state.camera is not None:
                self._check_camera(state.camera, now)

    def _check_speed(self, rods: Quadruple, now: float) -> None:
        if self._speed_from is None:
            self._speed_from = (now, rods)
            return
        then, before = self._speed_from
        if now - then < _SPEED_WINDOW:
            return
        bound = self._limits.speed
        for name, rod, was in zip(CHANNELS, rods, before, strict=True):
            speed = (rod - was) / (now - then)
            if abs(speed) > bound:
                raise LimitExceeded(f"speed of the rod of {name}", speed, -bound, bound, "m/s")
        self._speed_from = (now, rods)

    def _check_pose(self, state: JointState, now: float) -> None:
        rods = self._unstretched(state)
        limits = self._limits
        try:
            found = self._kinematics.update(rods)
            self._pose = _Pose(found.axis, found.residual)
        except ValueError:
            self._pose = _Pose(self._pose.axis, math.inf)
        if self._pose.residual <= limits.residual:
            if self._pose.residual <= 0.5 * limits.residual:
                self._agreed = rods
            self._agreed_at = now
        elif now - self._agreed_at > limits.grace:
            moved = tuple([rod - was for rod, was in zip(rods, self._agreed, strict=True)])
            names = [encoder.name for encoder in self._encoders]
            cause = explain_residual(self._diagnosis, rods, moved, names)  # type: ignore[arg-type]
            raise LimitExceeded(
                f"disagreement of the four wires about the pose ({cause})",
                self._pose.residual, 0.0, limits.residual, "m",
            )  # fmt: skip
        tilt, bound = tilt_of(self._pose.axis), limits.tilt + limits.tilt_excess
        if tilt > bound:
            raise LimitExceeded("tilt of the ring", tilt, 0.0, bound, "rad")

    def _check_camera(self, sample: CameraSample, now: float) -> None:
        """Compare the camera with the encoders, which have moved on since its exposure."""
        marker = self.settings.geometry.marker(self._pose.axis)
        bound = self._limits.disagreement + (now - sample.t) * self._marker_speed(now)
        if math.dist(marker, sample.marker) <= bound:
            self._seen_alike_at = now
        elif now - max(self._seen_alike_at, self._agreed_at - 1.0) > self._limits.grace:
            cause = explain_disagreement(marker, sample.marker, bound)
            assert self._camera is not None
            raise LimitExceeded(
                f"{self._camera.name}: distance of the marker from where the encoders put it "
                f"({cause})",
                math.dist(marker, sample.marker), 0.0, bound, "m",
            )  # fmt: skip

    def _marker_speed(self, now: float) -> float:
        """Return a bound on how fast the marker moves, m/s: as fast as the limit of the rods."""
        geometry = self.settings.geometry
        return self._limits.speed * geometry.marker_height / geometry.ball_radius

    def _unstretched(self, state: JointState) -> Quadruple:
        """Return the rods less what the wires stretch under the measured pressures."""
        give = self.settings.area / self.settings.wire_stiffness
        first, second, third, fourth = (
            rod - give * pressure for rod, pressure in zip(state.rods, state.pressures, strict=True)
        )
        return first, second, third, fourth

    def resting_command(self, state: JointState) -> JointCommand:
        """Return the measured pressures, within the permitted range."""
        lower, upper = self._limits.pressure
        return JointCommand(*(min(max(p, lower), upper) for p in state.pressures))

    def energised_command(self, state: JointState) -> JointCommand:
        """Return the base pressure in all chambers: the wires pull alike, nothing moves."""
        return JointCommand(*(self.settings.base_pressure,) * 4)

    def released_command(self) -> JointCommand:
        """Return all chambers vented."""
        return JointCommand(*(self._limits.pressure[0],) * 4)

    def blend(self, start: JointCommand, end: JointCommand, share: float) -> JointCommand:
        """Return the command `share` of the way from `start` to `end`."""
        return JointCommand(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))

    def start_limiting(self, state: JointState) -> None:
        """Start the rate limit from the measured pressures."""
        self._limiter.reset(state.pressures)
        self._speed_from = None

    def limit(self, command: JointCommand) -> JointCommand:
        """Return the command that may be applied: range and rate."""
        return JointCommand(*self._limiter.limit(command))

    def write(self, applied: JointCommand) -> None:
        """Hand the setpoints to the regulators."""
        self._regulators.set_pressure(applied)

    def row(
        self,
        state: JointState,
        reference: JointReference,
        command: JointCommand,
        applied: JointCommand,
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        marker = self.settings.geometry.marker
        if self.controller is None or self._cycle == 0:
            estimate = JointEstimate(_ZERO, _ZERO, 0.0, state.rods, (0.0,) * 4)
        else:
            estimate = self.controller.estimate
        camera = state.camera
        return (
            *state.rods,
            *state.pressures,
            self._age,
            *(_ZERO if camera is None else camera.marker),
            -1.0 if camera is None else state.t - camera.t,
            *reference.axis,
            *marker(reference.axis),
            *estimate.rods,
            *estimate.marker,
            *estimate.encoder_marker,
            estimate.residual,
            *self._tensions,
            *command,
            *applied,
        )

    def reference_of(self, state: JointState) -> JointReference:
        """Return the reference to stay in the pose that the rods show."""
        try:
            axis = self._kinematics.update(self._unstretched(state)).axis
        except ValueError:
            axis = self._pose.axis
        return JointReference(axis, _ZERO, _ZERO)

    def worst_margin(self, state: JointState, applied: JointCommand, now: float) -> Margin:
        """Return the quantity that is nearest to its limit."""
        limits = self._limits
        lower, _ = limits.tension
        return min(
            Margin("tilt", 1.0 - tilt_of(self._pose.axis) / (limits.tilt + limits.tilt_excess)),
            Margin("reading age", 1.0 - self._age / limits.reading_age),
            Margin("wire agreement", 1.0 - self._pose.residual / limits.residual),
            Margin("pressure", 1.0 - max(applied) / limits.pressure[1]),
            Margin("slack wire", min(self._tensions) / lower - 1.0 if lower else 1.0),
            key=lambda margin: margin.fraction,
        )

    def limit_hits(self) -> dict[str, int]:
        """Return how often each limit was hit since the start."""
        return {
            "pressure range": self._limiter.range_hits,
            "pressure rate": self._limiter.rate_hits,
        }


def _check_devices(
    settings: JointSettings, regulators: PressureRegulator, encoders: tuple[LinearEncoder, ...]
) -> None:
    if tuple(regulators.channels) != CHANNELS:
        raise ConfigurationError(
            f"{regulators.name}: the channels are {', '.join(regulators.channels)}; "
            f"the joint needs {', '.join(CHANNELS)} in this order"
        )
    low, high = regulators.pressure_range
    if settings.limits.pressure[0] < low or settings.limits.pressure[1] > high:
        raise ConfigurationError(
            f"limits.pressure {settings.limits.pressure[0]:g} … {settings.limits.pressure[1]:g} Pa "
            f"exceeds what {regulators.name} can set, {low:g} … {high:g} Pa"
        )
    for encoder in encoders:
        if len(encoder.channels) != 1:
            raise ConfigurationError(
                f"{encoder.name}: it has {len(encoder.channels)} channels, a rod needs one"
            )
        if encoder.stroke < settings.stroke:
            raise ConfigurationError(
                f"{encoder.name}: its stroke {encoder.stroke:g} m is shorter than the "
                f"cylinder's, {settings.stroke:g} m"
            )
