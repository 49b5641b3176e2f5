"""How far readings may be off, and for how long, before a joint is stopped."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit


@dataclass(frozen=True, slots=True)
class PressureAlarm:
    """A chamber is not where its regulator should have it by now.

    The monitor is compared with the setpoints as they pass through `regulator_response`.

    Parameters
    ----------
    deviation : float
        Permitted distance, Pa. On the simulated joint a healthy one stays below 20 kPa.
    time : float
        For how long it may be exceeded, s.
    """

    deviation: Annotated[float, Unit("Pa"), Gt(0)] = 40e3
    time: Annotated[float, Unit("s"), Gt(0)] = 0.05


@dataclass(frozen=True, slots=True)
class FrozenAlarm:
    """An encoder says the same count again and again while the other wires move.

    Parameters
    ----------
    distance : float
        How far the others may move meanwhile, m: more than wires stretch while a rod sticks.
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
class TwistAlarm:
    """The ring is turned about its own axis, as a camera that sees it says.

    Parameters
    ----------
    limit : float
        Permitted twist either way, rad.
    time : float
        For how long it may be exceeded, s.
    """

    limit: Annotated[float, Unit("rad"), Gt(0), Le(math.pi)] = math.radians(10.0)
    time: Annotated[float, Unit("s"), Ge(0)] = 0.1


@dataclass(frozen=True, slots=True)
class JointAlarmSettings:
    """Alarms of the joint beside its limits.

    Wires that do not agree on a pose are judged by ``limits.residual`` and ``limits.grace``, a
    rod that runs away by ``limits.speed``, camera against encoders by ``limits.disagreement``
    and ``limits.grace``.

    Parameters
    ----------
    pressure : PressureAlarm
        A regulator stuck, its tube off, the supply lost.
    frozen : FrozenAlarm
        An encoder frozen, a rod jammed.
    swapped : SwappedAlarm
        Opposite encoders swapped.
    twist : TwistAlarm
        The ring turned about its axis.
    """

    pressure: PressureAlarm = field(default_factory=PressureAlarm)
    frozen: FrozenAlarm = field(default_factory=FrozenAlarm)
    swapped: SwappedAlarm = field(default_factory=SwappedAlarm)
    twist: TwistAlarm = field(default_factory=TwistAlarm)
