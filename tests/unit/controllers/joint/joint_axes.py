"""Ring axes to test with, and how fast a ring turns as its axis moves."""

import math

import numpy as np
from hypothesis import strategies as st

from controllers.spherical_joint.poses import axis_from_tilt


def axes(most=60.0, least=0.0):
    """Return a Hypothesis strategy of ring axes between two tilts (degrees)."""
    return st.builds(
        axis_from_tilt,
        st.floats(math.radians(least), math.radians(most)),
        st.floats(-math.pi, math.pi),
    )


def axis_from_paper_angles(theta, phi):
    """Return the ring's axis for the paper's angles (rad): Kobayashi and Saito, eq. (4)."""
    across = math.cos(phi)
    return (math.sin(theta) * across, -math.sin(phi), math.cos(theta) * across)


def spin_rate(convention, axis, velocity):
    """Return how fast a convention of the pose spins the ring about its moving axis, rad/s."""
    x, y, z = axis
    if convention == "natural":
        return (y * velocity[0] - x * velocity[1]) / (1.0 + z)
    return y * (z * velocity[0] - x * velocity[2]) / (x * x + z * z)


def angular_velocity(convention, axis, velocity):
    """Return ``u x u' + s u`` (rad/s): what moves the axis, and the convention's spin about it."""
    return np.cross(axis, velocity) + spin_rate(convention, axis, velocity) * np.array(axis)


def around(tilt, step=5):
    """Return the axes of a circle: tilt and step of the azimuth in degrees."""
    return [axis_from_tilt(math.radians(tilt), math.radians(k)) for k in range(0, 360, step)]


def twisted(rotation, twist):
    """Return a rotation spun by `twist` (rad) about its own axis."""
    cos, sin = math.cos(twist), math.sin(twist)
    return tuple(
        (row[0] * cos + row[1] * sin, row[1] * cos - row[0] * sin, row[2]) for row in rotation
    )
