"""Drawn cases: the same from the same seed, possible on the rig, and as a file says."""

import random
from dataclasses import replace
from math import inf

import pytest

from rig.experiment.rehearsal import CYCLES
from rig.faults.campaign import draw_each, draw_once, draw_random
from rig.faults.case import UNIT, Break, Moment
from rig.faults.catalogue import KINDS, kind_named, kinds_for, refused_for
from rig.faults.kind import Must, Place, Plight, Sizes
from rig.faults.performance import HORIZON, _horizon
from rig.faults.scenario_file import case_of, load_scenario
from rig.faults.subject import Subject
from rig.faults.verdict import FAULTED, INTERRUPTED, OURS, CaseEnding, give_verdict
from rig.hal import ConfigurationError
from rig.hal.world import Frames
from rig.runtime.phases import Timings

SUBJECT = Subject(
    rig="cylinder",
    experiments=("sine", "step", "ramp"),
    period=1e-3,
    channels={"regulators": ("agonist", "antagonist"), "plant": ("agonist", "antagonist")},
    knows={
        "plant": ("wire_cut", "supply_lost", "agonist.regulator_slow", "antagonist.regulator_slow"),
        "regulators": ("silent", "wire_break", "emergency_stop"),
        "encoder": ("silent", "frozen", "jump"),
        "can0": ("frame_loss", "bus_off"),
    },
    frames={
        "regulators": Frames("can0", (0x210,), (0x290,), (0x710,)),
        "encoder": Frames("can0", (), (0x1A0,), (0x720,)),
    },
    on_bus={"can0": ("regulators", "encoder")},
    hazards=(),
    connecting=0.5,
    reading_age=15e-3,
    procedures={"friction": 49.0, "legs": 1.1},
)


def test_a_rig_suffers_only_what_it_has():
    possible = kinds_for(SUBJECT)
    assert {"wire_cut", "setpoints_lost", "sync_lost", "controller_nan"} <= set(possible)
    assert not {"drive_fault", "unplugged", "blocked", "encoder_drift"} & set(possible)
    where = {
        name: [place.where for place in kind.places(SUBJECT)] for name, kind in possible.items()
    }
    assert where["wire_cut"] == ["plant agonist", "plant antagonist"]
    assert where["regulator_slow"] == ["plant agonist", "plant antagonist"]
    assert where["setpoints_lost"] == ["regulators"]  # an encoder takes none
    assert where["bus_off"] == ["can0"]


def test_sensors_of_a_body_are_broken_one_by_one_and_named_by_their_device():
    cells, leans = ("right_front_left", "right_front_right"), ("waist_roll", "waist_pitch")
    body = replace(
        SUBJECT,
        channels={"soles": cells, "gyro": leans, "plant": ("knee", *cells, *leans)},
        knows={
            "plant": (
                "feet_frozen",
                "waist_frozen",
                *[f"{cell}.cell_offset" for cell in cells],
                "waist_roll.lean_offset",
            )
        },
    )
    possible = kinds_for(body)
    whole = {name: possible[name].places(body)[0] for name in ("feet_frozen", "waist_frozen")}
    assert {name: place.names for name, place in whole.items()} == {
        "feet_frozen": ("soles",),
        "waist_frozen": ("gyro",),
    }
    places = possible["cell_offset"].places(body)
    assert [(place.where, place.axis) for place in places] == [
        (f"plant {cell}", cell) for cell in cells
    ]
    musts = [possible["cell_offset"].must(Sizes(size, inf), body) for size in (-30.0, 60.0, -200.0)]
    assert musts == [Must.RIDE, Must.EITHER, Must.SAFE]
    assert "cell_frozen" not in possible
    assert "feet_frozen" not in kinds_for(SUBJECT)
    unread = replace(body, channels={"plant": ("knee", *cells, *leans)})
    assert not [name for name in kinds_for(unread) if name.startswith(("cell", "lean", "feet"))]


def test_a_frozen_monitor_must_be_seen_where_an_inner_loop_rests_on_it():
    valves = replace(SUBJECT, knows={"plant": ("valve_stuck", "agonist.monitor_frozen")})
    row, sizes = KINDS["monitor_frozen"], Sizes(None, inf)
    assert (row.must(sizes, valves), row.must(sizes, SUBJECT)) == (Must.SAFE, Must.EITHER)


