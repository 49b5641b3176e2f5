"""What must be seen of drawn faults, by when, and under which name."""

import random
from dataclasses import replace
from math import inf

import pytest
from broken_cylinder import SUBJECT

from rig.faults.campaign import draw_once, draw_random
from rig.faults.case import Break, Moment
from rig.faults.catalogue import KINDS, kind_named
from rig.faults.kind import Must, Sizes
from rig.faults.performance import HORIZON, _horizon
from rig.faults.verdict import FAULTED, INTERRUPTED, OURS, CaseEnding, give_verdict
from rig.runtime.phases import Timings

DRAWN = [case for case in draw_random(SUBJECT, 21, 900) if case.then is not None]
RUNNING = [replace(case, moment=Moment.RUN) for case in DRAWN if case.moment is not Moment.RUN
           and not {"host_paused", "controller_slow"} & set(case.kinds)]  # fmt: skip


def deadlines(case):
    """Return when each fault that must be seen has to be, from the first one on."""
    faults = ((case.first, 0.0), (case.then, case.then_after))
    return [
        begins + item.row.within
        for item, begins in faults
        if item.row.must(item.sizes, SUBJECT) is Must.SAFE
    ]


def verdict_after(case, reaction, felt=(0.0, None)):
    broke = random.Random(case.drawn_with).uniform(0.1, 3.0)
    first, then = felt[0], case.then_after if felt[1] is None else felt[1]
    felt_at = tuple(None if t == inf else broke + t for t in (first, then))
    ending = CaseEnding(FAULTED, "", broke, broke + reaction, felt_at=felt_at)
    return give_verdict(case, ending, SUBJECT)


@pytest.mark.parametrize(
    ("said", "named"),
    [
        ("the wire of {here} is slack or cut", True),
        ("the wire of {there} is slack or cut", False),  # antagonist is not agonist
        ("encoder-x: a wire jumped", False),
        ("{here}s", True),
    ],
)
def test_what_broke_is_named_by_its_own_name_and_not_within_another_one(said, named):
    cut = [case for case in draw_random(SUBJECT, 7, 600) if case.kinds == ("wire_cut",)]
    found = {case.first.where.split()[1] for case in cut if case.moment is Moment.RUN}
    assert found == {"agonist", "antagonist"}
    for case in cut:
        if case.moment is not Moment.RUN:
            continue
        here = case.first.where.split()[1]
        (there,) = {"agonist", "antagonist"} - {here}
        message = said.format(here=here, there=there)
        ending = CaseEnding(FAULTED, message, 1.0, 1.0)
        assert give_verdict(case, ending, SUBJECT).misnamed is not named


@pytest.mark.parametrize("seen", ["first", "then", "both"])
def test_each_of_two_faults_has_its_own_time(seen):
    """What must be seen counts from its own beginning, whatever came before and may stay."""
    chosen = [case for case in RUNNING if which_must(case) == seen]
    assert len(chosen) > 5
    for case in chosen:
        wanted = min(deadlines(case))
        assert verdict_after(case, wanted - 1e-3).late is False
        late = verdict_after(case, wanted + 1e-3)
        assert late.late is True
        assert f"{1e3 * wanted:.0f} ms wanted" in "".join(late.wrongs())


@pytest.mark.parametrize("stall", ["host_paused", "controller_slow"])
def test_what_breaks_while_the_program_is_stalled_has_its_time_after_it(stall):
    for drawn in draw_once(SUBJECT, (stall, "wire_break"), 5, 12):
        case = replace(drawn, moment=Moment.RUN)
        lasts, within = case.first.magnitude, case.then.row.within
        for share in (0.05, 0.95, 1.05):
            begins = max(share, 1.0) * lasts
            for more, late in ((-1e-3, False), (1e-3, True)):
                verdict = verdict_after(case, begins + within + more, (0.0, share * lasts))
                assert verdict.late is late


@pytest.mark.parametrize("later", [0, 1])
def test_a_law_that_nobody_follows_yet_has_no_time(later):
    """While a rig is energised, what spoils the law is not felt: its time begins with the law."""
    pause = random.Random(later)
    found = []
    for law in ("controller_nan", "controller_huge", "controller_raises"):
        other = pause.choice(("encoder_frozen", "frame_loss", "setpoints_twice"))
        kinds = (law, other) if later == 0 else (other, law)
        drawn = draw_once(SUBJECT, kinds, pause.randrange(1000), 4)
        found += [replace(case, moment=Moment.ENERGISE) for case in drawn]
    for case in found:
        begins = pause.uniform(0.3, 0.9)
        within = case.breaks[later].row.within
        felt = (begins, None) if later == 0 else (0.0, begins)
        never = (inf, None) if later == 0 else (0.0, inf)
        assert verdict_after(case, begins + within - 1e-3, felt).late is False
        assert verdict_after(case, begins + within + 1e-3, felt).late is True
        assert verdict_after(case, begins + 60.0, never).late is False


@pytest.mark.parametrize(
    ("kind", "crashed"), [("frame_loss", True), ("wire_cut", True), ("controller_raises", False)]
)
def test_a_bug_of_the_program_is_no_pass_whatever_need_not_be_seen(kind, crashed):
    (case,) = draw_once(SUBJECT, (kind,), 7, 1)
    ending = CaseEnding(OURS, f"ZeroDivisionError: {case.first.where}", 1.0, 1.01, (), (1.0,))
    verdict = give_verdict(case, ending, SUBJECT)
    assert verdict.crashed is crashed


