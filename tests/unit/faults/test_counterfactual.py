"""A hazard is excused if the emergency stop, pressed at once, would not have kept it off."""

from dataclasses import replace
from math import inf

import pytest
from broken_cylinder import SUBJECT

from rig.faults.case import Break, Case, Moment
from rig.faults.counterfactual import borne_out, stopped_at_once
from rig.faults.oracle import Violation
from rig.faults.verdict import CaseEnding, give_verdict

RIG = replace(SUBJECT, knows={**SUBJECT.knows, "plant": ("agonist.leak", "antagonist.leak")})
LEAK = Break("leak", "plant agonist", 2e-8, inf)


def case_of(first=LEAK, then=None):
    return Case("cylinder", "sine", 1, Moment.RUN, 0.5, first, then, 0.1)


def verdict_of(*hazards, excused=()):
    def became(names):
        return tuple(Violation(name, "position", 1.0, 0.03, 0.024, "m") for name in names)

    ending = CaseEnding(4, "chamber of agonist", 1.0, 1.01, became(hazards), (1.0,), "it began",
                        became(excused))  # fmt: skip
    return give_verdict(case_of(), ending, RIG)


def test_the_same_case_is_stopped_by_hand_when_anybody_could_see_it():
    stopped = stopped_at_once(case_of(), RIG)
    assert stopped == replace(
        case_of(), then=Break("emergency_stop", "regulators", None, inf), then_after=8e-3
    )


@pytest.mark.parametrize(
    ("case", "rig"),
    [
        (case_of(then=LEAK), RIG),
        (case_of(Break("wire_cut", "plant agonist", None, inf)), SUBJECT),
        (case_of(), replace(RIG, knows={"plant": RIG.knows["plant"]})),
    ],
    ids=["a second fault", "what is forgiven anyway", "no emergency stop"],
)
def test_what_would_tell_nothing_is_not_done(case, rig):
    assert stopped_at_once(case, rig) is None


def test_what_the_stop_does_not_keep_off_is_not_counted():
    found = borne_out(verdict_of("position", "speed"), verdict_of("position", excused=["speed"]))
    assert not found.hazard
    assert not found.failed
    assert [one.hazard for one in found.ending.excused] == ["position", "speed"]
    assert found.outcome == "excused"


def test_what_it_keeps_off_is():
    found = borne_out(verdict_of("position", "speed", excused=["tilt"]), verdict_of("speed"))
    assert found.hazard
    assert [one.hazard for one in found.ending.violations] == ["position"]
    assert [one.hazard for one in found.ending.excused] == ["tilt", "speed"]


def test_air_that_is_left_is_counted_whoever_presses():
    assert borne_out(verdict_of("energy left"), verdict_of("energy left")).hazard
