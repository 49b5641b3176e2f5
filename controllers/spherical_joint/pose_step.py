"""What a pose controller works out around its laws, in one compiled call before and one after.

Kinematics, friction on the ball and tensions are arithmetic on some sixty numbers in every cycle:
spread over a dozen calls from Python it took three times as long as both laws of the pairs.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from controllers.compiled import kernel_of
from controllers.spherical_joint import pose_kernel as kernel
from controllers.spherical_joint.forward import ForwardKinematics, unexplained
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.pose_kernel import Pair
from controllers.spherical_joint.poses import Vector, move_axis, natural_rotation
from controllers.spherical_joint.taut import PoseTensions, raised
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics

Triple = tuple[float, float, float]

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class StepSettings(NamedTuple):
    """What the steps are told beside the geometry.

    Parameters
    ----------
    area : float
        Of a cylinder, m².
    compliance : float
        Stretch of a wire that the rods make up for, m/N.
    least, lowest, most : float
        Tension that control leaves in a wire, and what setpoints may ask for, N.
    middle : float
        Pressure about which the laws see the force of a pair, Pa.
    decay : float
        By which what the chambers held at the start fades in a cycle.
    ahead : float
        By which the tensions that hold the ring go out early, s.
    ring, wire, slide : float
        Of the friction on the ball, see `ball_friction.slide`.
    """

    area: float
    compliance: float
    least: float
    lowest: float
    most: float
    middle: float
    decay: float
    ahead: float
    ring: float
    wire: float
    slide: float


class Step(NamedTuple):
    """What the laws and the estimate of the marker need of a cycle.

    Parameters
    ----------
    measured : tuple of tuple of float
        Of the pairs (1, 3) and (4, 2): position, m; agonist and antagonist, Pa gauge.
    goals : tuple of tuple of float
        Position, velocity and acceleration that they should have.
    friction : tuple of float
        On the ball, of each pair, N.
    rods : tuple of float
        Where the rods should be, m.
    hold : tuple of float
        Tensions that hold the pose without friction, N.
    axis : tuple of float
        Of the ring, as the rods say.
    residuals : tuple of float
        By how much each wire disagrees with it, m.
    """

    measured: tuple[Triple, Triple]
    goals: tuple[Triple, Triple]
    friction: Pair
    rods: Quadruple
    hold: Quadruple
    axis: Vector
    residuals: Quadruple


class PoseStep:
    """The steps before and after the laws, and what they remember.

    Parameters
    ----------
    settings : StepSettings
        See there.
    geometry : SphericalJointGeometry
        Dimensions.
    inverse : InverseKinematics
        Which wires and which poses the reference is for.
    """

    def __init__(
        self, settings: StepSettings, geometry: SphericalJointGeometry, inverse: InverseKinematics
    ) -> None:
        self._distribution = TensionDistribution(geometry)
        wires, regular, vanishing = self._distribution.constants
        searched, search_home = ForwardKinematics(geometry).constants
        area, compliance, least, lowest, most, middle, decay, ahead, ring, wire, slide = settings
        self._least = least
        self._inverse = inverse
        self._constants: kernel.Numbers = [
            *(area, compliance, least, lowest, most, middle, decay, ahead, vanishing),
            *(ring, wire, slide, float(regular is not None)),
            *_flat((wires, regular or wires, searched, search_home, inverse.home)),
        ]
        self._memory: kernel.Numbers = [0.0] * kernel.REMEMBERED
        self._before: Callable[..., Any] = kernel.before
        self._after: Callable[..., Quadruple] = kernel.after
        if inverse.is_natural:  # the others are there to be compared
            self._compile()

    def _compile(self) -> None:
        import numpy as np

        self._constants, self._memory = np.array(self._constants), np.array(self._memory)
        self._before, self._after = kernel_of(kernel.before_natural), kernel_of(kernel.after)

    def reset(self) -> None:
        """Forget the past."""
        self._memory[:] = [0.0] * kernel.REMEMBERED

    def before(
        self,
        axis: Vector,
        velocity: Vector,
        acceleration: Vector,
        rods: Quadruple,
        pressures: Quadruple,
        base: float,
        anew: bool,
        starts: bool,
    ) -> Step:
        """Return what a cycle is about.

        Parameters
        ----------
        axis, velocity, acceleration : tuple of float
            Wanted: unit vector, 1/s, 1/s².
        rods, pressures : tuple of float
            Measured, m and Pa gauge.
        base : float
            Mean of the setpoints at home, Pa gauge.
        anew : bool
            Work out which tensions hold the pose; else they are those of the last time.
        starts : bool
            What the chambers hold beyond that now fades from now on.

        Raises
        ------
        ValueError
            No pose explains the wires, or no tensions hold the reference.
        """
        if self._inverse.is_natural:
            wanted: tuple[Any, ...] = (axis, velocity, acceleration)
        else:
            motion = self._inverse.motion(axis, velocity, acceleration)
            wanted = ((*motion,), axis, velocity, acceleration)
        how, step = self._before(
            self._constants, self._memory, *wanted, rods, pressures, base, anew, starts
        )
        found: Step = _new(Step, step)
        if how != kernel.FOUND:
            self._refuse(how, found, axis, (velocity, acceleration))
        return found

    def after(self, first: float, second: float, shake: float) -> Quadruple:
        """Return the setpoints, Pa gauge, within what wires and regulators bear.

        Parameters
        ----------
        first, second : float
            Forces that the pairs shall have, N.
        shake : float
            What is added to the sum of the tensions, N.
        """
        return self._after(self._constants, self._memory, first, second, shake)

    def pushed(self, hold: Quadruple, first: float, second: float) -> Quadruple:
        """Return the setpoints (Pa gauge) that push the pairs (N) over what holds the pose."""
        tensions = self.pose.kept_taut(kernel.spread(hold, (first, second)), self._least)
        return kernel.setpoints(self._constants, tensions)

    @property
    def pose(self) -> PoseTensions:
        """What tensions do in the pose that was worked out last."""
        memory = [float(number) for number in self._memory]
        places = (kernel.SHARES, kernel.FIRST, kernel.SECOND)
        return PoseTensions(*(kernel.four(memory, place) for place in places))

    def _refuse(self, how: int, step: Step, axis: Vector, motion: tuple[Vector, Vector]) -> None:
        """Raise what a step was not possible for."""
        if how == kernel.NO_POSE:
            raise unexplained(step.residuals)
        later = move_axis(axis, *motion, float(self._constants[kernel.AHEAD]))
        memory = [float(number) for number in self._memory]
        for place, at in ((axis, kernel.SHARES), (later, kernel.LATER)):
            self._distribution.at(natural_rotation(place))  # says so if a wire has no way
            shares = kernel.four(memory, at)
            raised(shares, shares, 0.0)


def _flat(values: Any) -> Iterator[float]:
    """Yield the numbers of nested tuples in their order."""
    for value in values:
        if isinstance(value, tuple):
            yield from _flat(value)
        else:
            yield value
