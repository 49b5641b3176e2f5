"""Both legs as one system on one phase's path, one step at a time.

While the waist is upright each leg has three rates that count (knee, ankle pitch and ankle roll;
see `controllers.gait.leg_ray.UprightRay`), so the state is six angles and the path parameter. A
step follows the ray by the classical fourth-order Runge-Kutta rule, along the joints' arc length
or along the path's length. The curve is the same either way; the joints' length is the parameter
that stays regular at a straight knee.
"""

import math
from collections.abc import Callable

from controllers.gait.geometry import JOINT_NAMES, LegGeometry
from controllers.gait.kinematics import inverse
from controllers.gait.leg_ray import upright_ray
from controllers.gait.phases import LegPath, Phase
from controllers.gait.types import Joints
from controllers.motion import InfeasibleMotion
from controllers.singularity.ray import rank_two_start

State = tuple[float, float, float, float, float, float, float]
"""Knee, ankle pitch and ankle roll of the right and of the left leg, rad; path parameter."""

_STRAIGHT = 1e-9
"""sin(knee) below which both legs count as straight together: rounding of the last step."""


class PhaseCurve:
    """What the joints go through in one phase, followed step by step.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    phase : Phase
        The path.

    Raises
    ------
    InfeasibleMotion
        The phase begins out of reach.

    References
    ----------
    Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC
    approach", eq. (2) and (3): one path parameter for both legs keeps them synchronised.

    Notes
    -----
    The literal equation (3) stops where one leg is straight and has no demand, and where both are
    straight. Here a leg without demand is left out of the system, and two straight legs start in
    the one direction in which their path rates agree.
    """

    def __init__(self, geometry: LegGeometry, phase: Phase) -> None:
        self.phase = phase
        self._thigh, self._shank = geometry.thigh, geometry.shank
        self._straight = _STRAIGHT * geometry.thigh * geometry.shank
        self._right, self._left = phase.legs(geometry)
        self._geometry = geometry
        self._leading = max((self._right, self._left), key=path_length)
        self._moving = (self._right.moves, self._left.moves)
        self.state = self.state_at(0.0)

    def state_at(self, xi: float) -> State:
        """Return the exact state at a path parameter, by the closed-form inverse.

        Raises
        ------
        InfeasibleMotion
            Out of reach there.
        """
        angles: list[float] = []
        for name, path in (("right", self._right), ("left", self._left)):
            try:
                angles += inverse(self._geometry, path.at(xi))[3:]
            except InfeasibleMotion as error:
                raise InfeasibleMotion(
                    f"{self.phase.name}, {name} leg, {100.0 * xi:.1f} % of the way: {error}"
                ) from error
        right_knee, right_pitch, right_roll, left_knee, left_pitch, left_roll = angles
        return (right_knee, right_pitch, right_roll, left_knee, left_pitch, left_roll, xi)

    def begin(self) -> None:
        """Go to the start of the phase."""
        self.state = self.state_at(0.0)

    def finish(self) -> None:
        """Go to the end of the phase exactly: it takes away what rounding has added up."""
        self.state = self.state_at(1.0)

    @property
    def joints(self) -> Joints:
        """All twelve joint angles, rad."""
        return joints_of(self.state)

    @property
    def path(self) -> float:
        """The path parameter, 0 … 1."""
        return self.state[6]

    def speed(self, xi: float) -> float:
        """Return the path's length per path parameter, of the leg that goes farther, m."""
        x, y, z = self._leading.tangent(xi)
        return math.sqrt(x * x + y * y + z * z)

    def rates(self) -> tuple[float, float]:
        """Return the norm of the twelve joint rates and the path's speed (m), up to one scale."""
        *_, path, norm = self._ray(self.state)
        return norm, abs(path) * self.speed(self.state[6])

    def follow_joints(self, length: float) -> None:
        """Go on by a length of the curve of all twelve joints, rad."""
        self.state = _runge_kutta(self._per_joint_length, self.state, length)

    def follow_path(self, length: float) -> None:
        """Go on by a length of the path, m; not where a leg is straight."""
        self.state = _runge_kutta(self._per_path_length, self.state, length)

    def place_path(self, length: float) -> None:
        """Go on by a length of the path, m, by the inverse kinematics instead of the ray."""
        xi = self.state[6]
        middle = 1.0 / self.speed(xi + 0.5 * length / self.speed(xi))
        before, after = 1.0 / self.speed(xi), 1.0 / self.speed(xi + length * middle)
        xi += length * (before + 4.0 * middle + after) / 6.0
        self.state = self.state_at(min(max(xi, 0.0), 1.0))

    def _per_joint_length(self, state: State) -> State:
        a, b, c, d, e, f, path, norm = self._ray(state)
        if norm == 0.0:
            raise InfeasibleMotion(f"{self.phase.name}: no joint moves the legs along this path.")
        scale = 1.0 / norm
        return (scale * a, scale * b, scale * c, scale * d, scale * e, scale * f, scale * path)

    def _per_path_length(self, state: State) -> State:
        a, b, c, d, e, f, path, _ = self._ray(state)
        scale = 1.0 / (path * self.speed(state[6]))
        return (scale * a, scale * b, scale * c, scale * d, scale * e, scale * f, scale * path)

    def _ray(self, state: State) -> tuple[float, float, float, float, float, float, float, float]:
        """Return the rates of the six angles and of the path, and the norm of all twelve joints."""
        xi = state[6]
        if self._moving[0]:
            tangent = self._right.tangent(xi)
            moves = tangent != (0.0, 0.0, 0.0)
            if moves:
                a, b, c, right = upright_ray(
                    self._thigh, self._shank, state[0], state[1], state[2], tangent
                )
        else:
            moves = False
        if self._moving[1]:
            tangent = self._left.tangent(xi)
            if tangent != (0.0, 0.0, 0.0):
                d, e, f, left = upright_ray(
                    self._thigh, self._shank, state[3], state[4], state[5], tangent
                )
                if not moves:
                    norm = math.sqrt(d * d + e * e + (d + e) ** 2 + 2.0 * f * f)
                    return (0.0, 0.0, 0.0, d, e, f, left, norm)
                scale = max(abs(right), abs(left))
                if scale > self._straight:
                    # One path rate for both: each ray takes the other leg's determinant.
                    ours, theirs = left / scale, right / scale
                    if ours < 0.0 and theirs < 0.0:
                        ours, theirs = -ours, -theirs
                    path = right * ours
                else:
                    ours, theirs = self._both_straight(a, d)
                    path = 0.0
                a, b, c = ours * a, ours * b, ours * c
                d, e, f = theirs * d, theirs * e, theirs * f
                norm = math.sqrt(
                    a * a
                    + b * b
                    + (a + b) ** 2
                    + d * d
                    + e * e
                    + (d + e) ** 2
                    + 2.0 * (c * c + f * f)
                )
                return (a, b, c, d, e, f, path, norm)
        if not moves:
            return (0.0,) * 8
        norm = math.sqrt(a * a + b * b + (a + b) ** 2 + 2.0 * c * c)
        return (a, b, c, 0.0, 0.0, 0.0, right, norm)

    def _both_straight(self, right_knee: float, left_knee: float) -> tuple[float, float]:
        # A leg's determinant grows with its knee alone, which is straight.
        try:
            return rank_two_start(right_knee, left_knee)
        except ValueError as error:
            raise InfeasibleMotion(f"{self.phase.name}: {error}") from error