def test_an_output_that_stays_leaves_a_spool_open_and_a_regulator_at_its_pressure():
    valves = replace(SUBJECT, knows={"plant": ("valve_stuck",), "regulators": ("output_stuck",)})
    row = KINDS["output_stuck"]
    for subject, forgiven in ((valves, True), (SUBJECT, False)):
        place = Place("regulators", "regulators agonist", ("agonist",), 0.0)
        plight = Plight(subject, place, Sizes(None, inf), {}, 1.0, 0.0)
        assert ("position" in row.excuses(plight)) is forgiven


def test_every_kind_is_either_possible_or_refused_with_what_it_needs():
    possible, refused = set(kinds_for(SUBJECT)), refused_for(SUBJECT)
    assert possible | set(refused) == set(KINDS)
    assert not possible & set(refused)
    assert {"drive_fault", "unplugged", "blocked", "encoder_drift"} <= set(refused)
    assert all(refused.values())


def test_the_same_seed_draws_the_same_cases_and_another_others():
    assert draw_random(SUBJECT, 3, 40) == draw_random(SUBJECT, 3, 40)
    assert draw_random(SUBJECT, 3, 40) != draw_random(SUBJECT, 4, 40)


def test_a_case_is_drawn_again_from_its_own_line():
    for case in (*draw_each(SUBJECT, 11, 3), *draw_random(SUBJECT, 12, 60)):
        (again,) = draw_once(SUBJECT, case.kinds, case.drawn_with, 1)
        assert again == case
        assert case.command.endswith(f"--only {'+'.join(case.kinds)} --seed {case.drawn_with}")


