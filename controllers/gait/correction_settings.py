"""What a profile says of the corrections of a planned posture."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Unit


@dataclass(frozen=True, slots=True)
class SagSettings:
    """The compensation of the servos' sag.

    Parameters
    ----------
    stiffness : float
        Of a joint's position loop, N m/rad: what it is thought to be.
    fade : float
        Over which it is brought in when the motion begins, s.
    """

    stiffness: Annotated[float, Unit("N m/rad"), Gt(0)] = 150.0
    fade: Annotated[float, Unit("s"), Ge(0)] = 0.5


@dataclass(frozen=True, slots=True)
class StabiliserSettings:
    """The gains by which what the legs feel moves the waist over the feet.

    On a slope, on a floor that is lower than planned, or with masses that are not those of the
    drawing, the feet are pressed elsewhere than the plan has it. The waist is moved until they
    are not.

    Parameters
    ----------
    recovery : float
        Share of the pressure's error that is taken out in a second, 1/s.
    greatest_error : float
        A larger error counts as so much, m.
    response : float
        Over which the pressure is averaged, s.
    still : float
        While the waist turns faster, nothing is learnt: a push or a landing is no slope, rad/s.
    shift : float
        How far the waist may be moved along each axis, m; never farther than the plan's static
        margin leaves.
    shift_rate : float
        How fast, m/s.
    fade : float
        In which corrections begin, and in which they end if the sensors are not believed, s.

    Notes
    -----
    Nothing acts against pushes as such. On servos as stiff as these the robot bears nine tenths
    of what its capture point permits without any control. Turning the ankles against the waist's
    rate, 20 ms late as it is on the buses, made it fall at smaller pushes, and at 0.05 s without
    any; moving the waist by what its lean carries aside made it fall on a floor 5 mm lower.
    """

    recovery: Annotated[float, Unit("1/s"), Interval(ge=0.0, le=5.0)] = 0.5
    greatest_error: Annotated[float, Unit("m"), Gt(0)] = 0.015
    response: Annotated[float, Unit("s"), Interval(ge=0.0, le=1.0)] = 0.05
    still: Annotated[float, Unit("rad/s"), Gt(0)] = 0.3
    shift: Annotated[float, Unit("m"), Interval(ge=0.0, le=0.05)] = 0.020
    shift_rate: Annotated[float, Unit("m/s"), Interval(gt=0.0, le=0.5)] = 0.1
    fade: Annotated[float, Unit("s"), Interval(gt=0.0, le=10.0)] = 0.5
