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
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Protocol

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)
from controllers.spherical_joint.ball_friction import BallFriction
from controllers.spherical_joint.camera_loop import CameraLoop, CameraLoopSettings
from controllers.spherical_joint.dither import DitherSettings, TensionDither
from controllers.spherical_joint.geometry import PAIRS, Quadruple
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
from controllers.spherical_joint.poses import (
    PoseConvention,
    Vector,
    move_axis,
    natural_rotation,
)
from controllers.spherical_joint.tension import TensionDistribution, raised
from controllers.spherical_joint.types import (
    JointCommand,
    JointEstimate,
    JointModel,
    JointReference,
    JointState,
)
from controllers.spherical_joint.wires import InverseKinematics, WireKind

_START_TIME = 0.2
"""With which the tensions that are found at the start give way to the wanted ones, s."""


_POSE_EVERY = 4
"""Shares of the tensions are worked out every so many cycles: within 4 ms, a ring at 1 Hz and 20
degrees changes them by some 0.5 %."""


class PairLaw(Protocol):
    """A law for one antagonistic pair."""

    estimate: PairEstimate
    correction: float

    def reset(self, state: PairState) -> None:
        """Start bumplessly from a measured state."""
        ...

    def update(self, state: PairState, reference: PairReference, load: float = 0.0) -> PairCommand:
        """Return the setpoints of the pair."""
        ...


@dataclass(frozen=True, slots=True)
class JointLearningSettings:
    """What is learnt over the laps of a repeated motion.

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
    """What all pose controllers have in common.

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
    stretch: Annotated[float, Ge(0), Le(1)] = 1.0
    camera: CameraLoopSettings = field(default_factory=CameraLoopSettings)
    estimate: MarkerEstimateSettings = field(default_factory=MarkerEstimateSettings)
    learning: JointLearningSettings | None = None


