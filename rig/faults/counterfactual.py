"""What would have come of a case if somebody had pressed the emergency stop at once.

What a tube that comes off does before a rod has moved, nobody can keep off. Whether anything could
have been depends on pressures, on the hole, and on how near its end the pair was; so the same run
is broken again, and stopped by hand as soon as the best of alarms could have seen it.
"""

from dataclasses import replace
from math import inf
from typing import Final

from rig.faults.case import Break, Case
from rig.faults.catalogue import kind_named
from rig.faults.excuses import ON_A_WIRE
from rig.faults.subject import Subject
from rig.faults.verdict import Verdict

_STOP: Final = "emergency_stop"
_SEEN_AFTER: Final = 8e-3
"""s: a chamber that empties has moved its rod by half a millimetre by then, which anybody sees."""


def stopped_at_once(case: Case, subject: Subject) -> Case | None:
    """Return a case with the emergency stop pressed; None: it has no stop, or would tell nothing.

    Parameters
    ----------
    case : Case
        In which a hazard became true.
    subject : Subject
        The rig.
    """
    stops = kind_named(_STOP).places(subject)
    if not case.first.row.is_sudden or case.then is not None or not stops:
        return None
    pressed = Break(_STOP, stops[0].where, None, inf)
    return replace(case, then=pressed, then_after=_SEEN_AFTER)


def borne_out(verdict: Verdict, stopped: Verdict) -> Verdict:
    """Return a verdict without the hazards that the emergency stop would not have kept off.

    Only those that a mechanical stop bears. Air that is left was never vented.

    Parameters
    ----------
    verdict : Verdict
        Of the case.
    stopped : Verdict
        Of the case that `stopped_at_once` made of it.
    """
    ending = stopped.ending
    inevitable = {one.hazard for one in (*ending.violations, *ending.excused)} & ON_A_WIRE
    found, excused = verdict.ending.violations, verdict.ending.excused
    left = tuple(one for one in found if one.hazard not in inevitable)
    borne = tuple(one for one in found if one.hazard in inevitable)
    ended = replace(verdict.ending, violations=left, excused=(*excused, *borne))
    return replace(verdict, ending=ended, hazard=bool(left))
