"""What is true of the joint and no device measures: a row of numbers, filled by its kernel.

It is recorded in every cycle, so it is compiled with the kernel that moves the joint.
"""

import math

from drivers.sim.plants.compiled import Record, inlined
from drivers.sim.plants.friction import stribeck_force
from drivers.sim.plants.pneumatics import ATMOSPHERE

STICKING_SPEED = 1e-4
"""A rod sticks while its seals slide more slowly than this, m/s; what they give elastically
before they slide does not count."""

CHANNELS = ("ch1", "ch2", "ch3", "ch4")

TRUTH_COLUMNS = (
    *((f"marker_{axis}", "m") for axis in "xyz"),
    *((f"axis_{axis}", "1") for axis in "xyz"),
    ("twist", "rad"),
    *((f"tension_{name}", "N") for name in CHANNELS),
    *((f"ring_tension_{name}", "N") for name in CHANNELS),
    *((f"extension_{name}", "m") for name in CHANNELS),
    *((f"speed_{name}", "m/s") for name in CHANNELS),
    *((f"pressure_{name}", "Pa") for name in CHANNELS),
    *((f"sticking_{name}", "1") for name in CHANNELS),
    ("supply", "Pa"),
)
"""Names and units of the row. A wire's tension is that on the cylinder's side of the ball."""

_TENSION, _RING_TENSION, _EXTENSION, _SPEED, _PRESSURE, _STICKING, _SUPPLY = range(7, 32, 4)


@inlined
def sticks(state: Record, p: Record) -> float:
    """Return 1 while a rod's seals hold, 0 while they slide."""
    limit = stribeck_force(state.speed, p.coulomb, p.breakaway, p.stribeck_velocity)
    limit += p.pressure_friction * max(state.pressure - ATMOSPHERE, 0.0)
    slip = abs(state.speed * state.bristle) * p.bristle_stiffness
    return 1.0 if slip < STICKING_SPEED * limit else 0.0


@inlined
def tell_truth(
    row: Record, channels: Record, parameters: Record, wires: Record, joint: Record, q: Record
) -> None:
    """Fill the row, shape (32,), as `TRUTH_COLUMNS` names it.

    Parameters
    ----------
    row : ndarray
        Changed in place.
    channels, parameters, wires : ndarray, shape (4,)
        `STATE`, `PARAMETERS` and `WIRE_STATE`.
    joint, q : record
        `JOINT_STATE` and `JOINT_PARAMETERS`.
    """
    w, x, y, z = joint.qw, joint.qx, joint.qy, joint.qz
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    row[0] = xx * q.marker_x + xy * q.marker_y + xz * q.marker_z
    row[1] = yx * q.marker_x + yy * q.marker_y + yz * q.marker_z
    row[2] = zx * q.marker_x + zy * q.marker_y + zz * q.marker_z
    row[3], row[4], row[5] = xz, yz, zz
    twist = 2.0 * math.atan2(z, w)
    row[6] = twist - math.tau * round(twist / math.tau)
    for k in range(channels.shape[0]):
        state = channels[k]
        row[_TENSION + k] = state.tension
        row[_RING_TENSION + k] = wires[k].tension
        row[_EXTENSION + k] = state.extension
        row[_SPEED + k] = state.speed
        row[_PRESSURE + k] = state.pressure - ATMOSPHERE
        row[_STICKING + k] = sticks(state, parameters[k])
    row[_SUPPLY] = joint.supply - ATMOSPHERE
