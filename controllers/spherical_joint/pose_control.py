"""Pose control: inverse kinematics over two antagonistic pairs, and tensions that keep wires taut.

The joint's four cylinders are two pairs. Each pair's position follows the difference of its wires'
shortenings under one of the laws for a pair of cylinders; what is left, the mean pressure of each
pair, holds the wires taut without turning the ring. A wire's own length is not controlled: round a
circle at 20 degrees the sum of two opposite ones changes by 1.3 mm, so that a position loop on each
would make the two fight.
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
from controllers.spherical_joint.geometry import PAIRS
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
    natural_rotation,
)
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.types import (
    JointCommand,
    JointEstimate,
    JointModel,
    JointReference,
    JointState,
)
from controllers.spherical_joint.wires import InverseKinematics, WireKind

_MEAN_TIME = 0.2
"""With which the mean pressures go from the measured ones to the wanted ones at the start, s."""


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
        self._settings: PoseControlSettings = settings
        self.settings: PoseControlSettings = settings
        """As the profile gives them."""
        self._area = model.area
        self._height = model.geometry.marker_height
        self._compliance = 0.5 / model.wire_stiffness
        self._inverse = InverseKinematics(model.geometry, settings.wire, settings.pose)
        self._distribution = TensionDistribution(model.geometry)
        self._marker = MarkerEstimator(settings.estimate, model.geometry, period)
        self._camera = CameraLoop(settings.camera, period)
        wound = 0.5 * math.pi - model.geometry.ring_half_angle
        self._friction = BallFriction(
            settings.ball_friction * model.ring_friction,
            settings.ball_friction * model.wire_friction * wound,
            settings.friction_distance,
            period,
        )
        # What the seals may take away from the pull of a chamber.
        seal = 0.5 * model.breakaway
        self._least = model.least_tension + seal
        self._total = 4.0 * model.area * model.base_pressure
        self._floor = max(self._least / model.area, model.pressure_min)
        self._ceiling = min((model.most_tension - seal) / model.area, model.pressure_max)
        pair = PairModel(
            area=model.area,
            mass=model.mass,
            # The law only splits around it; its differential may take the whole range.
            base_pressure=0.5 * (self._floor + self._ceiling),
            pressure_min=self._floor,
            pressure_max=self._ceiling,
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
        self._mean_share = 1.0 - math.exp(-period / _MEAN_TIME)
        self._means = [0.0, 0.0]
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
        if self.learning is not None:
            self.learning.reset()
        for number, (law, (one, other)) in enumerate(zip(self._laws, PAIRS, strict=True)):
            law.reset(_pair_state(state, one, other))
            self._means[number] = 0.5 * (state.pressures[one] + state.pressures[other])

    def update(self, state: JointState, reference: JointReference) -> JointCommand:
        """Return the four setpoints of this period.

        Raises
        ------
        ValueError
            No pose explains the wires, or no tensions hold the reference.
        """
        settings = self._settings
        axis, velocity = self._corrected(reference)
        motion = self._inverse.motion(axis, velocity, reference.acceleration)
        tensions = self._distribution.hold(natural_rotation(axis), self._least, self._total)
        # Both pairs' velocities are needed before either's friction is known.
        velocities = [0.5 * (motion.velocity[one] - motion.velocity[other]) for one, other in PAIRS]
        sums = [tensions[one] + tensions[other] for one, other in PAIRS]
        friction = self._friction.update((velocities[0], velocities[1]), (sums[0], sums[1]))
        lap = reference.lap if self.learning is not None and self.learning.active else None
        learnt = (0.0, 0.0)
        if lap is not None and self._force_memory is not None:
            learnt = self._force_memory.at(lap.tick)  # type: ignore[assignment]
        setpoints = [0.0] * 4
        rods = [0.0] * 4
        wires = [0.0] * 4
        errors = 0.0
        for number, (one, other) in enumerate(PAIRS):
            hold = tensions[one] - tensions[other]
            load = hold + friction[number]
            pair = _pair_state(state, one, other)
            # The rods pull in by what the wires stretch: pulled apart by the load, together by
            # the mean of the two pressures.
            apart = settings.stretch * self._compliance * load
            common = (
                settings.stretch * self._compliance * self._area * (pair.agonist + pair.antagonist)
            )
            wanted = 0.5 * (motion.position[one] - motion.position[other]) + apart
            law = self._laws[number]
            command = law.update(
                pair,
                PairReference(
                    wanted,
                    velocities[number],
                    0.5 * (motion.acceleration[one] - motion.acceleration[other]),
                ),
                load + learnt[number],
            )
            half = 0.5 * (command.agonist - command.antagonist)
            mean = self._mean(number, 0.5 * sums[number] / self._area, abs(half))
            setpoints[one], setpoints[other] = mean + half, mean - half
            rods[one] = motion.position[one] + common + apart
            rods[other] = motion.position[other] + common - apart
            wires[one] = state.rods[one] - common - apart
            wires[other] = state.rods[other] - common + apart
            errors += (wanted - pair.position) ** 2
        self.marker = marker = self._marker.update(
            state.t, (wires[0], wires[1], wires[2], wires[3]), state.camera
        )
        self._camera.update(marker)
        self.estimate = JointEstimate(
            marker.marker,
            marker.encoder_marker,
            marker.residual,
            (rods[0], rods[1], rods[2], rods[3]),
            tensions,
        )
        if lap is not None:
            self._learn(lap.tick, reference.axis, errors)
        return JointCommand(setpoints[0], setpoints[1], setpoints[2], setpoints[3])

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

    def _mean(self, number: int, wanted: float, half: float) -> float:
        """Return the mean pressure of a pair: as wanted, and higher where a wire would go slack."""
        mean = self._means[number]
        mean += self._mean_share * (wanted - mean)
        self._means[number] = mean
        return min(max(mean, self._floor + half), self._ceiling - half)

    def _learn(self, tick: int, axis: Vector, squared: float) -> None:
        learning = self.learning
        assert learning is not None
        if self._axis_memory is not None:
            marker, share = self.marker.marker, 1.0 / self._height
            error = (
                axis[0] - share * marker[0],
                axis[1] - share * marker[1],
                axis[2] - share * marker[2],
            )
            self._axis_memory.learn(tick, error)
            squared = error[0] ** 2 + error[1] ** 2 + error[2] ** 2
        if self._force_memory is not None:
            first, second = self._laws
            self._force_memory.learn(tick, (first.correction, second.correction))
        learning.add_score(squared)


def _pair_state(state: JointState, one: int, other: int) -> PairState:
    """Return what is measured of a pair; its position is half the difference of its rods'."""
    return PairState(
        state.t,
        0.5 * (state.rods[one] - state.rods[other]),
        state.pressures[one],
        state.pressures[other],
    )
