"""What a footprint is, and how a robot steps from one to the next."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, Le, Unit

from controllers.gait.motions import NEARLY_STRAIGHT, Duration, GaitRequest, Knee

Foot = Literal["right", "left"]
Place = Annotated[float, Unit("m"), Interval(ge=-100.0, le=100.0)]
Height = Annotated[float, Unit("m"), Interval(ge=-10.0, le=10.0)]
Heading = Annotated[float, Unit("rad"), Interval(ge=-100.0, le=100.0)]
Tilt = Annotated[float, Unit("rad"), Interval(ge=-0.5, le=0.5)]
Lift = Annotated[float, Unit("m"), Interval(gt=0.0, le=0.3)]
Time = Annotated[float, Unit("s"), Interval(gt=0.0, le=600.0)]

MOST_STEPS = 200


@dataclass(frozen=True, slots=True)
class Footstep:
    """One footprint: which foot comes down, where, and how long it takes.

    Parameters
    ----------
    foot : str
        Which one comes down: ``left`` or ``right``.
    x, y : float
        Where the point under its ankle comes down, m: ahead and to the left of the middle
        between these points of both feet at the start.
    heading : float
        Where the toes point, rad; positive to the left.
    height : float
        Of that point over that middle, m.
    pitch, roll : float
        How the ground slopes there, rad: positive with the toes down, and with the left edge up.
    lift : float, optional
        How far the foot is lifted off the straight way there, m. None: as all others.
    shift, swing : float, optional
        Of the waist's way over the other foot beforehand and of the swing, s at speed 1. None: as
        all others.
    """

    foot: Foot
    x: Place
    y: Place
    heading: Heading = 0.0
    height: Height = 0.0
    pitch: Tilt = 0.0
    roll: Tilt = 0.0
    lift: Lift | None = None
    shift: Time | None = None
    swing: Time | None = None


@dataclass(frozen=True, slots=True)
class StepNumbers:
    """Footprints that go on alike: a place midway between the feet moves on, and they follow it.

    Parameters
    ----------
    count : int
        How often a foot comes down, without the last that closes the feet.
    first : str
        The foot that swings first.
    length, aside : float
        How far that place moves on ahead and to the left with each, m.
    turn : float
        How far it turns with each, rad; positive to the left.
    rise : float
        How much higher it is each time, m; on a slope, beyond what that goes up.
    width : float, optional
        Between the ankles across the heading, m. None: as the hips are apart.
    together : bool
        Whether the second foot comes down beside the first one each time, as on stairs whose
        treads have room for one pair of feet; `count` then counts these places.
    close : bool
        Whether the feet end beside each other.
    """

    count: Annotated[int, Interval(ge=1, le=MOST_STEPS // 2 - 1)] = 4
    first: Foot = "right"
    length: Annotated[float, Unit("m"), Ge(-1.0), Le(1.0)] = 0.030
    aside: Annotated[float, Unit("m"), Ge(-1.0), Le(1.0)] = 0.0
    turn: Annotated[float, Unit("rad"), Ge(-1.0), Le(1.0)] = 0.0
    rise: Annotated[float, Unit("m"), Ge(-0.5), Le(0.5)] = 0.0
    width: Annotated[float, Unit("m"), Gt(0), Le(1.0)] | None = None
    together: bool = False
    close: bool = True


@dataclass(frozen=True, slots=True)
class SteppingSettings(GaitRequest):
    """Manner of stepping, whatever the footprints.

    Parameters
    ----------
    lift : float
        How far a foot is lifted off its straight way, m.
    sway : float
        How far aside the waist goes, as a share of the way from midway between the hips to over
        the ankle.
    ahead : float
        How far the waist is ahead of the ankle that it is over, m.
    follow : float
        How far the waist may leave that place to meet the foot that swings midway on its way, m:
        it takes as much from the reach that a long step needs.
    knee_min : float
        Angle of the straightest knee, rad. With `hip` not given it sets the hips' height, at the
        step that needs the lowest hips.
    hip : float, optional
        The hips' height above the ankle that the waist is over, m.
    start_pitch, start_roll : float
        How the ground slopes on which both feet begin, rad: positive with the toes down, and with
        the left side up. The waist stands upright on it; `numbers` go on over the same slope.
    first_shift_time, shift_time, swing_time, last_shift_time : float
        s at speed 1.
    speed : float
        By what all times, a law's ramps included, are shortened.
    fastest : bool
        Whether to go on from that speed to the highest that balance and joint rates permit.
    """

    lift: Lift = 0.020
    sway: Annotated[float, Interval(ge=0.0, le=2.0)] = 1.0
    ahead: Annotated[float, Unit("m"), Ge(-0.2), Le(0.2)] = 0.0
    follow: Annotated[float, Unit("m"), Ge(0), Le(0.2)] = 0.0
    knee_min: Knee = NEARLY_STRAIGHT
    hip: Annotated[float, Unit("m"), Gt(0)] | None = None
    start_pitch: Tilt = 0.0
    start_roll: Tilt = 0.0
    first_shift_time: Duration = 3.0
    shift_time: Duration = 3.0
    swing_time: Duration = 4.0
    last_shift_time: Duration = 3.0
    speed: Annotated[float, Gt(0), Le(100)] = 1.0
    fastest: bool = False