def test_what_need_not_be_seen_is_never_late():
    harmless = [case for case in RUNNING if not deadlines(case)]
    assert len(harmless) > 5
    for case in harmless:
        verdict = verdict_after(case, 60.0)
        assert (verdict.late, verdict.wanted) == (False, inf)


def which_must(case):
    must = tuple(item.row.must(item.sizes, SUBJECT) is Must.SAFE for item in case.breaks)
    return {(True, False): "first", (False, True): "then", (True, True): "both"}.get(must)


INTERRUPTS = ("interrupted", "interrupted_twice")


def test_what_breaks_while_the_operator_stops_it_need_not_be_told_apart():
    """As in the phases of a stop: it is made safe anyway."""
    ended = CaseEnding(INTERRUPTED, "stopped by the operator, made safe", 1.0, None)
    found = set()
    for case in (replace(case, moment=Moment.RUN) for case in DRAWN):
        first, then = case.first, case.then
        if first.kind in INTERRUPTS:
            found.add(first.kind)
            assert not give_verdict(case, ended, SUBJECT).unseen
        elif then.kind == "interrupted_twice" and which_must(case) == "first":
            found.add(then.kind)
            for after, unseen in ((first.row.within - 1e-4, False), (first.row.within, True)):
                timed = replace(case, then_after=after)
                assert give_verdict(timed, ended, SUBJECT).unseen is unseen
        elif which_must(case) == "first":
            assert give_verdict(case, ended, SUBJECT).unseen
    assert found == set(INTERRUPTS)


def test_a_slow_disk_must_be_seen_if_something_is_written_to_it():
    row, period = kind_named("disk_slow"), SUBJECT.period
    assert row.must(Sizes(0.3, 1.01 * period), SUBJECT) is Must.SAFE
    assert row.must(Sizes(0.3, 0.99 * period), SUBJECT) is Must.EITHER
    assert row.must(Sizes(0.1, 1.0), SUBJECT) is Must.EITHER


@pytest.mark.parametrize("seed", range(4))
def test_a_wrong_setpoint_must_be_seen_where_each_is_echoed(seed):
    """The echo shows it when it lasts longer than what is late may, and the answers take."""
    chance = random.Random(seed)
    echoed = {"regulators": (True, True, True, True, False)}
    confirming = replace(SUBJECT, confirming=echoed)
    row, bridged = kind_named("setpoints_corrupt"), 0.03 + 4.0 * SUBJECT.period
    supply = Sizes(4.0, 1.0)  # that of the digital outputs, which is not echoed
    assert row.must(supply, confirming) is Must.EITHER
    for lasts, must in (
        (chance.uniform(bridged + 1e-6, 1.0), Must.SAFE),
        (chance.uniform(0.0, bridged), Must.EITHER),
    ):
        sizes = Sizes(chance.choice((1.3, 2.9, 3.0, 5.5, 7.0)), lasts)
        assert row.must(sizes, confirming) is must
        assert row.must(sizes, SUBJECT) is Must.EITHER


def test_a_law_that_is_spoilt_when_nobody_follows_it_any_more_need_not_be_seen():
    """Drives brake by themselves after Ctrl-C; what the law says then goes nowhere."""
    cases = [
        case for case in RUNNING if case.then.row.spoils_law and case.first.kind not in INTERRUPTS
    ]
    assert {"controller_nan", "controller_huge"} <= {case.then.kind for case in cases}
    for case in cases:
        alone, then = case.first.row.must(case.first.sizes, SUBJECT), case.then
        both = {alone, then.row.must(then.sizes, SUBJECT)}
        for felt_at, musts in (((1.0, None), {alone}), ((1.0, 1.5), both)):
            ending = CaseEnding(INTERRUPTED, "", 1.0, None, felt_at=felt_at)
            assert give_verdict(case, ending, SUBJECT).unseen is (Must.SAFE in musts)


@pytest.mark.parametrize(
    ("fault", "then", "seconds"),
    [
        ("silent", None, (1.0, 1.0)), ("encoder_drift", None, (1.5, 1.5)),
        ("leak", None, (1.0, 3.5)), ("monitor_frozen", None, (1.0, 1.0)),
        ("silent", "encoder_drift", (1.5, 1.5)), ("encoder_drift", "leak", (1.5, 3.5)),
    ],
)  # fmt: skip
def test_a_run_goes_on_for_as_long_as_its_faults_may_take_to_be_seen(fault, then, seconds):
    """What only motion shows is seen in the stop, which may not come when its time is over."""
    case = draw_random(SUBJECT, 1, 7)[0]
    first = Break(fault, "plant agonist", None, inf)
    second = None if then is None else Break(then, "plant agonist", None, inf)
    for moment, wait in zip((Moment.RUN, Moment.ENERGISE), seconds, strict=True):
        assert _horizon(replace(case, moment=moment, first=first, then=second)) == wait


def test_what_only_motion_shows_is_wanted_no_sooner_than_the_stop_that_moves_it():
    rows = [kind for kind in KINDS.values() if kind.in_motion]
    assert {row.name for row in rows} == {"leak", "monitor_frozen", "valve_stuck", "valve_closed"}
    assert all(row.within >= HORIZON + Timings().release for row in rows)
