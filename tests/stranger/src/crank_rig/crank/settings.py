"""What a profile says of a crank rig."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Unit

from rig.mechanisms.servo.settings import ServoSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class CrankSettings(ServoSettings):
    """Two cranks, ``left`` and ``right``, that a rod couples.

    Parameters
    ----------
    reach : float
        How far each crank may turn to either side, rad.
    max_speed : float
        Of each crank, rad/s.
    max_twist : float
        How far the cranks may be out of step, rad: beyond it the rod would be overstrained.
    rod_zero : float
        The right crank's lead at which the rod is unstrained, rad; found by calibration.
    """

    reach: Annotated[float, Unit("rad"), Gt(0)] = 13.0
    max_speed: Annotated[float, Unit("rad/s"), Gt(0)] = 6.0
    max_twist: Annotated[float, Unit("rad"), Gt(0)] = 0.1
    rod_zero: Annotated[float, Unit("rad")] = 0.0
