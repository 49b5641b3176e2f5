"""What a pose controller works out around its laws, in one compiled call before and one after.

Kinematics, friction on the ball and tensions are arithmetic on some sixty numbers in every cycle:
spread over a dozen calls from Python it took three times as long as both laws of the pairs.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from controllers.compiled import KernelMemory
from controllers.named_tuples import new_tuple
from controllers.spherical_joint import pose_kernel as kernel
from controllers.spherical_joint.forward import ForwardKinematics, unexplained
from controllers.spherical_joint.geometry import Pair, Quadruple, SphericalJointGeometry
from controllers.spherical_joint.pose_kernel import (
    Cycle,
    PoseNumbers,
    Remembered,
    StepSettings,
    Triple,
)
from controllers.spherical_joint.poses import Vector, move_axis, natural_rotation
from controllers.spherical_joint.taut import PoseTensions, raised
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics

_HOME: Vector = (0.0, 0.0, 1.0)
_REST: Vector = (0.0, 0.0, 0.0)
_NO_RODS: Quadruple = (0.0, 0.0, 0.0, 0.0)


class PoseInputs(NamedTuple):
    """A cycle's inputs to the laws and to the estimate of the marker.

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
        self._settings = settings
        self._distribution = distribution = TensionDistribution(geometry)
        self._numbers = numbers = PoseNumbers(
            settings,
            distribution.wires,
            distribution.regular,
            ForwardKinematics(geometry).constants,
            inverse.home,
        )
        self.numbers: PoseNumbers | None = numbers if inverse.is_natural else None
        """Of the functions that are compiled; None: these wires and poses have none."""
        self._memory: KernelMemory[PoseNumbers] | None = None
        self._before: Callable[..., tuple[int, Cycle]] = (
            partial(kernel.before_natural, numbers)
            if inverse.is_natural
            else partial(_before_others, inverse, numbers)
        )
        self._after: Callable[[float, float, float], Quadruple] = partial(kernel.after, numbers)
        self._remembered: Callable[[], Remembered] = partial(kernel.remembered, numbers)

    def compile(self) -> None:
        """Have the steps compiled, for what is called in every cycle."""
        if self.numbers is None:  # the others are there to be compared
            return
        self._memory = KernelMemory(self.numbers)
        self._before = self._memory.bind(kernel.before_natural)
        self._after = self._memory.bind(kernel.after)
        self._remembered = self._memory.bind(kernel.remembered)
        self._call_each()
        self._memory.lay(self._numbers)

    def _call_each(self) -> None:
        """Call the steps once, for home at rest: the first call is what compiles."""
        middle = self._settings.middle
        self._before(_HOME, _REST, _REST, _NO_RODS, (middle,) * 4, middle, True, True)
        self._after(0.0, 0.0, 0.0)
        self._remembered()

    def reset(self) -> None:
        """Forget the past."""
        self._numbers.reset()
        if self._memory is not None:
            self._memory.lay(self._numbers)

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
    ) -> PoseInputs:
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
        how, step = self._before(axis, velocity, acceleration, rods, pressures, base, anew, starts)
        found: PoseInputs = new_tuple(PoseInputs, step)
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
        return self._after(first, second, shake)

    def pushed(self, hold: Quadruple, first: float, second: float) -> Quadruple:
        """Return the setpoints (Pa gauge) that push the pairs (N) over what holds the pose."""
        settings = self._settings
        tensions = self.pose.kept_taut(kernel.spread(hold, (first, second)), settings.least)
        return kernel.setpoints(settings, tensions)

    @property
    def pose(self) -> PoseTensions:
        """What tensions do in the pose that was worked out last."""
        return PoseTensions(*self._remembered()[:3])

    def _refuse(
        self, how: int, step: PoseInputs, axis: Vector, motion: tuple[Vector, Vector]
    ) -> None:
        """Raise what a step was not possible for."""
        if how == kernel.NO_POSE:
            raise unexplained(step.residuals)
        shares, _, _, shares_ahead = self._remembered()
        ahead = move_axis(axis, *motion, self._settings.ahead)
        for place, found in ((axis, shares), (ahead, shares_ahead)):
            self._distribution.at(natural_rotation(place))  # says so if a wire has no way
            raised(found, found, 0.0)


def _before_others(
    inverse: InverseKinematics,
    numbers: PoseNumbers,
    axis: Vector,
    velocity: Vector,
    acceleration: Vector,
    *measured: Any,
) -> tuple[int, Cycle]:
    """Do what `before_natural` does, for the wires and poses that it is not for."""
    motion = inverse.motion(axis, velocity, acceleration)
    return kernel.before(numbers, motion, axis, velocity, acceleration, *measured)
