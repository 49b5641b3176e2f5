"""How well a spherical joint is made: what a calibration knows of it before it has moved."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Le, Unit


@dataclass(frozen=True, slots=True)
class JointTolerances:
    """Bounds of what may be off the drawing; E: a joint from a printer, put together by hand.

    Parameters
    ----------
    length : float
        Of every dimension, as a share of it.
    angle : float
        Of each anchor angle, rad.
    part : float
        Of each coordinate of an anchor, an adjust point and the marker, beyond those, m.
    zero : float
        Of each rod's zero after encoders and wires have been calibrated; standard deviation, m.
    stiffness : float
        Of the wires, as a share of it; standard deviation.
    friction : float
        Of the seals' viscous friction, of what breakaway exceeds Coulomb friction by, and of the
        ring's part in the friction on the ball, as a share of each.
    """

    length: Annotated[float, Unit("1"), Gt(0), Le(0.2)] = 0.02
    angle: Annotated[float, Unit("rad"), Gt(0), Le(0.2)] = math.radians(2.0)
    part: Annotated[float, Unit("m"), Gt(0), Le(5e-3)] = 20e-6
    zero: Annotated[float, Unit("m"), Gt(0), Le(5e-3)] = 50e-6
    stiffness: Annotated[float, Unit("1"), Gt(0), Le(1)] = 0.1
    friction: Annotated[float, Unit("1"), Gt(0), Le(1)] = 0.3
