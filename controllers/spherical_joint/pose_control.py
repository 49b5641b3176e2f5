"""Pose control: inverse kinematics over two antagonistic pairs, and tensions that keep wires taut.

The joint's four cylinders are two pairs. Each pair's position follows the difference of its wires'
shortenings under one of the laws for a pair of cylinders. What is left of the four tensions holds
the wires taut without turning the ring: the laws see and command only the *force of a pair*, what
tilts the ring, and the pose says which tensions amount to it. Two equal tensions of a pair cancel
at home only; at 60 degrees they tilt the ring half as much as an equal difference.

A wire's own length is not controlled: round a circle at 20 degrees the sum of two opposite ones
changes by 1.3 mm, so that a position loop on each would make the two fight.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from typing import Annotated, TypeVar

from annotated_types import Ge, Gt, Le, Unit

from controllers.base import Law
from controllers.cylinder.law import AnyPairLaw
from controllers.cylinder.types import PairModel, PairReference, PairState
from controllers.named_tuples import new_tuple
from controllers.spherical_joint.camera_loop import CameraLoop, CameraLoopSettings
from controllers.spherical_joint.dither import (
    DitherSettings,
    PathDither,
    PathDitherSettings,
    TensionDither,
)
from controllers.spherical_joint.falling import falling_stiffness
from controllers.spherical_joint.learning import (
    LapLearning,
    LapMemory,
    LearningSettings,
    StopSettings,
)
from controllers.spherical_joint.marker_estimate import (
    MarkerEstimate,
    MarkerEstimateSettings,
    MarkerEstimator,
)
from controllers.spherical_joint.pose_kernel import PoseNumbers, StepSettings
from controllers.spherical_joint.pose_step import PoseStep
from controllers.spherical_joint.poses import PoseConvention, Vector
from controllers.spherical_joint.types import (
    JointCommand,
    JointEstimate,
    JointModel,
    JointReference,
    JointState,
)
from controllers.spherical_joint.wires import InverseKinematics, WireKind

_NOTHING = (0.0, 0.0)
_ZERO = (0.0, 0.0, 0.0)

_START_TIME = 0.2
"""With which the tensions that are found at the start give way to the wanted ones, s."""


POSE_EVERY = 4
"""Shares of the tensions are worked out every so many cycles: within 4 ms, a ring at 1 Hz and 20
degrees changes them by some 0.5 %."""


@dataclass(frozen=True, slots=True)
class JointLearningSettings:
    """Signals that are learnt over the laps of a repeated motion.

    Parameters
    ----------
    force : LearningSettings, optional
        Of each pair's force: what its law added because of errors.
    axis : LearningSettings, optional
        Of the ring's axis: where the marker was, seen by the camera, off the reference.
    stop : StopSettings
        When learning ends by itself.
    """

    force: LearningSettings | None = field(default_factory=LearningSettings)
    axis: LearningSettings | None = None
    stop: StopSettings = field(default_factory=StopSettings)


@dataclass(frozen=True, slots=True)
class PoseControlSettings:
    """Settings of every pose controller.

    Parameters
    ----------
    wire : str
        ``exact``, or ``paper`` to reproduce the paper's path.
    pose : str
        ``natural``, or ``paper`` for ``R_Y(theta) R_X(phi)``.
    ball_friction : float
        Share of the modelled friction on the ball that is fed forward.
    friction_distance : float
        Motion of a wire over which that friction turns round, m.
    dither : DitherSettings
        Of the tensions together, against stick-slip.
    path_dither : PathDitherSettings
        Of the ring along its path, against stick-slip at higher speeds.
    pretension : float
        No wire is let below it, N, beyond what the limits ask for. A force is then made rather
        by pulling one wire than by letting go of the other: chambers fill several times
        faster than they exhaust at low pressure.
    stretch : float
        Share of the modelled stretch of the wires that the rods make up for.
    camera : CameraLoopSettings
        How the reference gives way to what the camera sees.
    estimate : MarkerEstimateSettings
        Of the marker.
    learning : JointLearningSettings, optional
        Over laps; none if not given.
    """

    wire: WireKind = "exact"
    pose: PoseConvention = "natural"
    ball_friction: Annotated[float, Ge(0), Le(2)] = 1.0
    friction_distance: Annotated[float, Unit("m"), Gt(0)] = 9e-6
    dither: DitherSettings = field(default_factory=DitherSettings)
    path_dither: PathDitherSettings = field(default_factory=PathDitherSettings)
    pretension: Annotated[float, Unit("N"), Ge(0)] = 0.0
    stretch: Annotated[float, Ge(0), Le(1)] = 1.0
    camera: CameraLoopSettings = field(default_factory=CameraLoopSettings)
    estimate: MarkerEstimateSettings = field(default_factory=MarkerEstimateSettings)
    learning: JointLearningSettings | None = None


Posed = TypeVar("Posed", bound=PoseControlSettings)


class PoseController(Law[Posed, JointModel, JointReference, JointState, JointCommand]):
    """Inverse kinematics, two pair laws, two mean pressures.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", sections 3 and 6.
    """

    def __init__(self, settings: Posed, model: JointModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._area = model.area
        self._height = model.geometry.marker_height
        self._marker = MarkerEstimator(settings.estimate, model.geometry, period)
        self._camera = CameraLoop(settings.camera, period)
        self._dither = TensionDither(settings.dither, model, period)
        self._path_dither = PathDither(settings.path_dither, period)
        # What the seals may take away from the pull of a chamber, or add to it.
        seal = 0.5 * model.breakaway
        self._lowest = model.area * model.pressure_min
        least = max(model.least_tension + seal + self._dither.tension, settings.pretension)
        self._least = max(least, self._lowest)
        self._most = min(model.most_tension - seal, model.area * model.pressure_max)
        self._base_pressure = model.base_pressure
        self._base = 0.5 * (self._least + self._most) / model.area
        pair = PairModel(
            area=model.area,
            mass=model.mass,
            # Only its difference is used: it may take the whole range.
            base_pressure=self._base,
            pressure_min=self._least / model.area,
            pressure_max=self._most / model.area,
            regulator_bandwidth=model.regulator_bandwidth,
            regulator_damping=model.regulator_damping,
            regulator_dead_time=model.regulator_dead_time,
            regulator_monitor_time=model.regulator_monitor_time,
            coulomb=model.coulomb,
            breakaway=model.breakaway,
            stribeck_velocity=model.stribeck_velocity,
            viscous=model.viscous,
            stiffness=falling_stiffness(model.geometry, model.area * model.base_pressure),
        )
        self._laws = (self._pair_law(pair), self._pair_law(pair))
        wound = 0.5 * math.pi - model.geometry.ring_half_angle
        friction = settings.ball_friction
        self._steps = PoseStep(
            StepSettings(
                area=model.area,
                compliance=settings.stretch / model.wire_stiffness,
                least=self._least,
                lowest=self._lowest,
                most=self._most,
                middle=self._base,
                decay=math.exp(-period / _START_TIME),
                # A pressure comes so much later than its setpoint while it changes evenly.
                ahead=2.0 * model.regulator_damping / model.regulator_bandwidth,
                ring=friction * model.ring_friction,
                wire=friction * model.wire_friction * wound,
                slide=period / settings.friction_distance,
            ),
            model.geometry,
            InverseKinematics(model.geometry, settings.wire, settings.pose),
        )
        self._cycle = 0
        self._started = self._pushed = False
        self._rate = 0.5 / period
        self._force_memory: LapMemory | None = None
        self._axis_memory: LapMemory | None = None
        self.learning: LapLearning | None = None
        """What is learnt over laps, if anything is."""
        learning = settings.learning
        if learning is not None:
            if learning.force is not None:
                self._force_memory = LapMemory(learning.force, 2, period)
            if learning.axis is not None:
                self._axis_memory = LapMemory(learning.axis, 3, period)
            memories = (self._force_memory, self._axis_memory)
            self.learning = LapLearning(
                learning.stop, tuple(memory for memory in memories if memory is not None)
            )
        self.estimate = JointEstimate(_ZERO, _ZERO, 0.0, (0.0,) * 4, (0.0,) * 4)
        """Marker, residual, wanted rods and tensions."""
        self.marker = MarkerEstimate(_ZERO, _ZERO, _ZERO, _ZERO, 0.0, math.inf, ())
        """The estimate of the marker with its bias and its alarms."""

    def compile(self) -> None:
        """See `Law.compile`."""
        for law in self._laws:
            law.compile()
        self._steps.compile()
        self._marker.compile()

    @property
    def numbers(self) -> PoseNumbers | None:
        """Of its steps around the laws, as kernels take them; None: some need no kernels."""
        return self._steps.numbers

    @property
    def shakes(self) -> bool:
        """Whether it has a dither of any kind."""
        settings = self.settings
        return settings.dither.amplitude > 0.0 or settings.path_dither.force > 0.0

    @property
    def pair_laws(self) -> tuple[AnyPairLaw, AnyPairLaw]:
        """The laws of the pairs."""
        return self._laws

    @property
    def pair_law(self) -> AnyPairLaw:
        """The law of the first pair; that of the other one has the same settings and model."""
        return self._laws[0]

    @abstractmethod
    def _pair_law(self, pair: PairModel) -> AnyPairLaw:
        """Return the law of a pair, made from the settings."""

    def reset(self, state: JointState) -> None:
        """Start bumplessly: the first command is what was measured."""
        self._marker.reset()
        self._camera.reset()
        self._steps.reset()
        self._dither.reset()
        self._path_dither.reset()
        if self.learning is not None:
            self.learning.reset()
        self._started = self._pushed = False
        self._cycle = 0

    def update(self, state: JointState, reference: JointReference) -> JointCommand:
        """Return the four setpoints of this period.

        Raises
        ------
        ValueError
            No pose explains the wires, or no tensions hold the reference.
        """
        t, rods, pressures, camera = state
        steps = self._steps
        base = reference.base_pressure or self._base_pressure
        anew = self._cycle % POSE_EVERY == 0
        self._cycle += 1
        push = reference.push
        if push is None and self._pushed:  # anew from where the pushes have left the ring
            self._pushed, self._started = False, False
        starts = push is None and not self._started
        axis, velocity = self._corrected(reference)
        measured, goals, friction, wanted, hold, seen, (a, b, c, d) = steps.before(
            axis, velocity, reference.acceleration, rods, pressures, base, anew, starts
        )
        residual = math.sqrt(0.5 * (a * a + b * b + c * c + d * d))
        self.marker = marker = self._marker.take(t, seen, residual, camera)
        self._camera.update(marker)
        self.estimate = new_tuple(
            JointEstimate, (marker[0], marker[1], residual, wanted, hold, push)
        )
        if push is not None:
            self._pushed = True
            return JointCommand(*steps.pushed(hold, *push))

        lap = reference.lap if self.learning is not None and self.learning.active else None
        learnt: tuple[float, ...] = _NOTHING
        if lap is not None and self._force_memory is not None:
            learnt = self._force_memory.at(lap.tick)
        laws = self._laws
        one = new_tuple(PairState, (t, *measured[0]))
        other = new_tuple(PairState, (t, *measured[1]))
        if starts:
            self._started = True
            laws[0].reset(one)
            laws[1].reset(other)
        goal, other_goal = new_tuple(PairReference, goals[0]), new_tuple(PairReference, goals[1])
        along, other_along = self._path_dither.update(goal[1], other_goal[1])
        force, back = laws[0].update(one, goal, friction[0] + learnt[0] + along)
        other_force, other_back = laws[1].update(
            other, other_goal, friction[1] + learnt[1] + other_along
        )
        if lap is not None:
            off = self._off(goal, one)
            other_off = self._off(other_goal, other)
            self._learn(lap.tick, reference, off * off + other_off * other_off)
        area = self._area
        shake = self._dither.update(math.hypot(goal[1], other_goal[1]))
        return new_tuple(
            JointCommand,
            steps.after(area * (force - back), area * (other_force - other_back), shake),
        )

    def _off(self, goal: PairReference, measured: PairState) -> float:
        """Return how far a pair is from where it should be at its readings, m."""
        return goal.position - self.period * goal.velocity - measured.position

    def _corrected(self, reference: JointReference) -> tuple[Vector, Vector]:
        """Return the axis to go for and its rate: camera and learning change the reference."""
        lap, offset = reference.lap, self._camera.offset
        changed = offset != _ZERO
        if lap is None and not changed:
            return reference.axis, reference.velocity
        (x, y, z), (dx, dy, dz) = reference.axis, reference.velocity
        if changed:
            rate, share = self._camera.rate, 1.0 / self._height
            x, y, z = x + share * offset[0], y + share * offset[1], z + share * offset[2]
            dx, dy, dz = dx + share * rate[0], dy + share * rate[1], dz + share * rate[2]
        if lap is not None and self.learning is not None:
            self.learning.start_cycle(lap)
            memory = self._axis_memory
            if self.learning.active and memory is not None:
                before, now, after = (memory.at(lap.tick + k) for k in (-1, 0, 1))
                rate_share = self._rate
                x, y, z = x + now[0], y + now[1], z + now[2]
                dx += rate_share * (after[0] - before[0])
                dy += rate_share * (after[1] - before[1])
                dz += rate_share * (after[2] - before[2])
                changed = True
        if not changed:
            return reference.axis, reference.velocity
        scale = 1.0 / math.sqrt(x * x + y * y + z * z)
        return (scale * x, scale * y, scale * z), (scale * dx, scale * dy, scale * dz)

    def _learn(self, tick: int, reference: JointReference, squared: float) -> None:
        """Take what this cycle's errors teach."""
        learning = self.learning
        assert learning is not None
        if self._axis_memory is not None:
            # The marker is where it is now: the camera's bias holds what the encoders are late.
            (x, y, z), marker, share = reference.axis, self.marker.marker, 1.0 / self._height
            error = (x - share * marker[0], y - share * marker[1], z - share * marker[2])
            self._axis_memory.learn(tick, error)
            squared = error[0] ** 2 + error[1] ** 2 + error[2] ** 2
        if self._force_memory is not None:
            first, second = self._laws
            self._force_memory.learn(tick, (first.correction, second.correction))
        learning.add_score(squared)
