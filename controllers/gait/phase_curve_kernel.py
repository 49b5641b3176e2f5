"""The ray of both legs and a step along it, written for numba.

In Python a step takes 15 µs, compiled one; `PhaseCurve` compiles what it calls.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from controllers.compiled import PlainNumbers, inlined
from controllers.gait.phases import LegPath
from controllers.gait.turning import hip_angles, hip_in_foot, hip_rates, hip_velocity
from controllers.gait.types import Joints
from controllers.singularity.one_path import one_rate, two_starts
from controllers.singularity.two_link import two_link_frame, two_link_parts

Angles = tuple[float, float, float, float, float, float, float]
"""Knee, ankle pitch and ankle roll of the right and of the left leg, rad; path parameter."""

DONE, NOTHING_MOVES, TANGENTIAL = 0, 1, 2
"""Outcomes of a step."""

_STRAIGHT = 1e-9
"""sin(knee) below which both legs count as straight together: rounding of the last step."""
_LONGEST_PIECE, _MOST_PIECES = 2e-3, 100
"""rad of the joints' curve. The rule's error goes with the fourth power: at 14 mrad, a fast walk at
200 Hz, the legs come to disagree by 44 nm on where the waist is; at 2 mrad by 0.04 nm."""

_BEND, _FINER = 0.1, 16
"""Relative change of the rates within a piece from which on it is taken in so many finer ones.
Where a knee turns round in mid-swing the legs would come to disagree by a micrometre."""


class CurveStep(NamedTuple):
    """The end of a step along the curve.

    Parameters
    ----------
    joints, velocities : tuple of float
        Of the twelve joints, rad and rad/s.
    path : float
        Path parameter.
    outcome : int
        `DONE`, or what is wrong.
    """

    joints: Joints
    velocities: Joints
    path: float
    outcome: int


@dataclass(frozen=True)
class PhaseNumbers(PlainNumbers):
    """The numbers of a phase that a step is computed with.

    Parameters
    ----------
    thigh, shank : float
        Lengths, m.
    right, left, leading : LegPath
        Of either leg, and of the one that goes farther.
    """

    thigh: float
    shank: float
    right: LegPath
    left: LegPath
    leading: LegPath


@inlined
def upright_ray(
    thigh: float,
    shank: float,
    knee: float,
    ankle_pitch: float,
    ankle_roll: float,
    vx: float,
    vy: float,
    vz: float,
) -> tuple[float, float, float, float]:
    """Return the ray of a leg under an upright waist.

    Hip yaw stands still, hip roll undoes the ankle's roll, hip pitch the sum of knee and ankle.
    Shank and thigh are two links that stand on the ankle. ``(adj(J) u, det J)`` of all six joints
    is this times what does not vanish on an upright robot: the lengths, the hip's height over
    the ankle, and the cosine of the hip's roll.

    Parameters
    ----------
    thigh, shank : float
        Lengths, m.
    knee, ankle_pitch, ankle_roll : float
        Joint angles, rad.
    vx, vy, vz : float
        Of the waist seen from the foot, per path parameter, m.

    Returns
    -------
    knee, ankle_pitch, ankle_roll, path : float
        Rates up to one scale; the path's is not negative with the knee bent forwards.
    """
    s6, c6 = math.sin(ankle_roll), math.cos(ankle_roll)
    frame = two_link_frame(shank, thigh, ankle_pitch, knee)
    # A pitch leans the leg backwards: against the foot's x axis.
    swing, stretch, fold = two_link_parts(shank, thigh, frame, -vx, vy * s6 + vz * c6)
    path = math.sin(knee)
    height = frame.radius * frame.cosine
    return fold, path * swing + stretch, path * (vy * c6 - vz * s6) / height, path


@inlined
def _tangent(path: LegPath, xi: float) -> tuple[float, float, float]:
    # As LegPath.tangent.
    x, y, z = path.travel[0], path.travel[1], path.travel[2]
    lift, bob, share = path.lift, path.bob, path.share
    if lift != 0.0:
        z -= lift * math.pi * math.cos(math.pi * xi)
    if bob != 0.0:
        s = min(xi, 1.0 - xi) / share
        if s < 1.0:
            slope = bob * 6.0 * s * (1.0 - s) / share
            z += slope if xi < 0.5 else -slope
    if path.turning.present:
        hip = _place(path, xi)
        return hip_velocity(path.turning, xi, hip, x, y, z)
    return x, y, z


@inlined
def _place(path: LegPath, xi: float) -> tuple[float, float, float]:
    # As LegPath.at of a path that turns.
    x = path.start[0] + xi * path.travel[0]
    y = path.start[1] + xi * path.travel[1]
    z = path.start[2] + xi * path.travel[2] - path.lift * math.sin(math.pi * xi)
    if path.bob != 0.0:
        s = min(min(xi, 1.0 - xi) / path.share, 1.0)
        z += path.bob * s * s * (3.0 - 2.0 * s)
    return hip_in_foot(path.turning, xi, x, y, z)


@inlined
def _hip(
    path: LegPath, xi: float, knee: float, ankle_pitch: float, roll: float
) -> tuple[float, float, float]:
    """Return hip yaw, roll and pitch of a leg that turns, rad."""
    yaw, across, pitch = hip_angles(path.turning, xi, roll)
    return yaw, across, pitch - knee - ankle_pitch


@inlined
def _square(path: LegPath, xi: float, roll: float, a: float, b: float, c: float, p: float) -> float:
    """Return the squared norm of the rates of a leg that turns, of three of them and the path's."""
    yaw, across, pitch = hip_rates(path.turning, xi, roll, c, p)
    return a * a + b * b + c * c + yaw * yaw + across * across + (pitch - a - b) ** 2


