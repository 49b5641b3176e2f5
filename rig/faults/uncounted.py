"""Which hazards of a campaign were not counted: those that nothing could have kept off."""

from collections.abc import Iterable

from rig.faults.case import Case
from rig.faults.kind import no_excuse


def say_uncounted(cases: Iterable[Case]) -> str:
    """Return of which faults not every hazard was counted, in a sentence; empty: of none.

    Parameters
    ----------
    cases : iterable of Case
        That were performed.
    """
    rows = {item.kind: item.row for case in cases for item in case.breaks}
    names = [name for name, row in rows.items() if row.forgives or row.excuses is not no_excuse]
    if not names:
        return ""
    return (
        f"not counted: what nothing could keep off after {', '.join(sorted(names))}. Where a wire "
        "or tube lets go the mechanical stop has to bear it: `rig check EXPERIMENT` says how much"
    )