def joints_of(state: State) -> Joints:
    """Return the twelve joint angles of a state (rad): upright waist, flat feet."""
    a, b, c, d, e, f, _ = state
    return (0.0, -c, -a - b, a, b, c, 0.0, -f, -d - e, d, e, f)


def path_length(path: LegPath, pieces: int = 64) -> float:
    """Return the length of a leg's path, m (Simpson's rule; a straight line exactly)."""
    total = 0.0
    for k in range(2 * pieces + 1):
        x, y, z = path.tangent(k / (2 * pieces))
        weight = 1.0 if k in (0, 2 * pieces) else 4.0 if k % 2 else 2.0
        total += weight * math.sqrt(x * x + y * y + z * z)
    return total / (6 * pieces)


def check_limits(geometry: LegGeometry, joints: Joints) -> str | None:
    """Return which joint is beyond its limits in words, or None."""
    for name, angle, (low, high) in zip(JOINT_NAMES, joints, geometry.limits, strict=True):
        if not low - 1e-9 <= angle <= high + 1e-9:
            return (
                f"{name} would be at {math.degrees(angle):.3f} deg, outside "
                f"{math.degrees(low):g} … {math.degrees(high):g} deg"
            )
    return None


def _runge_kutta(slope: Callable[[State], State], y: State, h: float) -> State:
    """Take one classical step of fourth order."""
    k_1 = slope(y)
    k_2 = slope(_ahead(y, 0.5 * h, k_1))
    k_3 = slope(_ahead(y, 0.5 * h, k_2))
    k_4 = slope(_ahead(y, h, k_3))
    w = h / 6.0
    return (
        y[0] + w * (k_1[0] + 2.0 * (k_2[0] + k_3[0]) + k_4[0]),
        y[1] + w * (k_1[1] + 2.0 * (k_2[1] + k_3[1]) + k_4[1]),
        y[2] + w * (k_1[2] + 2.0 * (k_2[2] + k_3[2]) + k_4[2]),
        y[3] + w * (k_1[3] + 2.0 * (k_2[3] + k_3[3]) + k_4[3]),
        y[4] + w * (k_1[4] + 2.0 * (k_2[4] + k_3[4]) + k_4[4]),
        y[5] + w * (k_1[5] + 2.0 * (k_2[5] + k_3[5]) + k_4[5]),
        y[6] + w * (k_1[6] + 2.0 * (k_2[6] + k_3[6]) + k_4[6]),
    )


def _ahead(y: State, h: float, k: State) -> State:
    return (
        y[0] + h * k[0],
        y[1] + h * k[1],
        y[2] + h * k[2],
        y[3] + h * k[3],
        y[4] + h * k[4],
        y[5] + h * k[5],
        y[6] + h * k[6],
    )
