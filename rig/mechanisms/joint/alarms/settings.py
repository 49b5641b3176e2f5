"""How far readings may be off, and for how long, before a joint is stopped."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from rig.mechanisms.pneumatic.alarms.settings import (
    FrozenAlarm,
    OscillationAlarm,
    PressureAlarm,
    SwappedAlarm,
)


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
    time: Annotated[float, Unit("s"), Ge(0), Le(10)] = 0.1


@dataclass(frozen=True, slots=True)
class JointAlarmSettings:
    """Alarms of the joint beside its limits.

    Wires that do not agree on a pose are judged by ``limits.residual`` and ``limits.grace``, a
    rod that runs away by ``limits.speed``, camera against encoders by ``limits.disagreement``
    and ``limits.grace``.

    Parameters
    ----------
    pressure : PressureAlarm
        A regulator stuck or slow, its tube or its monitor off, the supply lost.
    frozen : FrozenAlarm
        An encoder frozen, a rod jammed.
    swapped : SwappedAlarm
        Opposite encoders swapped.
    twist : TwistAlarm
        The ring turned about its axis.
    oscillation : OscillationAlarm
        A loop that is not stable on this rig.
    """

    pressure: PressureAlarm = field(default_factory=PressureAlarm)
    frozen: FrozenAlarm = field(default_factory=FrozenAlarm)
    swapped: SwappedAlarm = field(default_factory=SwappedAlarm)
    twist: TwistAlarm = field(default_factory=TwistAlarm)
    oscillation: OscillationAlarm = field(default_factory=OscillationAlarm)
