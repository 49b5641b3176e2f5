"""From which of two faults a reaction is counted."""

from dataclasses import replace
from math import inf

import pytest
from broken_cylinder import SUBJECT

from rig.faults.case import Break, Case, Moment
from rig.faults.table import case_cells, make_row
from rig.faults.verdict import CaseEnding, give_verdict

CUT = Break("wire_cut", "plant agonist", None, inf)
CTRL_C = Break("interrupted", "program", None, inf)


@pytest.mark.parametrize(
    ("first", "then", "seen_at", "took"),
    [
        (CTRL_C, CUT, 6.503, 3e-3),
        (CTRL_C, CUT, 6.3, 0.1),
        (CUT, CTRL_C, 6.203, 3e-3),
        (CUT, CUT, 6.503, 0.303),
        (CUT, None, 6.203, 3e-3),
        (CTRL_C, CUT, None, None),
    ],
    ids=["the second", "before it came", "the first", "both", "one", "never seen"],
)
def test_it_is_counted_from_what_had_to_be_seen(first, then, seen_at, took):
    case = Case("cylinder", "sine", 0, Moment.RUN, 6.2, first)
    if then is not None:
        case = replace(case, then=then, then_after=0.3)
    ending = CaseEnding(4, "the wire of agonist", 6.2, seen_at, felt_at=(6.2, 6.5))
    verdict = give_verdict(case, ending, SUBJECT)
    assert verdict.reaction == (None if took is None else pytest.approx(took, rel=1e-9))
    row = make_row("two at once", "cylinder", [verdict])
    assert row.reactions == (() if took is None else pytest.approx((took,) * 3, rel=1e-9))
    assert case_cells(verdict)[5] == ("" if took is None else f"{1e3 * took:.3g}")
