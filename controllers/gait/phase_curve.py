"""Both legs as one system on one phase's path, one step at a time.

While the waist is upright each leg has three rates that count, so the state is six angles and the
path parameter; where waist or feet turn, the hips' joints follow from these. A step follows the
ray, along the joints' arc length or along the path's length. The curve is the same either way; the
joints' length is the parameter that stays regular at a straight knee.
"""

import bisect
import itertools
import math

from controllers.compiled import KernelMemory
from controllers.gait import phase_curve_kernel
from controllers.gait.geometry import KNEES, LegGeometry
from controllers.gait.kinematics import inverse
from controllers.gait.phase_curve_kernel import PhaseNumbers
from controllers.gait.phases import GaitPhase, LegPath
from controllers.gait.types import Joints
from controllers.motion import InfeasibleMotion

_REST: Joints = (0.0,) * 12
_PIECES = 64
"""Of a path whose length is asked for."""
_EARLY = 1e-6
"""By which the path parameter may pass its end by the rule's rounding before the joints are there:
0.1 µm of a step of 0.1 m."""
_NEWTON, _EXACT = 8, 1e-15
"""Most steps to a place on the path, and the error there at which they end, of its length."""
_BEFORE_END = math.nextafter(1.0, 0.0)


class PhaseCurve:
    """The curve of the joints in one phase, followed step by step.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    phase : GaitPhase
        The path.
    period : float
        Of one step, for the velocities, s.

    Attributes
    ----------
    joints, velocities : tuple of float
        Of the twelve joints, rad, and their mean rates in the last step, rad/s.
    path : float
        The path parameter, 0 … 1.

    Raises
    ------
    InfeasibleMotion
        The phase begins out of reach.

    References
    ----------
    Kameta et al., eq. (2) and (3): one path parameter for both legs keeps them synchronised.

    Notes
    -----
    The literal equation (3) stops where one leg is straight and has no demand, and where both are
    straight. Here a leg without demand is left out of the system, and two straight legs start in
    the one direction in which their path rates agree.

    The step is the classical Runge-Kutta rule: Euler's would leave the path by 30 µm in a phase.
    """

    def __init__(self, geometry: LegGeometry, phase: GaitPhase, period: float) -> None:
        self.phase = phase
        self._period = period
        self._geometry = geometry
        self._legs = right, left = phase.legs(geometry)
        self._leading = left if path_length(left) > path_length(right) else right
        self._covered: tuple[float, ...] | None = None  # of whom takes the path by its length
        numbers = PhaseNumbers(geometry.thigh, geometry.shank, right, left, self._leading)
        memory = KernelMemory(numbers)
        self._follow = memory.bind(phase_curve_kernel.follow)
        self._rates = memory.bind(phase_curve_kernel.rates)
        self.begin()

    def joints_at(self, xi: float) -> Joints:
        """Return all twelve joint angles at a path parameter, by the closed-form inverse.

        Raises
        ------
        InfeasibleMotion
            Out of reach there.
        """
        right, left = self._legs
        try:
            angles = inverse(self._geometry, right.at(xi), right.rotation(xi))
            return angles + inverse(self._geometry, left.at(xi), left.rotation(xi))
        except InfeasibleMotion as error:
            raise InfeasibleMotion(
                f"{self.phase.name}, {100.0 * xi:.1f} % of the way: {error}"
            ) from error

    def begin(self) -> None:
        """Go to the start of the phase, at rest."""
        self.joints = self.joints_at(0.0)
        self.velocities = _REST
        self.path = 0.0

    def finish(self) -> None:
        """Go to the end of the phase exactly: it takes away what rounding has added up."""
        self._go_to(1.0)

    def speed(self, xi: float) -> float:
        """Return the path's length per path parameter, of the leg that goes farther, m."""
        x, y, z = self._leading.tangent(xi)
        return math.sqrt(x * x + y * y + z * z)

    def rates(self) -> tuple[float, float]:
        """Return the norm of the twelve joint rates and the path's speed (m), up to one scale."""
        norm, speed = self._rates(self.joints, self.path)
        return norm, speed

    def follow_joints(self, length: float) -> None:
        """Go on by a length of the curve of all twelve joints, rad, at most to the phase's end.

        What leads beyond it would bend a straight knee backwards. The path parameter alone may
        come to the end a little early, where it hardly grows while the knee straightens.
        """
        if self.path >= 1.0:
            self.velocities = _REST
            return
        joints, velocities, path, outcome = self._follow(
            self.joints, self.path, length, False, self._period
        )
        if outcome:
            self._refuse(outcome)
        if path > 1.0 + _EARLY or (path > 1.0 and min(joints[k] for k in KNEES) < 0.0):
            self.finish()
        else:
            self.joints, self.velocities, self.path = joints, velocities, min(path, _BEFORE_END)

    def follow_path(self, length: float) -> None:
        """Go on by a length of the path, m; not where a leg is straight."""
        self.joints, self.velocities, self.path, outcome = self._follow(
            self.joints, self.path, length, True, self._period
        )
        if outcome:
            self._refuse(outcome)

    def place(self, share: float) -> None:
        """Go to where a share of the path's length is covered, by the closed-form inverse.

        The place is found anew each time: what rounding adds up over a phase would be made good in
        its last period, where a knee that straightens magnifies it by a square root.
        """
        self._go_to(self._parameter(min(max(share, 0.0), 1.0)))

    def _parameter(self, share: float) -> float:
        """Return the path parameter there, by Newton's method within one piece of the path."""
        if self._covered is None:
            self._covered = _covered(self._leading)
        covered = self._covered
        length = share * covered[-1]
        k = min(bisect.bisect_right(covered, length), _PIECES) - 1
        begin, left = k / _PIECES, length - covered[k]
        xi = begin + left / self.speed(begin)
        for _ in range(_NEWTON):
            off = _arc(self._leading, begin, xi) - left
            xi -= off / self.speed(xi)
            if abs(off) <= _EXACT * covered[-1]:
                break
        return min(max(xi, 0.0), 1.0)

    def _go_to(self, xi: float) -> None:
        joints, rate = self.joints_at(xi), 1.0 / self._period
        self.velocities = tuple(
            [rate * (there - here) for here, there in zip(self.joints, joints, strict=True)]
        )
        self.joints = joints
        self.path = xi

    def _refuse(self, outcome: int) -> None:
        if outcome == phase_curve_kernel.TANGENTIAL:
            raise InfeasibleMotion(
                f"{self.phase.name}: both legs are straight and the path runs along the reach of "
                "one of them; no direction is singled out."
            )
        raise InfeasibleMotion(f"{self.phase.name}: no joint moves the legs along this path.")


def path_length(path: LegPath) -> float:
    """Return the length of a leg's path, m (Simpson's rule; a straight line exactly)."""
    return _covered(path)[-1]


def _covered(path: LegPath) -> tuple[float, ...]:
    """Return what is covered at the end of each piece of a path, m, from nothing on."""
    pieces = (_arc(path, k / _PIECES, (k + 1) / _PIECES) for k in range(_PIECES))
    return tuple(itertools.accumulate(pieces, initial=0.0))


def _arc(path: LegPath, begin: float, end: float) -> float:
    """Return the length between two path parameters that are near each other, m (Simpson)."""
    middle = 0.5 * (begin + end)
    speeds = [math.hypot(*path.tangent(xi)) for xi in (begin, middle, end)]
    return (end - begin) * (speeds[0] + 4.0 * speeds[1] + speeds[2]) / 6.0
