"""The ground as a plane through the origin, as it slopes where both feet begin."""

import math
from typing import NamedTuple

from controllers.gait.turning import rotation_of


class GroundPlane(NamedTuple):
    """The slope of the ground through the origin.

    Parameters
    ----------
    pitch, roll : float
        rad; positive with the toes down, and with the left side up.
    """

    pitch: float = 0.0
    roll: float = 0.0

    def height(self, x: float, y: float) -> float:
        """Return how high the plane is over a place, m."""
        (_, _, ahead), (_, _, left), (_, _, up) = rotation_of((self.roll, self.pitch, 0.0))
        return 0.0 - (ahead * x + left * y) / up

    def tilt(self, heading: float) -> "GroundPlane":
        """Return how the same plane slopes for a foot that points elsewhere, rad."""
        (_, _, ahead), (_, _, left), (_, _, up) = rotation_of((self.roll, self.pitch, 0.0))
        s, c = math.sin(heading), math.cos(heading)
        ahead, left = c * ahead + s * left, c * left - s * ahead
        return GroundPlane(math.atan2(ahead, up), 0.0 - math.asin(left))
