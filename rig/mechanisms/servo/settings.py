"""What a profile says of joints on servo drives, whatever they move."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Interval, MinLen, Unit


@dataclass(frozen=True, slots=True)
class ServoLimits:
    """Limits that the loop enforces, beside the joint limits of the geometry.

    Parameters
    ----------
    following : float
        How far a joint may be from where it was sent, rad; further is a fault.
    reading_age : float
        Oldest reading that control may use, s; older is a fault.
    acceleration : float
        With which a joint is slowed down when the rig stops in mid-motion, rad/s². On their way to
        a motion legs stop in `Timings.brake` instead.
    stuck : float
        How far a joint may be sent without going along, rad, beside what it is late by; further
        is a fault. The sag of a servo as its load changes has to be less.
    """

    following: Annotated[float, Unit("rad"), Interval(ge=1e-4, le=4.0 * math.pi)] = 0.15
    reading_age: Annotated[float, Unit("s"), Interval(ge=1e-4, le=1.0)] = 0.03
    acceleration: Annotated[float, Unit("rad/s^2"), Gt(0)] = 10.0
    stuck: Annotated[float, Unit("rad"), Interval(ge=1e-4, le=4.0 * math.pi)] = 0.05


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """The devices that drive the joints.

    Parameters
    ----------
    servos : tuple of str
        Devices; together they have every joint of the mechanism once, in any order.
    limits : ServoLimits
        What the loop never permits.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    """

    servos: Annotated[tuple[str, ...], MinLen(1)]
    limits: ServoLimits
    emergency_stop: str | None = None