class PoseController:
    """Inverse kinematics, two pair laws, two mean pressures.

    Parameters
    ----------
    settings : PoseControlSettings
        With the settings of the pair's law as `pair`.
    model : JointModel
        Geometry, cylinders, friction, tension limits.
    period : float
        The loop's period, s.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", sections 3 and 6.
    """

    law: ClassVar[type[Any]]
    """Makes the law of a pair from its settings."""

    def __init__(self, settings: Any, model: JointModel, period: float) -> None:
        self.settings: PoseControlSettings = settings
        """As the profile gives them."""
        self._period = period
        self._area = model.area
        self._height = model.geometry.marker_height
        self._compliance = settings.stretch / model.wire_stiffness
        self._inverse = InverseKinematics(model.geometry, settings.wire, settings.pose)
        self._inverse.compile()
        self._distribution = TensionDistribution(model.geometry)
        self._distribution.compile()
        self._marker = MarkerEstimator(settings.estimate, model.geometry, period)
        self._camera = CameraLoop(settings.camera, period)
        wound = 0.5 * math.pi - model.geometry.ring_half_angle
        self._friction = BallFriction(
            settings.ball_friction * model.ring_friction,
            settings.ball_friction * model.wire_friction * wound,
            settings.friction_distance,
            period,
        )
        self._dither = TensionDither(settings.dither, model, period)
        # What the seals may take away from the pull of a chamber, or add to it.
        seal = 0.5 * model.breakaway
        self._lowest = model.area * model.pressure_min
        self._least = max(model.least_tension + seal + self._dither.tension, self._lowest)
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
            coulomb=model.coulomb,
            breakaway=model.breakaway,
            stribeck_velocity=model.stribeck_velocity,
            viscous=model.viscous,
        )
        self._laws: tuple[PairLaw, PairLaw] = (
            self.law(settings.pair, pair, period),
            self.law(settings.pair, pair, period),
        )
        # A pressure comes so much later than its setpoint while it changes evenly.
        self._ahead = 2.0 * model.regulator_damping / model.regulator_bandwidth
        self._start_decay = math.exp(-period / _START_TIME)
        self._start: Quadruple | None = None
        self._cycle = 0
        self._pose = self._distribution.at(natural_rotation((0.0, 0.0, 1.0)))
        self._later = self._pose.shares
        self._pushed = False
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
        zero = (0.0, 0.0, 0.0)
        self.estimate = JointEstimate(zero, zero, 0.0, (0.0,) * 4, (0.0,) * 4)
        """Marker, residual, wanted rods and tensions."""
        self.marker = MarkerEstimate(zero, zero, zero, zero, 0.0, math.inf, ())
        """The estimate of the marker with its bias and its alarms."""

    def reset(self, state: JointState) -> None:
        """Start bumplessly: the first command is what was measured."""
        self._marker.reset()
        self._camera.reset()
        self._friction.reset()
        self._dither.reset()
        if self.learning is not None:
            self.learning.reset()
        self._start, self._pushed = None, False
        self._cycle = 0

    def update(self, state: JointState, reference: JointReference) -> JointCommand:
        """Return the four setpoints of this period.

        Raises
        ------
        ValueError
            No pose explains the wires, or no tensions hold the reference.
        """
        area = self._area
        axis, velocity = self._corrected(reference)
        position, rate, acceleration = self._inverse.motion(axis, velocity, reference.acceleration)
        if self._cycle % _POSE_EVERY == 0:
            self._pose = self._distribution.at(natural_rotation(axis))
            self._later = self._distribution.shares(
                natural_rotation(move_axis(axis, velocity, reference.acceleration, self._ahead))
            )
        self._cycle += 1
        pose = self._pose
        pull = _scaled(area, state.pressures)
        base = reference.base_pressure or self._base_pressure
        hold = self._hold(pose.shares, base)
        rates = (0.5 * (rate[0] - rate[2]), 0.5 * (rate[3] - rate[1]))
        friction = self._friction.update(rates, (hold[0] + hold[2], hold[3] + hold[1]))
        # The rods pull in by what the wires stretch under what they bear.
        stretch = _spread(_scaled(sum(pull) / sum(hold), hold), friction)
        stretch = _scaled(self._compliance, stretch)
        rods = _sum(position, stretch)
        self._estimate(state, stretch, rods, hold)
        if reference.push is not None:
            self._pushed = True
            return self._command(pose.kept_taut(_spread(hold, reference.push), self._least))
        if self._pushed:  # control starts anew from where the pushes have left the ring
            self._pushed, self._start = False, None

        lap = reference.lap if self.learning is not None and self.learning.active else None
        learnt: tuple[float, ...] = (0.0, 0.0)
        if lap is not None and self._force_memory is not None:
            learnt = self._force_memory.at(lap.tick)
        forces = pose.pair_forces(pull)
        measured = [
            PairState(
                state.t,
                0.5 * (state.rods[one] - state.rods[other]),
                self._base + 0.5 * force / area,
                self._base - 0.5 * force / area,
            )
            for force, (one, other) in zip(forces, PAIRS, strict=True)
        ]
        if self._start is None:
            # What the chambers hold beyond that at the start fades away.
            self._start = _sum(pull, _scaled(-1.0, _spread(hold, forces)))
            for law, pair in zip(self._laws, measured, strict=True):
                law.reset(pair)
        wanted, squared = [], 0.0
        for number, (one, other) in enumerate(PAIRS):
            goal = PairReference(
                0.5 * (rods[one] - rods[other]),
                rates[number],
                0.5 * (acceleration[one] - acceleration[other]),
            )
            command = self._laws[number].update(
                measured[number], goal, friction[number] + learnt[number]
            )
            wanted.append(area * (command.agonist - command.antagonist))
            then = goal.position - self._period * goal.velocity
            squared += (then - measured[number].position) ** 2
        if lap is not None:
            self._learn(lap.tick, reference, squared)
        # What holds the ring goes out early, past the laws: it has to be there in time.
        later = self._hold(self._later, base)
        tensions = pose.kept_taut(
            _spread(_sum(later, self._start), (wanted[0], wanted[1])), self._least
        )
        self._start = _scaled(self._start_decay, self._start)
        dither = _scaled(self._dither.update(math.hypot(*rates)), pose.shares)
        return self._command(_sum(tensions, dither))

    def _command(self, tensions: Quadruple) -> JointCommand:
        """Return the setpoints that pull so, within what wires and regulators bear."""
        area, lowest, most = self._area, self._lowest, self._most
        first, second, third, fourth = tensions
        return JointCommand(
            min(max(first, lowest), most) / area,
            min(max(second, lowest), most) / area,
            min(max(third, lowest), most) / area,
            min(max(fourth, lowest), most) / area,
        )

    def _hold(self, shares: Quadruple, base: float) -> Quadruple:
        """Return the tensions that hold the ring in a pose: co-contraction, no wire too slack."""
        return raised(_scaled(4.0 * self._area * base, shares), shares, self._least)

    def _estimate(
        self, state: JointState, stretch: Quadruple, rods: Quadruple, hold: Quadruple
    ) -> None:
        wires = _sum(state.rods, _scaled(-1.0, stretch))
        self.marker = marker = self._marker.update(state.t, wires, state.camera)
        self._camera.update(marker)
        self.estimate = JointEstimate(
            marker.marker, marker.encoder_marker, marker.residual, rods, hold
        )

    def _corrected(self, reference: JointReference) -> tuple[Vector, Vector]:
        """Return the axis to go for and its rate: camera and learning change the reference."""
        (x, y, z), (dx, dy, dz) = reference.axis, reference.velocity
        offset, rate, share = self._camera.offset, self._camera.rate, 1.0 / self._height
        changed = offset != (0.0, 0.0, 0.0)
        if changed:
            x, y, z = x + share * offset[0], y + share * offset[1], z + share * offset[2]
            dx, dy, dz = dx + share * rate[0], dy + share * rate[1], dz + share * rate[2]
        lap = reference.lap
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


def _scaled(factor: float, values: Quadruple) -> Quadruple:
    a, b, c, d = values
    return (factor * a, factor * b, factor * c, factor * d)


def _sum(first: Quadruple, second: Quadruple) -> Quadruple:
    (a, b, c, d), (e, f, g, h) = first, second
    return (a + e, b + f, c + g, d + h)


def _spread(tensions: Quadruple, forces: tuple[float, float]) -> Quadruple:
    """Return tensions with the pairs' forces, half on either wire (see `PAIRS`)."""
    (a, b, c, d), (first, second) = tensions, forces
    return (a + 0.5 * first, b - 0.5 * second, c - 0.5 * first, d + 0.5 * second)
