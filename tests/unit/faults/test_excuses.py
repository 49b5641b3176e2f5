"""A fall is forgiven only where the plant shows that nothing could have held the robot."""

import math
import random
from dataclasses import replace

import pytest

from rig.faults.case import Break
from rig.faults.catalogue import kind_named
from rig.faults.kind import Must, Place, Plight, Sizes
from rig.faults.performance import plight_of
from rig.faults.stage import Truth
from rig.faults.subject import Subject
from rig.hal.hazards import Hazard

LIES = ("servo_encoder_jump", "servo_encoder_frozen", "servo_encoder_mirrored")
SLOW_LIES = ("servo_encoder_drift", "servo_encoder_scale", "servo_encoder_noisy")


def plight(chance, kind, *, bears, knows_velocities=False, left=1.0, size=None, moved=0.1):
    leg = chance.choice(("right", "left"))
    subject = Subject(
        rig="legs", experiments=("walk",), period=0.005, channels={}, knows={}, frames={},
        on_bus={}, hazards=(), connecting=1.0, reading_age=0.03,
        by_velocity=frozenset({"servos"} if knows_velocities else ()),
    )  # fmt: skip
    other = "left" if leg == "right" else "right"
    weight = chance.uniform(5.0, 60.0)
    truth = {f"load_{leg}": weight if bears else 0.0, f"load_{other}": 0.0 if bears else weight}
    magnitude = chance.choice((-1.0, 1.0)) * (chance.uniform(0.31, 1.0) if size is None else size)
    place = Place("servos", "servos knee", ("knee",), axis=f"{leg}_knee")
    return kind_named(kind), Plight(subject, place, Sizes(magnitude, math.inf), truth, left, moved)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", (*LIES, *SLOW_LIES))
def test_only_a_leg_that_bears_on_a_servo_with_one_loop_may_fold(kind, seed):
    chance = random.Random(f"{kind} {seed}")
    row, case = plight(chance, kind, bears=True)
    assert row.excuses(case) == {"fall"}
    row, case = plight(chance, kind, bears=False)
    assert row.excuses(case) == frozenset()
    row, case = plight(chance, kind, bears=True, knows_velocities=True)
    assert row.excuses(case) == frozenset()


@pytest.mark.parametrize("kind", ["overheated", "overloaded", "drive_fault", "safe_torque_off"])
def test_a_leg_that_bears_alone_folds_without_torque_and_not_beside_the_other(kind):
    chance = random.Random(kind)
    for bears, both, forgiven in (
        (True, False, {"fall", "rate"}), (False, False, set()), (True, True, set()),
        (False, True, set()),
    ):  # fmt: skip
        row, case = plight(chance, kind, bears=bears)
        stands = {name: load or 20.0 for name, load in case.truth.items()}
        assert row.excuses(case._replace(truth=stands) if both else case) == forgiven
    assert row.excuses(case._replace(truth={"position": 0.0})) == frozenset()


@pytest.mark.parametrize("seed", range(8))
def test_on_both_feet_nothing_holds_if_each_leg_has_a_joint_without_torque(seed):
    chance = random.Random(f"both {seed}")
    row, case = plight(chance, chance.choice(["safe_torque_off", "drive_fault"]), bears=True)
    leg = case.place.axis.partition("_")[0]
    other = {"left": "right", "right": "left"}[leg]
    joints = ("hip_pitch", "knee", "ankle_pitch", "ankle_roll")
    lost = chance.choice(joints)
    stands = {f"load_{side}": chance.uniform(5.0, 60.0) for side in (leg, other)}
    stands |= {f"powered_{side}_{joint}": 1.0 for side in (leg, other) for joint in joints}
    for more, forgiven in (
        ({}, set()),
        ({f"powered_{leg}_{lost}": 0.0}, set()),
        ({f"powered_{other}_{lost}": 0.0}, {"fall", "rate"}),
        ({f"powered_{other}_{joint}": 0.0 for joint in joints}, set()),  # released before
    ):
        assert row.excuses(case._replace(truth={**stands, **more})) == forgiven


@pytest.mark.parametrize("seed", range(20))
def test_over_the_ankle_that_lets_go_both_feet_hold_nothing(seed):
    chance = random.Random(seed)
    row, case = plight(chance, "overheated", bears=True)
    leg = case.place.axis.partition("_")[0]
    other = {"left": "right", "right": "left"}[leg]
    here, there = (complex(*(chance.uniform(-0.1, 0.1) for _ in "xy")) for _ in "lr")
    for share, aside, forgiven in (
        (1.0 + chance.uniform(1e-6, 0.3), chance.uniform(-1, 1), {"fall", "rate"}),
        (1.0 - chance.uniform(1e-6, 1.0), chance.uniform(-1, 1), set()),
    ):
        waist = there + complex(share, aside) * (here - there)
        feet = {
            f"{part}_{axis}": value
            for part, at in ((f"{leg}_foot", here), (f"{other}_foot", there), ("waist", waist))
            for axis, value in (("x", at.real), ("y", at.imag))
        }
        stands = feet | {"load_left": 20.0, "load_right": 20.0}
        assert row.excuses(case._replace(truth=stands)) == forgiven


