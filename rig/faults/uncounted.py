"""Which hazards of a campaign were not counted: those that nothing could have kept off."""

from collections.abc import Iterable
from typing import Final

from rig.faults import excuses
from rig.faults.excuses import ON_A_WIRE
from rig.faults.kind import FaultKind, no_excuse
from rig.faults.verdict import Verdict

_PUSHES: Final = (excuses.topples, excuses.overpowers, excuses.overpowers_wires)
_LETS_GO: Final = (excuses.pulls_alone, excuses.empties_at_once, excuses.fills_alone)
_STOP: Final = (
    "Where a wire, a tube or a regulator lets go the mechanical stop has to bear it: "
    "`rig check RIG` says how much"
)
_PUSH: Final = "A push that is stronger than the rig can hold moves it"
_FALL: Final = (
    "A joint that has lost its torque, encoder, brake or right setpoint falls where nothing else "
    "holds it"
)


def say_uncounted(verdicts: Iterable[Verdict]) -> str:
    """Return after which faults hazards were not counted, and why; empty: after none.

    Parameters
    ----------
    verdicts : iterable of Verdict
        On all cases.
    """
    found = [verdict.case for verdict in verdicts if verdict.ending.excused]
    rows = {item.kind: item.row for case in found for item in case.breaks}
    left = {name: row for name, row in rows.items() if is_excused(row)}
    if not left:
        return ""
    reasons = dict.fromkeys(map(reason_of, left.values()))
    names = ", ".join(sorted(left))
    return f"not counted: what nothing could keep off after {names}. {'. '.join(reasons)}"


def is_excused(row: FaultKind) -> bool:
    """Return whether a hazard after a fault of a kind may not be counted."""
    return bool(row.forgives) or row.excuses is not no_excuse


def reason_of(row: FaultKind) -> str:
    """Return why a hazard after a fault of a kind may not be counted, a sentence."""
    if row.excuses in _PUSHES:
        return _PUSH
    return _STOP if row.forgives >= ON_A_WIRE or row.excuses in _LETS_GO else _FALL
