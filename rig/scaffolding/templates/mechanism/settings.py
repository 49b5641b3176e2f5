"""What a profile says of the mechanism."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Unit

from rig.mechanisms.servo.settings import ServoSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class MyRigSettings(ServoSettings):
    """An axis on a servo drive; what every rig on servos has is inherited.

    Parameters
    ----------
    reach : float
        How far the axis may turn to either side, rad.
    max_speed : float
        How fast, rad/s.
    """

    reach: Annotated[float, Unit("rad"), Gt(0)] = 3.0
    max_speed: Annotated[float, Unit("rad/s"), Gt(0)] = 4.0
