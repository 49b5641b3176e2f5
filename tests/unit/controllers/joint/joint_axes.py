"""Ring axes to test with."""

import math

from hypothesis import strategies as st

from controllers.spherical_joint.poses import axis_from_tilt


def axes(most=60.0, least=0.0):
    """Return a Hypothesis strategy of ring axes between two tilts (degrees)."""
    return st.builds(
        axis_from_tilt,
        st.floats(math.radians(least), math.radians(most)),
        st.floats(-math.pi, math.pi),
    )


def around(tilt, step=5):
    """Return the axes of a circle: tilt and step of the azimuth in degrees."""
    return [axis_from_tilt(math.radians(tilt), math.radians(k)) for k in range(0, 360, step)]
