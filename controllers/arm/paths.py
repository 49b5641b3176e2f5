"""Paths of the arm's hand, as an experiment names them.

Directions are in the base's axes and need no unit length. `controllers.arm.trajectories` turns
these settings into poses.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Unit

from controllers.arm.geometry import Angle, SixAngles

Direction = tuple[float, float, float]
Length = Annotated[float, Unit("m"), Gt(0)]
Speed = Annotated[float, Unit("m/s"), Gt(0)]

_FIG4_START = tuple(math.radians(angle) for angle in (0.0, 30.0, 115.0, 30.0, -50.0, 0.0))
_FIG6_START = tuple(math.radians(angle) for angle in (10.0, 40.0, 90.0, -70.0, 20.0, 0.0))


@dataclass(frozen=True, slots=True)
class TurnBack:
    """A line to the boundary of the workspace and back, through the elbow's singularity.

    The defaults are Fig. 4 with a tenth of its speeds: with the printed 0.7 m/s and 1 rad/s
    eq. (13) gives ``sin q_s = 5.3``, and no arm of these lengths could do it.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    touch : tuple of float, optional
        Instead of `start`: joints at the boundary, rad, of which q3 is left out. The line then
        starts `distance` before it.
    distance : float
        m; only with `touch`.
    direction : tuple of float
        Which way the hand goes out, in the base's axes.
    speed : float
        How fast the hand goes, m/s.
    axis : tuple of float
        About which the tool turns, out and back in the same sense.
    turn_rate : float
        rad/s, as in the paper; with 0 the tool keeps its direction.
    travel : float
        How far the line may go to meet the boundary, m.

    References
    ----------
    Miyata et al., section 3 and Fig. 4.
    """

    start: SixAngles = _FIG4_START  # type: ignore[assignment]
    touch: SixAngles | None = None
    distance: Length = 0.2
    direction: Direction = (1.0, 0.0, 0.0)
    speed: Speed = 0.07
    axis: Direction = (1.0, 0.0, 0.0)
    turn_rate: Annotated[float, Unit("rad/s")] = 0.07
    travel: Length = 2.0


@dataclass(frozen=True, slots=True)
class DwellLine:
    """A line to the boundary and back that stays near the boundary for a given time.

    The defaults are Fig. 6 with a tenth of its speed.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    direction : tuple of float
        Out. The tool does not turn.
    speed : float
        Outside the region, m/s.
    depth : float
        d_s, of the region inside the boundary, m.
    dwell : float
        t_s, time in the region, s.
    travel : float
        How far the line may go to meet the boundary, m.

    References
    ----------
    Miyata et al., section 4 and Fig. 6.
    """

    start: SixAngles = _FIG6_START  # type: ignore[assignment]
    direction: Direction = (1.0, 0.0, 0.0)
    speed: Speed = 0.06
    depth: Length = 0.03
    dwell: Annotated[float, Unit("s"), Gt(0)] = 4.0
    travel: Length = 2.0


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle of the hand through the elbow's or the shoulder's singularity.

    Parameters
    ----------
    through : str
        ``elbow``: touches the boundary from inside, in a plane through the shoulder.
        ``shoulder``: horizontal, through the axis of q1.
    touch : tuple of float
        Joints at the singularity, rad; q3 (elbow) or q2 (shoulder) follows and is left out. The
        shoulder's circle starts out along q1.
    radius : float
        Radius of the circle, r2, m.
    plane : float
        Elbow: from the arm's plane to the circle's, about the stretched arm, rad.
    side : int
        Elbow: sign of S3 after the touch.
    rate : float
        How fast the circle is gone round, gamma', rad/s.
    begin, end : float
        gamma, 0 at the singularity, rad.

    References
    ----------
    Miyata et al., section 2.2.3 and Fig. 3.
    """

    through: Literal["elbow", "shoulder"] = "elbow"
    touch: SixAngles = (0.0, 1.0, 0.0, 0.5, -0.8, 0.0)
    radius: Length = 0.24
    plane: Angle = 0.0
    side: Literal[1, -1] = 1
    rate: Annotated[float, Unit("rad/s"), Gt(0)] = 0.4
    begin: Angle = -0.5 * math.pi
    end: Angle = 0.5 * math.pi

    def __post_init__(self) -> None:
        if not self.begin < self.end:
            raise ValueError(f"begin ({self.begin:g} rad) must be below end ({self.end:g} rad).")


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the hand past or through a singularity inside the workspace.

    Parameters
    ----------
    middle : tuple of float
        Joints at the point that the line is about, rad.
    shoulder_distance : float, optional
        c at that point, m: q2 follows and is left out.
    direction : tuple of float
        Of the hand.
    before, after : float
        From the start to that point, and on to the end, m.
    speed : float
        At most, m/s.
    axis : tuple of float
        About which the tool turns.
    turn_rate : float
        At full speed, rad/s.
    """

    middle: SixAngles
    shoulder_distance: Annotated[float, Unit("m"), Ge(0)] | None = None
    direction: Direction = (1.0, 0.0, 0.0)
    before: Length = 0.15
    after: Length = 0.15
    speed: Speed = 0.1
    axis: Direction = (0.0, 0.0, 1.0)
    turn_rate: Annotated[float, Unit("rad/s")] = 0.0
