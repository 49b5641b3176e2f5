"""How far readings of rods and chambers may be off, and for how long, before a rig is stopped."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Unit


@dataclass(frozen=True, slots=True)
class PressureAlarm:
    """A chamber is not where its regulator should have it by now.

    The monitor is compared with the setpoints as they pass through `regulator_response`. What is
    not given follows from the profile, with w its bandwidth, z its damping, D its dead time, e its
    spread, and R the full scale of the regulators; `rig check` shows the numbers.

    Parameters
    ----------
    deviation : float, optional
        Permitted distance, Pa. None: what a healthy regulator may be off at rest, and what the
        slowest healthy one, w (1 - e) and D late, is off after a step from the base pressure to
        the furthest that a chamber is given. For z = 1 that is about (0.54 e + 0.37 w D) of the
        step. A limit on the pressure's rate that is worth having makes it no smaller.
    time : float, optional
        For how long it may be exceeded, s. None: 2 / w, after which a regulator has made up for
        most of what a piston or a lost frame has done. A tenth of it where the setpoint has not
        moved.
    offset : float, optional
        Permitted distance of the mean over four time constants from what is usual, Pa, at rest;
        while the pressure moves, `slow` of what a regulator of half the bandwidth is off comes to
        it. None: 2.2 % of R, linearity, hysteresis, repeatability and sensitivity by catalogue.
        The noise of a monitor, 0.05 % of R, is nothing beside it.
    slow : float, optional
        Permitted share of the deviation that a regulator of half the bandwidth would have. That
        one takes 2 z / w longer. None: e / (1 - e) + D w / (2 z), what the slowest healthy one
        takes longer in that measure. Beside it 0.5 % of R, the hysteresis, is permitted: the more
        a motion asks of the regulators, the less of a slow one is hidden by it. It must be slow
        for 4 / w.
    """

    deviation: Annotated[float, Unit("Pa"), Gt(0)] | None = None
    time: Annotated[float, Unit("s"), Gt(0), Le(60)] | None = None
    offset: Annotated[float, Unit("Pa"), Gt(0)] | None = None
    slow: Annotated[float, Unit("1"), Gt(0), Le(100)] | None = None


@dataclass(frozen=True, slots=True)
class FrozenAlarm:
    """An encoder says the same count again and again while the other wires move.

    Parameters
    ----------
    distance : float
        How far the others may move meanwhile, m: more than wires stretch while a rod sticks,
        which is twice the breakaway force over the wire's stiffness.
    time : float
        How long a count must stay the same, s.
    """

    distance: Annotated[float, Unit("m"), Gt(0)] = 0.4e-3
    time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=10.0)] = 0.05


@dataclass(frozen=True, slots=True)
class SwappedAlarm:
    """Two opposite encoders stand for each other: the rods move against their own pull.

    Wires cannot show it, since the mirrored pose is as possible as the true one. The work can:
    what a pair's pressures do is lost in friction, so it is positive whichever way it moves.

    Parameters
    ----------
    distance : float
        The way over which the work is added up, m; a pair that passed is not looked at again.
    share : float
        Of the work of Coulomb friction over that way: more than this against the pull is a
        fault, more than this with it is a pass.
    """

    distance: Annotated[float, Unit("m"), Gt(0)] = 1e-3
    share: Annotated[float, Gt(0), Le(1)] = 0.25


@dataclass(frozen=True, slots=True)
class OscillationAlarm:
    """A rod swings about its reference, or has lost it: the loop is not stable on this rig.

    Parameters
    ----------
    amplitude : float
        Swings of the error from one extreme to the next that count, m, peak to peak. In the shipped
        experiments none is of 1.5 mm; sines of 1 Hz, which friction hardly damps, swing by 2 mm.
    sticking : float
        What sticks and slips may swing by so many times that: a rod that stands for most of the
        time does not run away, however badly it follows. The run counts as one that missed a bound.
    swings : int
        So many in a row that do not die away are an oscillation. They are counted anew where the
        reference turns round, as friction makes a rod swing there.
    slowest : float
        The longest time from one extreme to the next, s; what takes longer is a drift.
    lost : float
        How long a rod may be beyond ``limits.following``, s: a step takes some time to be followed.
    """

    amplitude: Annotated[float, Unit("m"), Gt(0)] = 3e-3
    sticking: Annotated[float, Interval(ge=1.0, le=100.0)] = 2.0
    swings: Annotated[int, Ge(3), Le(100)] = 6
    slowest: Annotated[float, Unit("s"), Interval(ge=0.01, le=60.0)] = 1.0
    lost: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 0.3