def test_cases_of_a_unit_share_experiment_and_seed_and_units_differ():
    units = {}
    for case in draw_each(SUBJECT, 5, 20):
        stretch = (case.drawn_with // UNIT, case.moment is Moment.CALIBRATION)
        units.setdefault(stretch, set()).add((case.experiment, case.seed))
    assert all(len(shared) == 1 for shared in units.values())
    assert len(set.union(*units.values())) == len(units) > 5


def test_everything_is_drawn_somewhere():
    cases = draw_random(SUBJECT, 1, 2000)
    assert {case.moment for case in cases} == set(Moment)
    assert {case.first.where for case in cases if case.first.kind == "wire_cut"} == {
        "plant agonist",
        "plant antagonist",
    }
    calibrations = [case for case in cases if case.moment is Moment.CALIBRATION]
    assert {case.experiment for case in calibrations} == set(SUBJECT.procedures)
    assert all(case.after <= SUBJECT.procedures[case.experiment] for case in calibrations)
    others = {case.experiment for case in cases if case not in calibrations}
    assert others == set(SUBJECT.experiments)
    rehearsed = [case for case in cases if case.moment is Moment.REHEARSAL]
    assert {case.first.where for case in rehearsed} == {"program"}
    assert all(case.after < CYCLES * SUBJECT.period for case in rehearsed)
    assert any(case.then is not None for case in cases)
    for case in cases:
        for item in case.breaks:
            limits = item.row.magnitude
            assert (limits is None) == (item.magnitude is None)
            if limits is not None:
                assert limits.low <= abs(item.magnitude) <= limits.high * (1 + 1e-12)


def test_who_chose_the_experiments_gets_no_calibration():
    cases = draw_random(replace(SUBJECT, chosen=SUBJECT.experiments), 1, 500)
    assert all(case.moment is not Moment.CALIBRATION for case in cases)


def test_what_a_size_asks_for():
    lost = KINDS["readings_lost"]
    assert lost.must(Sizes(None, 5e-3), SUBJECT) is Must.EITHER
    assert lost.must(Sizes(None, 0.5), SUBJECT) is Must.SAFE


def test_what_may_go_unseen_says_why():
    small = Sizes(1e-12, 0.0)
    silent = [
        name
        for name, kind in KINDS.items()
        if kind.must(small, SUBJECT) is Must.EITHER and not kind.why
    ]
    assert not silent


def test_no_such_fault_is_said_with_the_nearest():
    with pytest.raises(ConfigurationError, match="did you mean 'wire_cut'"):
        draw_once(SUBJECT, ("wirecut",), 0, 1)
    with pytest.raises(ConfigurationError, match="nothing that could suffer blocked"):
        draw_once(SUBJECT, ("blocked",), 0, 1)


SCENARIO = """\
rig: cylinder
experiment: sine
seed: 7
fault: wire_cut
where: plant antagonist
when: {phase: release, after: 31 ms}
then: {fault: silent, where: encoder, lasts: 20 ms, after: 4 ms}
"""


def scenario(tmp_path, text=SCENARIO):
    path = tmp_path / "case.yaml"
    path.write_text(text)
    return case_of(load_scenario(path), SUBJECT, str(path))


def test_a_file_says_what_breaks(tmp_path):
    case = scenario(tmp_path)
    assert case.kinds == ("wire_cut", "silent")
    assert (case.moment, case.after) == (Moment.RELEASE, pytest.approx(31e-3))
    assert (case.then.where, case.then.lasts, case.then_after) == ("encoder", 20e-3, 4e-3)
    assert (case.experiment, case.seed) == ("sine", 7)


@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ("wire_cut", "wire_cuts", "case.yaml:4:8: no fault is called 'wire_cuts'"),
        (
            "wire_cut", "zorgblatt",
            "case.yaml:4:8: no fault is called 'zorgblatt'\n.*\n.*\n *rig faults list cylinder has",
        ),
        ("plant antagonist", "antagonist", "there is plant agonist, plant antagonist"),
        ("phase: release", "phase: relax", "case.yaml:6:15"),
        ("seed: 7", "seed: -7", "case.yaml:3:7"),
        ("fault: wire_cut", "fault: blocked", "case.yaml:4:8: cylinder has nothing"),
        ("where: plant antagonist", "where: plant agonist\nlasts: 1 s", "case.yaml:6:8: "),
        ("where: plant antagonist", "where: plant agonist\nmagnitude: 3", "case.yaml:6:12: "),
        ("seed: 7", "sed: 7", "case.yaml:3:1"),
        ("phase: release", "phase: calibration", "case.yaml:2:13: no procedure"),
        ("phase: release", "phase: rehearsal", "case.yaml:7:7: a rehearsal takes"),
        (
            "when: {phase: release, after: 31 ms}\nthen: {fault: silent, where: encoder, "
            "lasts: 20 ms, after: 4 ms}",
            "when: {phase: rehearsal}",
            "case.yaml:4:8: wire_cut cannot be expressed in a rehearsal",
        ),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_done_is_refused(tmp_path, wrong, right, said):
    with pytest.raises(ConfigurationError, match=said.replace("?", r"\?")):
        scenario(tmp_path, SCENARIO.replace(wrong, right))


def leak(tmp_path, written):
    """Return the case of a leak whose size is written so."""
    path = tmp_path / "case.yaml"
    where = "where: plant antagonist"
    text = SCENARIO.replace("wire_cut", "leak")
    path.write_text(text.replace(where, f"{where}\nmagnitude: {written}"))
    knows = dict(SUBJECT.knows)
    leaky = replace(SUBJECT, knows={**knows, "plant": (*knows["plant"], "antagonist.leak")})
    return case_of(load_scenario(path), leaky, str(path))


@pytest.mark.parametrize(
    "written", ["2e-8 m^3/(s Pa)", "2e-8", "2.0E-08 m^3/(Pa s)", "20e-9 m^3/s/Pa"]
)
def test_a_magnitude_may_be_written_as_the_list_of_faults_prints_its_unit(tmp_path, written):
    assert leak(tmp_path, written).first.magnitude == pytest.approx(2e-8)


@pytest.mark.parametrize("written", ["-2e-8", "-2e-8 m^3/(s Pa)", "2e-8 m^3/(s Pa) more", "3 kPa"])
def test_a_magnitude_of_another_sign_or_unit_is_refused_where_it_stands(tmp_path, written):
    with pytest.raises(ConfigurationError, match=r"case\.yaml:6:12: leak: magnitude"):
        leak(tmp_path, written)


def test_what_a_plant_of_others_can_suffer_is_offered_and_repeated_with_its_folder():
    foreign = replace(
        SUBJECT, knows={"plant": ("jammed", "repair"), "can0": ("bus_off",)}, configs="my configs"
    )
    assert "jammed" in kinds_for(foreign)
    assert "repair" not in kinds_for(foreign)
    (case,) = draw_once(foreign, ("jammed",), 3, 1)
    assert case.first.where == "plant"
    assert case.first.row.must(case.first.sizes, foreign) is Must.EITHER
    assert case.command.endswith("--only jammed --seed 3 --configs 'my configs'")


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


def test_what_goes_wrong_is_kept_under_the_rigs_name_wherever_its_profile_is():
    """A path of it would lead out of the campaign's folder."""
    (case,) = draw_once(replace(SUBJECT, rig="/lab/rigs/mine.yaml"), ("silent",), 3, 1)
    assert case.folder == "mine-3-silent"
    assert draw_once(SUBJECT, ("silent",), 3, 1)[0].folder == "cylinder-3-silent"


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
