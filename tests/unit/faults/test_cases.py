"""Drawn cases: the same from the same seed, possible on the rig, and as a file says."""

from dataclasses import replace
from math import inf

import pytest
from broken_cylinder import SUBJECT

from rig.experiment.rehearsal import CYCLES
from rig.faults.campaign import draw_each, draw_once, draw_random
from rig.faults.case import UNIT, Moment
from rig.faults.catalogue import KINDS, kinds_for, refused_for
from rig.faults.kind import Must, Place, Plight, Sizes
from rig.faults.scenario_file import case_of, load_scenario
from rig.hal import ConfigurationError


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


def test_what_goes_wrong_is_kept_under_the_rigs_name_wherever_its_profile_is():
    """A path of it would lead out of the campaign's folder."""
    (case,) = draw_once(replace(SUBJECT, rig="/lab/rigs/mine.yaml"), ("silent",), 3, 1)
    assert case.folder == "mine-3-silent"
    assert draw_once(SUBJECT, ("silent",), 3, 1)[0].folder == "cylinder-3-silent"