@inlined
def _ray(
    phase: PhaseNumbers, y: Angles
) -> tuple[float, float, float, float, float, float, float, float, int]:
    """Return the rates of the six angles and of the path, the norm of all joints, the outcome."""
    thigh, shank, xi = phase.thigh, phase.shank, y[6]
    a = b = c = right = 0.0
    d = e = f = left = 0.0
    x, across, up = _tangent(phase.right, xi)
    moves_right = x != 0.0 or across != 0.0 or up != 0.0
    if moves_right:
        a, b, c, right = upright_ray(thigh, shank, y[0], y[1], y[2], x, across, up)
    x, across, up = _tangent(phase.left, xi)
    moves_left = x != 0.0 or across != 0.0 or up != 0.0
    if moves_left:
        d, e, f, left = upright_ray(thigh, shank, y[3], y[4], y[5], x, across, up)
    path, outcome = right + left, DONE
    if moves_right and moves_left:
        if max(abs(right), abs(left)) > _STRAIGHT:
            ours, theirs, path = one_rate(right, left)
            if ours < 0.0 and theirs < 0.0:
                ours, theirs, path = -ours, -theirs, -path
        elif a == 0.0 or d == 0.0:
            return a, b, c, d, e, f, 0.0, 0.0, TANGENTIAL
        else:  # a leg's determinant grows with its knee alone
            ours, theirs = two_starts(a, d)
            path = 0.0
        a, b, c = ours * a, ours * b, ours * c
        d, e, f = theirs * d, theirs * e, theirs * f
    if phase.right.turning.present:
        norm = math.sqrt(
            _square(phase.right, xi, y[2], a, b, c, path)
            + _square(phase.left, xi, y[5], d, e, f, path)
        )
    else:
        norm = math.sqrt(
            a * a + b * b + (a + b) ** 2 + d * d + e * e + (d + e) ** 2 + 2.0 * (c * c + f * f)
        )
    if norm == 0.0:
        outcome = NOTHING_MOVES
    return a, b, c, d, e, f, path, norm, outcome


@inlined
def _speed(phase: PhaseNumbers, xi: float) -> float:
    x, y, z = _tangent(phase.leading, xi)
    return math.sqrt(x * x + y * y + z * z)


@inlined
def _slope(phase: PhaseNumbers, y: Angles, by_path: bool) -> tuple[Angles, int]:
    a, b, c, d, e, f, path, norm, outcome = _ray(phase, y)
    s = 1.0 / (path * _speed(phase, y[6])) if by_path else 1.0 / norm
    return (s * a, s * b, s * c, s * d, s * e, s * f, s * path), outcome


@inlined
def _ahead(y: Angles, h: float, k: Angles) -> Angles:
    return (
        y[0] + h * k[0],
        y[1] + h * k[1],
        y[2] + h * k[2],
        y[3] + h * k[3],
        y[4] + h * k[4],
        y[5] + h * k[5],
        y[6] + h * k[6],
    )


