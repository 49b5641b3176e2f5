"""How far readings of rods and chambers may be off, and for how long, before a rig is stopped."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit


@dataclass(frozen=True, slots=True)
class PressureAlarm:
    """A chamber is not where its regulator should have it by now.

    The monitor is compared with the setpoints as they pass through `regulator_response`.

    Parameters
    ----------
    deviation : float
        Permitted distance, Pa. In the shipped experiments a healthy regulator stays below 20 kPa,
        with 30 % more friction and before its calibration, too: this is twice as much.
    time : float
        For how long it may be exceeded, s: two time constants of a regulator of 40 rad/s.
    offset : float
        Permitted distance of the mean over four time constants from what is usual, Pa. A healthy
        mean wanders by 8 kPa (hysteresis, bow, valve overlap, piston); this is half as much again.
    slow : float
        Permitted share of the deviation that a regulator of half the bandwidth would have. In the
        experiments a healthy one has up to 0.54, one that takes twice as long at least 1.17.
    """

    deviation: Annotated[float, Unit("Pa"), Gt(0)] = 40e3
    time: Annotated[float, Unit("s"), Gt(0)] = 0.05
    offset: Annotated[float, Unit("Pa"), Gt(0)] = 12e3
    slow: Annotated[float, Unit("1"), Gt(0)] = 0.75


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
    time: Annotated[float, Unit("s"), Gt(0)] = 0.05


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
        experiments four in a row of 1 mm are the most, and none is of 1.5 mm.
    swings : int
        So many in a row that do not die away are an oscillation. They are counted anew where the
        reference turns round, as friction makes a rod swing there.
    slowest : float
        The longest time from one extreme to the next, s; what takes longer is a drift.
    lost : float
        How long a rod may be beyond ``limits.following``, s: a step takes some time to be followed.
    """

    amplitude: Annotated[float, Unit("m"), Gt(0)] = 1.5e-3
    swings: Annotated[int, Ge(3), Le(100)] = 6
    slowest: Annotated[float, Unit("s"), Gt(0)] = 1.0
    lost: Annotated[float, Unit("s"), Gt(0)] = 0.3