@pytest.mark.parametrize("seed", range(5))
def test_a_supply_that_is_more_than_chambers_rest_at_need_not_be_missed(seed):
    chance = random.Random(seed)
    row, case = plight(chance, "supply_lost", bears=True)
    base = chance.uniform(40e3, 99e3)
    subject = replace(case.subject, base_pressure=base)
    seen = base - 12e3  # less than this may be what a regulator is off
    for supply, must in ((seen - 1.0, Must.SAFE), (seen + 1.0, Must.EITHER)):
        assert row.must(Sizes(supply, math.inf), subject) is must


@pytest.mark.parametrize("kind", ["carriage_push", "ring_push"])
def test_who_throws_a_rod_compresses_what_is_in_its_chamber(kind):
    row, case = plight(random.Random(kind), kind, bears=True, size=0.5)
    full, empty = {"pressure_ch1": 60e3, "pressure_ch2": 51e3}, {"pressure_ch1": 1e3}
    assert row.excuses(case._replace(truth=full)) == frozenset()
    assert "energy left" in row.excuses(case._replace(truth=empty))
    strong, stronger = ({"pressure_ch1": p, "pressure_ch2": 400e3} for p in (110e3, 380e3))
    for truth, most in ((strong, 2.0), (stronger, 2.0), (full, 2.0 * 51 / 110)):
        for share, forgiven in ((0.99, False), (1.01, True)):
            pushed = case._replace(truth=truth, sizes=Sizes(share * most, math.inf))
            assert ("energy left" in row.excuses(pushed)) is forgiven


@pytest.mark.parametrize("seed", range(5))
def test_a_wide_tube_off_is_a_cut_wire_while_another_chamber_pulls(seed):
    chance = random.Random(seed)
    row = kind_named("leak")
    _, case = plight(chance, LIES[0], bears=True)
    wide, pulls = chance.uniform(1.5e-8, 5e-8), chance.uniform(51e3, 400e3)
    truth = {"pressure_ch1": 1e3, "pressure_ch2": pulls, "position": 0.0}
    case = case._replace(truth=truth, sizes=Sizes(wide, math.inf))
    assert "energy left" not in row.excuses(case)
    assert {"tilt", "speed"} < row.excuses(case)
    narrow = case._replace(
        sizes=Sizes(min(chance.uniform(1e-8, 1.49e-8), 2.69e-3 / pulls), math.inf)
    )
    empty = case._replace(truth=dict(truth, pressure_ch2=chance.uniform(0.0, 49e3)))
    assert row.excuses(narrow) == row.excuses(empty) == frozenset()
    for flow, forgiven in ((2.69e-3, False), (2.71e-3, True)):  # m3/s: much at high pressures
        high = case._replace(
            truth=truth | {"pressure_ch2": 340e3}, sizes=Sizes(flow / 340e3, math.inf)
        )
        assert ("speed" in row.excuses(high)) is forgiven


@pytest.mark.parametrize("seed", range(5))
def test_a_jump_that_can_be_made_up_for_is_no_excuse(seed):
    chance = random.Random(seed)
    row, case = plight(chance, LIES[0], bears=True, size=chance.uniform(0.05, 0.29))
    assert row.excuses(case) == frozenset()


@pytest.mark.parametrize("kind", LIES)
def test_what_breaks_when_the_program_is_about_to_end_is_seen_by_nobody(kind):
    chance = random.Random(kind)
    row, case = plight(chance, kind, bears=True, knows_velocities=True, left=0.0149)
    assert row.excuses(case) == {"fall", "rate"}
    row, case = plight(chance, kind, bears=True, knows_velocities=True, left=0.0151)
    assert row.excuses(case) == frozenset()


@pytest.mark.parametrize("kind", LIES[1:])
def test_a_lie_at_rest_is_seen_by_nobody(kind):
    chance = random.Random(kind)
    row, case = plight(chance, kind, bears=True, knows_velocities=True, moved=4e-3)
    assert row.excuses(case) == {"fall", "rate"}
    row, case = plight(chance, kind, bears=True, knows_velocities=True, moved=6e-3)
    assert row.excuses(case) == frozenset()


@pytest.mark.parametrize(
    ("kind", "harmless", "bearable", "too_much", "what"),
    [
        ("push", 0.04, 0.29, 0.31, {"fall"}),
        ("hand_push", 0.4, 9.9, 10.1, {"rate", "range"}),
    ],
)
def test_a_push_is_ridden_borne_or_too_much(kind, harmless, bearable, too_much, what):
    chance = random.Random(kind)
    for size, must, excused in (
        (harmless, Must.RIDE, frozenset()),
        (bearable, Must.EITHER, frozenset()),
        (too_much, Must.EITHER, what),
    ):
        row, case = plight(chance, kind, bears=True, size=size)
        assert row.must(case.sizes, case.subject) is must
        assert row.excuses(case) == excused