@inlined
def rates(phase: PhaseNumbers, joints: Joints, xi: float) -> tuple[float, float]:
    """Return the norm of the twelve joint rates and the path's speed (m), up to one scale."""
    y = (joints[3], joints[4], joints[5], joints[9], joints[10], joints[11], xi)
    _, _, _, _, _, _, path, norm, _ = _ray(phase, y)
    return norm, abs(path) * _speed(phase, xi)


@inlined
def _pieces(phase: PhaseNumbers, y: Angles, length: float, by_path: bool) -> int:
    """Return in how many pieces a step keeps both legs on one path; one at usual speeds."""
    turn = abs(length)
    if by_path:
        _, _, _, _, _, _, path, norm, _ = _ray(phase, y)
        speed = abs(path) * _speed(phase, y[6])
        turn = turn * norm / speed if speed > 0.0 else 0.0
    if turn < _LONGEST_PIECE:
        return 1
    return int(min(math.ceil(turn / _LONGEST_PIECE), _MOST_PIECES))


@inlined
def _piece(phase: PhaseNumbers, y: Angles, h: float, by_path: bool) -> tuple[Angles, int, bool]:
    """Return the end of a piece, its outcome, and whether the curve bends within it."""
    k_1, first = _slope(phase, y, by_path)
    k_2, second = _slope(phase, _ahead(y, 0.5 * h, k_1), by_path)
    k_3, third = _slope(phase, _ahead(y, 0.5 * h, k_2), by_path)
    k_4, fourth = _slope(phase, _ahead(y, h, k_3), by_path)
    w = h / 6.0
    end = _ahead(_ahead(_ahead(_ahead(y, w, k_1), 2.0 * w, k_2), 2.0 * w, k_3), w, k_4)
    change = size = 0.0
    for j in range(6):
        change += abs(k_4[j] - k_1[j])
        size += abs(k_1[j])
    return end, max(first, second, third, fourth), change > _BEND * size


@inlined
def follow(
    phase: PhaseNumbers, joints: Joints, xi: float, length: float, by_path: bool, period: float
) -> CurveStep:
    """Go on along the ray by the classical Runge-Kutta rule, in pieces that are short enough.

    Parameters
    ----------
    phase : PhaseNumbers
        Where the legs go.
    joints : tuple of float
        All twelve, rad.
    xi : float
        Path parameter.
    length : float
        Of the step: along the path, m, or along the curve of all twelve joints, rad.
    by_path : bool
        Which of them.
    period : float
        For the velocities, s.
    """
    y = (joints[3], joints[4], joints[5], joints[9], joints[10], joints[11], xi)
    z, outcome = y, DONE
    pieces = _pieces(phase, y, length, by_path)
    h = length / pieces
    for _ in range(pieces):
        end, its, bent = _piece(phase, z, h, by_path)
        if bent:
            for _ in range(_FINER):
                z, its, _ = _piece(phase, z, h / _FINER, by_path)
                outcome = max(outcome, its)
        else:
            z, outcome = end, max(outcome, its)
    p = 1.0 / period
    a, b, c = p * (z[0] - y[0]), p * (z[1] - y[1]), p * (z[2] - y[2])
    d, e, f = p * (z[3] - y[3]), p * (z[4] - y[4]), p * (z[5] - y[5])
    if phase.right.turning.present:
        u, v, w = _hip(phase.right, z[6], z[0], z[1], z[2])
        k, m, n = _hip(phase.left, z[6], z[3], z[4], z[5])
        return CurveStep(
            (u, v, w, z[0], z[1], z[2], k, m, n, z[3], z[4], z[5]),
            (
                p * (u - joints[0]), p * (v - joints[1]), p * (w - joints[2]), a, b, c,
                p * (k - joints[6]), p * (m - joints[7]), p * (n - joints[8]), d, e, f,
            ),
            z[6],
            outcome,
        )  # fmt: skip
    return CurveStep(
        (0.0, -z[2], -z[0] - z[1], z[0], z[1], z[2], 0.0, -z[5], -z[3] - z[4], z[3], z[4], z[5]),
        (0.0, -c, -a - b, a, b, c, 0.0, -f, -d - e, d, e, f),
        z[6],
        outcome,
    )
