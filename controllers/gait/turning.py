"""A leg whose waist turns and whose foot turns, tilts or goes any way: its path and its hip.

The three joints below the hip's centre put that point where it belongs in the foot's frame; the
hip's own three then make up for every rotation. So a turn takes nothing from the ray of knee and
ankle: it only changes the velocity that the hip's centre has, and what the hip's joints do.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from controllers.compiled import PlainNumbers, inlined

Three = tuple[float, float, float]
Attitude = tuple[float, float, float]
"""Roll, pitch and yaw, rad: the rotation ``Rz(yaw) Ry(pitch) Rx(roll)`` from the ground."""

FLAT: Attitude = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LegTurning(PlainNumbers):
    """The part of a leg's path that an unturned, level one has not.

    Parameters
    ----------
    present : bool
        Whether there is one; else nothing else counts.
    side : float
        y of the hip in the waist's frame, m.
    ankle : float
        Height of the ankle above the sole, m.
    yaw, turn : float
        Of the waist at the start, and how far it turns, rad.
    foot : tuple of float
        The sole's `Attitude` at the start.
    foot_turn : tuple of float
        By how much each of its angles changes, rad.
    foot_travel : tuple of float
        How far the foot goes in the ground's frame, m.
    """

    present: bool = False
    side: float = 0.0
    ankle: float = 0.0
    yaw: float = 0.0
    turn: float = 0.0
    foot: Attitude = FLAT
    foot_turn: Attitude = FLAT
    foot_travel: Three = (0.0, 0.0, 0.0)


class PhaseTurning(NamedTuple):
    """The same for a whole phase.

    Parameters
    ----------
    yaw, turn : float
        Of the waist at the start, and how far it turns, rad.
    feet : tuple of tuple of float
        The `Attitude` of the right and of the left sole at the start.
    foot_turn : tuple of float
        By how much the angles of the foot that swings change, rad.
    foot_travel : tuple of float
        How far that foot goes in the ground's frame, m.
    """

    yaw: float = 0.0
    turn: float = 0.0
    feet: tuple[Attitude, Attitude] = (FLAT, FLAT)
    foot_turn: Attitude = FLAT
    foot_travel: Three = (0.0, 0.0, 0.0)


def rotation_of(attitude: Attitude) -> tuple[Three, Three, Three]:
    """Return the rows of the rotation ground from sole."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(angle), math.cos(angle)) for angle in attitude)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


@inlined
def eased(xi: float) -> float:
    """Return a share of the way that begins and ends at rest, of one that does not."""
    return xi * xi * (3.0 - 2.0 * xi)


@inlined
def attitude_at(turning: LegTurning, xi: float) -> Attitude:
    """Return the sole's attitude; it turns while the foot is in the air, not as it comes down."""
    e = eased(xi)
    foot, turn = turning.foot, turning.foot_turn
    return (foot[0] + e * turn[0], foot[1] + e * turn[1], foot[2] + e * turn[2])


@inlined
def into_foot(attitude: Attitude, x: float, y: float, z: float) -> Three:
    """Return a vector of the ground's frame in the sole's."""
    s, c = math.sin(attitude[2]), math.cos(attitude[2])
    x, y = c * x + s * y, c * y - s * x
    s, c = math.sin(attitude[1]), math.cos(attitude[1])
    x, z = c * x - s * z, c * z + s * x
    s, c = math.sin(attitude[0]), math.cos(attitude[0])
    return (x, c * y + s * z, c * z - s * y)


@inlined
def hip_in_foot(turning: LegTurning, xi: float, x: float, y: float, z: float) -> Three:
    """Return the hip's centre from the ankle in the foot's frame, m.

    Parameters
    ----------
    turning : LegTurning
        How waist and foot turn.
    xi : float
        Path parameter.
    x, y, z : float
        The waist from the sole's start in the ground's frame, lift and bob included, m.
    """
    e, travel = eased(xi), turning.foot_travel
    yaw = turning.yaw + xi * turning.turn
    x += -e * travel[0] - math.sin(yaw) * turning.side
    y += -e * travel[1] + math.cos(yaw) * turning.side
    z -= xi * travel[2]
    x, y, z = into_foot(attitude_at(turning, xi), x, y, z)
    return (x, y, z - turning.ankle)