@pytest.mark.parametrize("seed", range(8))
def test_a_plight_is_that_of_the_fault_until_the_program_has_ended(seed):
    chance = random.Random(seed)
    _, case = plight(chance, LIES[1], bears=True)
    leg = case.place.axis.partition("_")[0]
    known = {"servos": (f"{leg}_knee.encoder_frozen",)}
    subject = replace(case.subject, knows=known)
    item = Break(LIES[1], f"servos {leg}_knee", None, math.inf)
    times = [k * 5e-3 for k in range(200)]
    angles = [chance.uniform(-1.0, 1.0) for _ in times]
    truth = Truth(times, [(angle, 7.0) for angle in angles])
    first, last = sorted(chance.sample(range(200), 2))
    columns = (f"{leg}_knee", f"load_{leg}")

    def found(broke, ended):
        return plight_of(item, subject, columns, truth, broke, ended)

    seen = found(times[first], times[last])
    # What moved in the last moments, nobody could have seen before the end.
    before = times[last] - item.row.within
    way = [angle for t, angle in zip(times, angles, strict=True) if times[first] <= t <= before]
    assert seen.moved == (max(way) - min(way) if way else 0.0)
    assert seen.left == pytest.approx(times[last] - times[first])
    assert seen.truth == {f"{leg}_knee": angles[first], f"load_{leg}": 7.0}
    late = found(times[last], times[first])  # nobody is there any more
    assert late.moved == 0.0
    assert late.left < 0.0
    assert found(None, times[last]).left == 0.0
    over = times[first] - 0.25  # its loop was, while it still asked whether the rig is safe
    seen = plight_of(item, subject, columns, truth, times[first], times[last], over)
    assert seen.left == pytest.approx(-0.25)


ON_A_WIRE = {"position", "speed", "tilt", "tension", "end stop hit"}


@pytest.mark.parametrize("seed", range(5))
def test_a_regulator_that_stays_where_it_is_explains_what_its_pressure_can_do(seed):
    chance = random.Random(seed)
    most = chance.uniform(200e3, 400e3)
    hazards = (Hazard("pressure", "Pa", ("pressure_agonist",), -math.inf, most),)
    for pressure, excused in (
        (chance.uniform(5e3, 49.9e3), set()),
        (chance.uniform(50.1e3, most - 1.0), ON_A_WIRE),
        (chance.uniform(most + 1.0, 450e3), {*ON_A_WIRE, "pressure"}),
    ):
        row, case = plight(chance, "regulator_stuck_at", bears=False)
        subject = replace(case.subject, hazards=hazards)
        case = case._replace(subject=subject, sizes=Sizes(pressure, math.inf))
        assert row.excuses(case) == excused
    assert row.forgives == frozenset()


@pytest.mark.parametrize("seed", range(5))
def test_a_broken_brake_explains_only_a_joint_whose_drive_has_no_torque(seed):
    """It is looked at from the fault on: what was without torque before is no excuse."""
    chance = random.Random(seed)
    count = 60
    axis = chance.choice(("q1", "q2", "q3"))
    times = [0.1 * k for k in range(count)]
    broke, other = chance.randrange(10, 40), "q4"
    place = Place("plant", f"plant {axis}", (axis,), number=0.0)
    item = Break("brake_released", place.where, None, math.inf)
    row, case = plight(chance, "brake_released", bears=False)
    subject = replace(
        case.subject, rig="arm", channels={"plant": (axis,)}, knows={"plant": ("brake_released",)}
    )
    columns = [axis, f"powered_{axis}", f"powered_{other}"]
    for off, excused in (
        (range(broke), set()),
        (range(chance.randrange(broke, count), count), {"rate", "range"}),
        ((), set()),
    ):
        rows = [(0.0, float(k not in off), float(k % 2)) for k in range(count)]
        seen = plight_of(item, subject, columns, Truth(times, rows), times[broke], times[-1])
        assert row.excuses(seen) == excused
    assert row.forgives == frozenset()


@pytest.mark.parametrize("seed", range(3))
def test_who_commands_the_drives_cannot_have_them_run_away(seed):
    """Their own caps hold whoever commands them: a robot may be told to kneel, no more."""
    row, case = plight(random.Random(seed), "setpoints_spoofed", bears=True)
    assert row.forgives | row.excuses(case) == {"fall"}


@pytest.mark.parametrize("seed", range(5))
def test_only_low_pressures_hide_more_of_a_leak_and_of_a_slow_regulator(seed):
    chance = random.Random(seed)
    for kind, least, at_low in (("leak", 1.5e-8, 2e-8), ("regulator_slow", 2.5, 3.0)):
        row, case = plight(chance, kind, bears=True, size=1.0)
        low = replace(case.subject, base_pressure=chance.uniform(40e3, 99e3))
        high = replace(case.subject, base_pressure=chance.uniform(101e3, 300e3))
        between = Sizes(chance.uniform(least * 1.001, at_low * 0.999), math.inf)
        assert row.must(between, high) is Must.SAFE
        assert row.must(between, case.subject) is Must.SAFE
        assert row.must(between, low) is Must.EITHER
        assert row.must(Sizes(at_low * 1.001, math.inf), low) is Must.SAFE
