"""The spherical joint: a ring on a ball, turned by four wires and their cylinders."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.learning import LapLearning
from controllers.spherical_joint.pose_control import PoseController
from controllers.spherical_joint.poses import natural_rotation
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.types import (
    CameraSample,
    JointCommand,
    JointEstimate,
    JointModel,
    JointReference,
    JointState,
)
from rig.hal import (
    Controller,
    Device,
    EmergencyStopInput,
    LimitExceeded,
    LinearEncoder,
    MarkerCamera,
    PressureRegulator,
    SafetyError,
    StaleReading,
)
from rig.hal.closed_loop import ClosedLoop
from rig.hal.hindsight import Suspect
from rig.hal.motion import Motion, Note
from rig.hal.picking import DevicePicker
from rig.hal.quantities import Expected, Margin
from rig.mechanisms.joint.camera_check import check_camera
from rig.mechanisms.joint.columns import CHANNELS, JOINT_COLUMNS, four_of, sample_of
from rig.mechanisms.joint.following import RodsFollow
from rig.mechanisms.joint.motion import JointMotion, PosedMotion, checker, plan_motion
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.joint.targets import PoseTargets
from rig.mechanisms.joint.watch import JointWatch
from rig.mechanisms.pneumatic.alarms.bounds import derive_bounds, expect_bounds
from rig.mechanisms.pneumatic.devices import check_asked_pressures
from rig.mechanisms.pneumatic.loop import loop_of
from rig.mechanisms.pneumatic.mechanism import PneumaticMechanism
from rig.mechanisms.pneumatic.valves.regulating import as_regulators, regulating_kind

if TYPE_CHECKING:
    from rig.hal.hindsight import Logged

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

_ZERO = (0.0, 0.0, 0.0)


class EstimatingPoseController(Controller[JointReference, JointState, JointCommand], Protocol):
    """A controller that shows what it believes of the joint."""

    @property
    def estimate(self) -> JointEstimate:
        """Marker, residual, wanted rods and tensions."""

    @property
    def learning(self) -> LapLearning | None:
        """What it learns over laps, if anything."""


class SphericalJoint(PneumaticMechanism[JointSettings, JointState, JointReference, JointCommand]):
    """The loop's view of the spherical joint.

    Parameters are those of `PneumaticMechanism`, and the camera that may see the marker.
    """

    Settings = JointSettings
    whose = "the joint"
    channels = CHANNELS
    law = EstimatingPoseController
    columns = JOINT_COLUMNS

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
        super().__init__(settings, regulators, encoders, emergency_stop, period)
        if camera is not None:
            check_camera(settings, camera)
        self.controller: EstimatingPoseController | None = None
        self.motion: PosedMotion | None = None
        self._encoders = encoders
        self._camera = camera
        self._limits = settings.limits
        self._watch = JointWatch(
            self.settings,
            regulators.name,
            [encoder.name for encoder in encoders],
            None if camera is None else camera.name,
        )
        self._pressure_watch = self._watch.pressures
        self._tensions_at = TensionDistribution(settings.geometry)
        self._checked = False
        # Bound once: what every cycle asks for.
        self._homes = tuple([settings.home + offset for offset in settings.wire_offsets])
        self._area = settings.area
        self._marker = settings.geometry.marker
        self._positions = tuple(encoder.position for encoder in encoders)
        self._sample: CameraSample | None = None
        self._tensions: Quadruple = (0.0,) * 4
        self._rods: Quadruple = (0.0,) * 4
        self._now = 0.0
        self._follow = RodsFollow(self.settings)

    @classmethod
    def expected_of(cls, settings: JointSettings) -> tuple[Expected, ...]:
        """Return what a cut wire comes to, and from where on pressures are an alarm."""
        bounds = derive_bounds(settings.alarms.pressure, settings)
        return (*super().expected_of(settings), *expect_bounds(bounds))

    @classmethod
    def constants_of(cls, settings: JointSettings) -> dict[str, float]:
        """Return piston area, m², and the chambers' volumes where their rods read 0, m³."""
        homes = [settings.home + offset for offset in settings.wire_offsets]
        return settings.chambers(dict(zip(CHANNELS, homes, strict=True)))

    @classmethod
    def closed_loop(cls, settings: JointSettings, controller: object) -> ClosedLoop | None:
        """Return the margins of one pair of the joint; see `Mechanism.closed_loop`."""
        return loop_of(controller.pair_law) if isinstance(controller, PoseController) else None

    @classmethod
    def assemble(
        cls, settings: JointSettings, devices: Mapping[str, Device], period: float
    ) -> "SphericalJoint":
        """Pick the devices that the settings name; see `Mechanism.assemble`."""
        with DevicePicker("joint", devices) as pick:
            feed = pick("regulators", settings.regulators, regulating_kind(settings))
            encoders = tuple(pick("encoders", name, LinearEncoder) for name in settings.encoders)
            camera = pick.if_named("camera", settings.camera, MarkerCamera)
            stop = pick.if_named("emergency_stop", settings.emergency_stop, EmergencyStopInput)
        regulators = as_regulators(feed, encoders, settings, period)
        return cls(
            settings, regulators=regulators, encoders=encoders, camera=camera,
            emergency_stop=stop, period=period,
        )  # fmt: skip

    @classmethod
    def geometry_of(cls, settings: JointSettings) -> SphericalJointGeometry:
        """Return the dimensions that the plant is made with."""
        return settings.geometry

    @classmethod
    def wiring(cls, settings: JointSettings) -> dict[str, str]:
        """Return which channel of the plant each single-channel device measures."""
        return dict(zip(settings.encoders, CHANNELS, strict=True))

    @classmethod
    def model_of(cls, settings: JointSettings) -> JointModel:
        """Return what the controllers are told of the joint."""
        friction, limits = settings.friction, settings.limits
        return JointModel(
            **settings.told(),
            geometry=settings.geometry,
            ring_friction=friction.ring,
            wire_friction=friction.wire,
            wire_stiffness=settings.wire_stiffness,
            least_tension=limits.tension[0],
            most_tension=limits.tension[1],
        )

    @classmethod
    def plan(
        cls, settings: JointSettings, reference: object, controller: Any, period: float
    ) -> JointMotion:
        """Return the motion, if every pose of it is possible and permitted; see `plan_motion`."""
        return plan_motion(settings, reference, controller, period)

    @classmethod
    def approach(
        cls, start: JointReference, end: JointReference, duration: float, t: float
    ) -> JointReference:
        """Return the shortest minimum-jerk way between two poses at `t`."""
        return great_circle(start.axis, end.axis, duration, t)

    @classmethod
    def slow_down(cls, reference: JointReference, rate: float, change: float) -> JointReference:
        """Return the reference as it is passed more slowly; see `Mechanism.slow_down`."""
        u, v, w = reference.velocity
        a, b, c = reference.acceleration
        squared = rate * rate
        return reference._replace(
            velocity=(rate * u, rate * v, rate * w),
            acceleration=(
                squared * a + change * u,
                squared * b + change * v,
                squared * c + change * w,
            ),
        )

    @classmethod
    def pace_between(cls, before: JointReference, after: JointReference, time: float) -> float:
        """Return the speed of the ring's axis, rad/s."""
        return math.dist(before.axis, after.axis) / time

    @classmethod
    def targets(cls, settings: JointSettings, controller: Any) -> PoseTargets:
        """Return where the ring may be sent by its tilt and azimuth."""
        return PoseTargets(checker(settings, controller))

    def attach(self, controller: EstimatingPoseController, motion: Motion[JointReference]) -> None:
        """Take the controller whose estimate is logged, and the motion if its poses are known."""
        self._watch.compile()  # it will run now: `rig check` does not come here
        self._tensions_at.compile()
        self.controller = controller
        self.motion = motion if isinstance(motion, PosedMotion) else None

    def read(self, now: float) -> JointState:
        """Assemble the joint's state; see `Mechanism.read`."""
        homes, area = self._homes, self._area
        pressures, oldest = self._regulators.pressure()
        latest = None
        rods = []
        for k, position in enumerate(self._positions):
            (extension,), t = position()
            rods.append(homes[k] - extension)
            if t < oldest:
                oldest, latest = t, k
        self._age = age = now - oldest
        if age > self._limits.reading_age:
            device: Device = self._regulators if latest is None else self._encoders[latest]
            raise StaleReading(device.name, age, self._limits.reading_age)
        if self._camera is not None:
            markers, t = self._camera.markers()
            sample = self._sample
            if not markers.positions:
                self._sample = None
            elif sample is None or t != sample.t:
                twist = markers.twists[0] if markers.twists else None
                self._sample = CameraSample(markers.positions[0], t, twist)
        first, second, third, fourth = pressures
        self._tensions = (area * first, area * second, area * third, area * fourth)
        return _new(JointState, (now, (*rods,), pressures, self._sample))

    def recall(self, logged: Mapping[str, float]) -> JointState:
        """Assemble the joint's state from the log; see `Mechanism.recall`."""
        self._stop_contact.ignore()
        self._age = logged["reading.age"]
        pressures = four_of(logged, "reading.pressure")
        self._tensions = four_of(logged, "estimate.tension")
        self._sample = sample_of(logged, self._sample)
        return JointState(logged["clock"], four_of(logged, "reading.rod"), pressures, self._sample)

    def places_of(self, state: JointState) -> Quadruple:
        """Return how far the rods have run in, m."""
        return state.rods

    def check(self, state: JointState, now: float) -> None:
        """Raise if the state is not safe; see `Mechanism.check`."""
        self._stop_contact.check(now)
        self._watch.check(state, now)
        self._rods, self._now = state.rods, now
        self._checked = True

    def explain(self, error: Exception, state: JointState) -> Exception:
        """Return a fault with the cause that the rest of the rig shows; see `Mechanism`."""
        found = self._watch.explain(error, state)
        if isinstance(error, LimitExceeded) and (swing := self._follow.suspicion(self._now)):
            return SafetyError(f"{swing} ({error})" if found is error else f"{swing}; or {found}")
        return found

    def diagnose(self, fault: Exception, logged: "Logged") -> tuple[Suspect, ...]:
        """Return what explains the end of a log best; see `Mechanism.diagnose`."""
        if not self.is_pneumatic(fault):
            return ()
        from rig.mechanisms.joint.hindsight import joint_suspects

        return joint_suspects(logged, self.settings)

    def remarks(self, logged: "Logged") -> tuple[Note, ...]:
        """Return what never rests, or sticks, and a camera's latency; see `Mechanism.remarks`."""
        from rig.mechanisms.joint.hindsight import joint_remarks

        return (*joint_remarks(logged, self._camera), *self._follow.remarks())

    def resting_command(self, state: JointState) -> JointCommand:
        """Return the measured mean pressure, so shared that the ring stays where it is."""
        return self._balanced(state, sum(state.pressures))

    def energised_command(self, state: JointState) -> JointCommand:
        """Return the base pressure in the mean, so shared that the ring stays where it is."""
        return self._balanced(state, 4.0 * self.settings.base_pressure)

    def _balanced(self, state: JointState, total: float) -> JointCommand:
        """Return pressures of a given sum whose pulls turn the ring nowhere.

        What was measured in the middle of a motion, or the same pressure in all chambers away
        from upright, would let it fall over as soon as nothing controls it.
        """
        lower, upper = self._limits.pressure
        shares = self._tensions_at.shares(natural_rotation(self._watch.axis_of(state)))
        first, second, third, fourth = (min(max(total * s, lower), upper) for s in shares)
        return JointCommand(first, second, third, fourth)

    def released_command(self) -> JointCommand:
        """Return all chambers vented but for those that the profile has hold their pressure."""
        return JointCommand(*self._regulators.safe_pressure())

    def blend(self, start: JointCommand, end: JointCommand, share: float) -> JointCommand:
        """Return the command `share` of the way from `start` to `end`."""
        return JointCommand(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))

    def start_limiting(self, state: JointState) -> None:
        """Start the rate limit from the measured pressures."""
        self._limiter.reset(state.pressures)
        self._watch.restart()
        self._follow.restart()
        self._stood: Quadruple = state.rods

    def check_still(self, home: JointReference) -> None:
        """See `Mechanism.check_still`; the rods were where they stood, whatever they show of it."""
        self._follow.check_still(self._stood, self._rods, self._now)

    def check_command(self, reference: JointReference, command: JointCommand) -> None:
        """See `Mechanism.check_command`; the reference says nothing of pressures."""
        check_asked_pressures(CHANNELS, command, self._limits.pressure[1])
        estimate = None if self.controller is None else self.controller.estimate
        watch = self._watch
        self._follow.check(estimate, self._rods, self._now, watch.explain_held, watch.drives)

    def limit(self, command: JointCommand) -> JointCommand:
        """Return the command that may be applied: range and rate."""
        return _new(JointCommand, self._limiter.limit(command))

    def write(self, applied: JointCommand) -> None:
        """Hand the setpoints to the regulators."""
        self._regulators.set_pressure(applied)
        self._watch.send(applied)

    def row(
        self,
        state: JointState,
        reference: JointReference,
        command: JointCommand,
        applied: JointCommand,
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        controller = self.controller
        if controller is None or not self._checked:
            estimate = JointEstimate(_ZERO, _ZERO, 0.0, state.rods, (0.0,) * 4)
        else:
            estimate = controller.estimate
        learning = None if controller is None else controller.learning
        learns = 0.0 if learning is None or not learning.active else 1.0 + learning.finished
        t, rods, pressures, camera = state
        marker, encoder_marker, residual, wanted, *_ = estimate
        axis, lap = reference.axis, reference.lap
        return (
            *rods,
            *pressures,
            self._age,
            *(_ZERO if camera is None else camera.marker),
            -1.0 if camera is None else t - camera.t,
            0.0 if camera is None else camera.t,
            0.0 if camera is None or camera.twist is None else camera.twist,
            0.0 if camera is None or camera.twist is None else 1.0,
            *axis,
            *self._marker(axis),
            *wanted,
            *marker,
            *encoder_marker,
            residual,
            *self._tensions,
            -1.0 if lap is None else float(lap.number),
            learns,
            *(_ZERO if self.motion is None else self.motion.pose),
            *command,
            *applied,
        )

    def reference_of(self, state: JointState) -> JointReference:
        """Return the reference to stay in the pose that the rods show."""
        return JointReference(self._watch.axis_of(state), _ZERO, _ZERO)

    def worst_margin(self, state: JointState, applied: JointCommand, now: float) -> Margin:
        """Return the quantity that is nearest to its limit."""
        limits = self._limits
        lower, _ = limits.tension
        return min(
            *self._watch.margins(),
            Margin("reading age", 1.0 - self._age / limits.reading_age),
            Margin("pressure", 1.0 - max(applied) / limits.pressure[1]),
            Margin("slack wire", min(self._tensions) / lower - 1.0 if lower else math.inf),
            key=lambda margin: margin.fraction,
        )