@inlined
def hip_velocity(
    turning: LegTurning, xi: float, hip: Three, vx: float, vy: float, vz: float
) -> Three:
    """Return the derivative of `hip_in_foot` by the path parameter, m.

    Parameters
    ----------
    turning : LegTurning
        How waist and foot turn.
    xi : float
        Path parameter.
    hip : tuple of float
        What `hip_in_foot` gives, m.
    vx, vy, vz : float
        Derivative of its last three arguments, m.
    """
    rate, travel = 6.0 * xi * (1.0 - xi), turning.foot_travel
    yaw = turning.yaw + xi * turning.turn
    vx += -rate * travel[0] - turning.turn * math.cos(yaw) * turning.side
    vy += -rate * travel[1] - turning.turn * math.sin(yaw) * turning.side
    vz -= travel[2]
    attitude = attitude_at(turning, xi)
    vx, vy, vz = into_foot(attitude, vx, vy, vz)
    wx, wy, wz = _foot_spin(turning, attitude, rate)
    x, y, z = hip[0], hip[1], hip[2] + turning.ankle
    return (vx - wy * z + wz * y, vy - wz * x + wx * z, vz - wx * y + wy * x)


@inlined
def _foot_spin(turning: LegTurning, attitude: Attitude, rate: float) -> Three:
    """Return the foot's angular velocity in its own axes, per path parameter."""
    roll, pitch, yaw = turning.foot_turn
    s, c = math.sin(attitude[0]), math.cos(attitude[0])
    sp, cp = math.sin(attitude[1]), math.cos(attitude[1])
    return (
        rate * (roll - yaw * sp),
        rate * (pitch * c + yaw * cp * s),
        rate * (yaw * cp * c - pitch * s),
    )


@inlined
def hip_angles(turning: LegTurning, xi: float, ankle_roll: float) -> Three:
    """Return hip yaw, hip roll and the sum of all three pitches that keep waist and sole, rad.

    The rotation waist from the link between the ankle's joints is ``Rz Rx Ry`` of these three; it
    has to be ``Rz(yaw - waist's yaw) Ry(pitch) Rx(roll - ankle_roll)`` with the sole's attitude.
    """
    attitude = attitude_at(turning, xi)
    lean, apart = ankle_roll - attitude[0], turning.yaw + xi * turning.turn - attitude[2]
    sl, cl = math.sin(lean), math.cos(lean)
    sp, cp = math.sin(attitude[1]), math.cos(attitude[1])
    return math.atan2(sp * sl, cl) - apart, -math.asin(cp * sl), math.atan2(sp, cp * cl)


@inlined
def hip_rates(
    turning: LegTurning, xi: float, ankle_roll: float, roll_rate: float, path: float
) -> Three:
    """Return the rates of `hip_angles` for rates of the ankle's roll and of the path."""
    attitude, turn = attitude_at(turning, xi), turning.foot_turn
    rate = 6.0 * xi * (1.0 - xi) * path
    lean = ankle_roll - attitude[0]
    sl, cl = math.sin(lean), math.cos(lean)
    sp, cp = math.sin(attitude[1]), math.cos(attitude[1])
    leans, pitches = roll_rate - rate * turn[0], rate * turn[1]
    square = 1.0 - (cp * sl) ** 2  # of the hip roll's cosine
    yaw = (cl * (cp * pitches * sl + sp * cl * leans) + sp * sl * sl * leans) / square
    roll = (sp * pitches * sl - cp * cl * leans) / math.sqrt(square)
    pitch = (cl * pitches + sp * cp * sl * leans) / square
    return yaw - path * turning.turn + rate * turn[2], roll, pitch
