"""The cause of a fault of the joint, as the rest of the rig shows it."""

import math

import numpy as np
import pytest
from joint_fakes import (
    CHANNELS,
    ENCODERS,
    RESIDUAL,
    UPRIGHT,
    JointBench,
    off,
    rods_at,
)
from joint_rods import Rods
from pneumatic_fakes import BASE, PERIOD, SPEED

from rig.hal import DeviceFault, LimitExceeded, SafetyError, StaleReading
from rig.mechanisms.pneumatic.alarms.balance import UNSTABLE
from rig.mechanisms.pneumatic.alarms.pressures import PressureOff
from rig.mechanisms.pneumatic.alarms.tracking import Shifted, Strayed

TILTED = rods_at(0.3, 0.4)
ERROR = LimitExceeded("speed of something", 1.0, -0.5, 0.5, "m/s")


def explain(error, before, last, now, pressure=BASE):
    """Return what becomes of an error, given the rods of two cycles and of the one of the error."""
    bench = JointBench()
    bench.place(before)
    bench.joint.start_limiting(bench.cycles(1))
    bench.joint.write((BASE,) * 4)
    for rods in (before, last):
        bench.place(rods)
        bench.regulators.reads = (pressure, BASE, BASE, BASE)
        bench.cycles(1)
    bench.place(now)
    bench.refresh(bench.now + PERIOD)
    state = bench.joint.read(bench.now + PERIOD)
    return bench.joint.explain(error, state)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_rod_that_runs_away_has_lost_its_wire(number):
    ran = off(TILTED, number, 2e-3)
    found = explain(ERROR, TILTED, ran, ran)
    assert type(found) is SafetyError
    assert str(found) == (
        f"the wire of ch{number} is slack or cut, or its anchor slips: its rod runs in, 2.00 mm "
        f"ahead of where the other three put it ({ERROR})"
    )


def test_the_rod_that_went_furthest_either_way_is_the_one_that_runs():
    """Rod 2 goes out by more than rod 4 comes in; it is not ahead of anything."""
    went = off(off(TILTED, 4, 2e-3), 2, -3e-3)
    assert explain(ERROR, TILTED, went, went) is ERROR


def test_a_stuck_regulator_is_suspected_if_the_wires_agree():
    assert explain(ERROR, TILTED, TILTED, TILTED) is ERROR
    found = explain(ERROR, TILTED, TILTED, TILTED, pressure=BASE + 25e3)
    assert str(found).startswith("regulators: the regulator of ch1 is stuck")
    assert str(found).endswith(f"({ERROR})")


@pytest.mark.parametrize("error", [StaleReading("e1", 1.0, 0.1), DeviceFault("regulators", "off")])
def test_other_faults_are_what_they_are(error):
    ran = off(TILTED, 1, 2e-3)
    assert explain(error, TILTED, ran, ran) is error


@pytest.mark.parametrize("number", [1, 4])
@pytest.mark.parametrize(
    ("way", "least"),
    [
        (0.0, 0.3 * SPEED * PERIOD),  # the device holds its last good reading
        (2e-3, 0.3 * 2e-3),
        (-2e-3, 0.3 * 2e-3),
    ],
)
def test_a_rod_that_ran_before_its_encoder_complained_did_run(number, way, least):
    error = DeviceFault(ENCODERS[number - 1], "it jumps")
    ahead = 5e-3
    for ran, cause in ((1.001 * least, True), (0.999 * least, False), (-1.001 * least, True)):
        found = explain(
            error,
            off(TILTED, number, ahead - ran),
            off(TILTED, number, ahead),
            off(TILTED, number, ahead + way),
        )
        assert (found is not error) is cause
        if cause:
            wire = str(found).partition(" is slack or cut")[0]
            assert wire.startswith("the wire of ") and CHANNELS[number - 1] in wire


# Told by the rods alone -------------------------------------------------------------------------


def test_before_the_first_cycle_the_rod_furthest_from_home_is_the_one_that_runs():
    """Rod 1 is in, rod 2 less far out: from home rod 1 went further, from elsewhere rod 2."""
    rods = off(off(UPRIGHT, 1, 2e-3), 2, -1.5e-3)
    for checked in (False, True):
        told = Rods()
        state = told.check(rods) if checked else told.state(rods)
        assert str(told.watch.explain(ERROR, state)).startswith("the wire of ch1 or ch3 is slack")


def test_an_encoder_that_complains_in_the_first_cycle_is_believed():
    """In that cycle nothing is known of a run: it has the time since the clock began."""
    error = DeviceFault(ENCODERS[0], "it jumps")
    far = 0.29 * SPEED
    told = Rods()
    state = told.check(off(UPRIGHT, 1, far), step=1.0)
    assert told.watch.explain(error, state) is error


@pytest.mark.parametrize("name", ENCODERS)
def test_a_rod_that_nobody_has_seen_before_may_have_been_drawn_out_by_a_push(name):
    jump = DeviceFault(name, "it jumps", value="+0.001445 m", bound="0.001 m")
    told = Rods()
    said = told.watch.explain(jump, told.state(UPRIGHT))
    assert isinstance(said, SafetyError)
    assert str(said) == (
        f"{name} is wrong, or the ring was pushed or struck while empty chambers held it ({jump})"
    )
    other = DeviceFault("regulators", "it is gone", bound="1 s")
    for error in (DeviceFault(name, "it reports an alarm"), other):
        assert told.watch.explain(error, told.state(UPRIGHT)) is error
    assert told.watch.explain(jump, told.check(UPRIGHT)) is jump


def test_a_rod_at_just_the_share_of_its_speed_did_not_run():
    error = DeviceFault(ENCODERS[0], "it jumps")
    way = 2.0**-8
    told = Rods()
    told.check(off(UPRIGHT, 1, -(0.3 * way)))
    told.check(UPRIGHT)
    assert told.watch.explain(error, told.state(off(UPRIGHT, 1, way))) is error
    told = Rods()
    told.check(off(UPRIGHT, 1, -(0.3001 * way)))
    told.check(UPRIGHT)
    assert told.watch.explain(error, told.state(off(UPRIGHT, 1, way))) is not error


def test_a_rod_that_goes_out_is_the_one_that_runs_if_it_went_furthest():
    """Rod 1 is pulled out by 3 mm, rod 2 comes in by 1 mm: nothing let go that pulls."""
    told = Rods()
    told.check(TILTED)
    told.check(TILTED)
    went = off(off(TILTED, 1, -3e-3), 2, 1e-3)
    state = told.check(went)
    assert told.watch.explain(ERROR, state) is ERROR


def test_an_encoder_that_complains_while_the_whole_ring_runs_saw_a_push():
    error = DeviceFault(ENCODERS[2], "it jumps")
    told = Rods()
    state = None
    for tilt in (0.2, 0.25, 0.3):
        state = told.check(rods_at(tilt, 0.5 * math.pi))
    found = told.watch.explain(error, state)
    assert str(found) == f"the ring was pushed or struck: all rods move with it ({error})"
    assert told.watch.explain(ERROR, state) is ERROR


@pytest.mark.parametrize("refused", [1, 2, 3, 4])
@pytest.mark.parametrize("step", [-0.04, 0.04])
def test_a_rod_whose_reading_was_refused_does_not_stay_behind_a_ring_that_is_pushed(step, refused):
    """The others would seem to run ahead of it, as the rod does whose wire is cut."""
    before, last, now = (rods_at(0.3 + k * step, 0.4) for k in range(3))
    held = tuple(
        was if k == refused - 1 else rod for k, (rod, was) in enumerate(zip(now, last, strict=True))
    )
    told = Rods()
    told.check(before)
    told.check(last)
    error = DeviceFault(ENCODERS[refused - 1], "it jumps")
    found = told.watch.explain(error, told.state(held))
    assert str(found) == f"the ring was pushed or struck: all rods move with it ({error})"
    # The others are where they say: one of them may have run ahead in this very cycle.
    ahead = off(held, (refused + 1) % 4 + 1, 2e-3)
    assert str(told.watch.explain(error, told.state(ahead))).startswith("the wire of ch")


def test_a_pressure_that_is_off_while_an_encoder_scatters_has_that_for_its_cause():
    error = PressureOff("regulators: the supply pressure is lost")
    told = Rods()
    state = told.check(UPRIGHT)
    assert told.watch.explain(error, state) is error
    for k in range(64):
        state = told.check(off(UPRIGHT, 2, 50e-6 * (-1.0) ** k))
    found = told.watch.explain(error, state)
    assert str(found) == f"{ENCODERS[1]} scatters by 0.082 mm, which shakes setpoints ({error})"
    other = SafetyError("something else")
    assert told.watch.explain(other, state) is other


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_pressure_that_is_off_while_one_rod_disagrees_has_that_for_its_cause(number):
    """A loop over an encoder that counts backwards throws the ring, and pressures lag behind."""
    error = PressureOff("valves: the valve of ch4 is stuck")
    told = Rods()
    for _ in range(4):
        told.check(TILTED)
    # A wrong rod spreads half of its error to its own residual, and as much to the opposite one.
    wrong = told.state(off(TILTED, number, -1.2 * RESIDUAL))
    found = str(told.watch.explain(error, wrong))
    assert ENCODERS[number - 1] in found and found.endswith(f" ({error})")
    assert found.startswith("the wire of ch")
    assert told.watch.explain(error, told.state(off(TILTED, number, -0.6 * RESIDUAL))) is error
    empty = [BASE] * 4
    empty[number - 1] = empty[(number + 1) % 4] = 0.0  # their wires may be slack because of that
    slack = told.state(off(TILTED, number, -1.2 * RESIDUAL), pressures=tuple(empty))
    assert told.watch.explain(error, slack) is error
    two = off(off(TILTED, number, -2.0 * RESIDUAL), number % 4 + 1, -2.0 * RESIDUAL)
    assert told.watch.explain(error, told.state(two)) is error


def test_who_let_go_is_told_by_the_cycles_before():
    """Rods 1 and 3 of one pair run; rod 3 began, and its opposite one followed faster."""
    rods, way = np.zeros(4), 2.0**-13
    told = Rods()
    for third, first in ((0, 0), (0, 0), (2, 0), (2, 0), (2, 0), (2, 3), (2, 9)):
        rods[[2, 0]] += np.array((third, first)) * way
        state = told.check(rods)
    assert "the wire of ch3 is slack or cut" in str(told.watch.explain(ERROR, state))


# A pull that no monitor shows -------------------------------------------------------------------


def pulled(apart):
    """Return the watch of a ring that stands still under a pull of one chamber."""
    bench = JointBench()
    bench.regulators.reads = (BASE, BASE + apart, BASE, BASE)
    bench.cycles(40)
    return bench.joint._watch


def test_a_ring_that_should_move_and_sticks_is_told_with_its_chamber():
    told = pulled(300e3).explain_held()
    assert "the chamber of ch2 leaks behind its tube" in told
    assert "the ring is pushed or held" in told
    assert pulled(0.0).explain_held() is None


@pytest.mark.usefixtures("moved_by_hand")
def test_a_ring_that_slides_is_not_held_whatever_its_monitors_say():
    bench = JointBench()
    for k in range(40):
        bench.lean(0.004 * k)
        bench.cycles(1)
    assert bench.joint._watch._balance.explain() is not None
    assert bench.joint._watch.explain_held() is None


def test_what_held_it_before_a_new_start_is_forgotten():
    watch = pulled(300e3)
    watch.restart()
    assert watch.explain_held() is None


def test_a_limit_that_is_exceeded_is_told_with_the_pull_that_no_monitor_shows():
    bench = JointBench()
    bench.regulators.reads = (BASE, BASE + 300e3, BASE, BASE)
    state = bench.cycles(40)
    told = str(bench.joint._watch.explain(ERROR, state))
    assert "the chamber of ch2 leaks behind its tube" in told
    assert told.endswith(f"({ERROR})")


def strayed(rod, off_by, ran):
    """Return what is said of a rod that is off its reference, m, while the wires agree."""
    error = Strayed("following error of a rod", off_by, -6e-3, 6e-3, "m")
    error.rod, error.ran = rod, ran
    return error, explain(error, TILTED, TILTED, TILTED)


@pytest.mark.parametrize("rod", range(4))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rod_that_has_run_off_by_itself_is_told_with_the_chamber_that_should_hold_it(rod, side):
    error, found = strayed(rod, side * 7e-3, ran=True)
    weak = CHANNELS[rod if side < 0.0 else (rod + 2) % 4]
    assert str(found) == (
        f"regulators: the chamber of {weak} leaks behind its tube, or its monitor is off, or the "
        f"ring is pushed or held{UNSTABLE} ({error})"
    )
    error, found = strayed(rod, side * 7e-3, ran=False)
    assert found is error, "it only lags, and nothing pulls it back"


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_rod_that_has_run_off_may_have_lost_its_wire_and_one_that_lags_has_not(number):
    ran = off(TILTED, number, 2e-3)
    for gone in (True, False):
        error = Strayed("following error of a rod", 7e-3, -6e-3, 6e-3, "m")
        error.rod, error.ran = number - 1, gone
        said = str(explain(error, TILTED, ran, ran))
        assert said.startswith(f"the wire of ch{number} is slack or cut") is gone


@pytest.mark.parametrize("ran", [True, False])
def test_a_regulator_that_looks_wrong_is_why_a_rod_strays(ran):
    error = Strayed("following error of a rod", 7e-3, -6e-3, 6e-3, "m")
    error.ran = ran
    found = str(explain(error, TILTED, TILTED, TILTED, pressure=BASE + 25e3))
    assert found.startswith("regulators: the regulator of ch1 is stuck open")


@pytest.mark.parametrize("other", [0, 1, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_encoder_that_complains_while_another_rod_runs_saw_a_push(other, sign):
    """A push takes one wire along and slackens another; no pose fits the rods then."""
    error = DeviceFault(ENCODERS[2], "it jumps")
    fast = 0.3 * SPEED * PERIOD
    for way, pushed in ((fast * (1.0 + 1e-6), True), (fast * (1.0 - 1e-6), False)):
        bench = JointBench()
        rods = off(TILTED, 3, -3e-3)  # its rod is held back, as no wire that lets go does it
        bench.place(TILTED)
        bench.joint.start_limiting(bench.cycles(1))
        bench.joint.write((BASE,) * 4)
        moved = list(rods)
        for k in range(2):
            moved[2] -= 2.0 * fast * k
            moved[other] += sign * way * k
            bench.place(tuple(moved))
            state = bench.cycles(1)
        found = str(bench.joint.explain(error, state))
        words = "the ring was pushed or struck: other rods run with it"
        assert found.startswith(words) is pushed, found


@pytest.mark.parametrize("rod", range(4))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rod_is_driven_by_the_pressures_of_its_pair(rod, side):
    """The one that has more pressure comes in, and takes the opposite one out."""
    told = Rods()
    pressures = [BASE] * 4
    pressures[rod if side > 0.0 else (rod + 2) % 4] += 100e3
    for k in range(40):
        told.watch._balance.note(k * PERIOD, UPRIGHT, tuple(pressures))
    for other in range(4):
        same = other in (rod, (rod + 2) % 4)
        assert told.watch.drives(other, side if other == rod else -side) is same
        assert not told.watch.drives(other, -side if other == rod else side)


@pytest.mark.parametrize("side", range(4))
def test_a_ring_that_runs_because_a_chamber_loses_its_air_was_not_pushed(side):
    told, each = Rods(), [rods_at(tilt, 0.5 * math.pi * side) for tilt in (0.2, 0.25, 0.3)]
    weak = int(np.argmin(np.subtract(each[-1], each[0])))
    for k, rods in enumerate(each):
        state = told.check(rods)
        pressures = [BASE] * 4
        pressures[weak] -= 10e3 * k
        told.watch._balance.note(1.0 + k * PERIOD, rods, tuple(pressures))
    for k, encoder in enumerate(ENCODERS):
        found = str(told.watch.explain(DeviceFault(encoder, "it jumps"), state))
        leaks = f"the chamber of {CHANNELS[weak]} leaks behind its tube"
        assert (leaks in found) is (k in (weak, (weak + 2) % 4)), found


@pytest.mark.parametrize("rod", range(4))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rod_that_lags_after_its_pair_crept_against_its_pull_has_lost_air(rod, side):
    """Side 1: its rod is drawn in, though its chamber has less than the opposite one."""
    opposite = (rod + 2) % 4
    error = Strayed("following error of a rod for 0.3 s", 3e-3, -3e-3, 3e-3, "m")
    error.rod, error.ran = opposite, False
    for pull, crept in ((-60e3, True), (60e3, False)):
        pressures = tuple(BASE + side * pull if k == rod else BASE for k in range(4))
        told = Rods()
        for way in np.linspace(0.0, 0.6e-3, 13):
            pair = off(off(UPRIGHT, rod + 1, side * way), opposite + 1, -side * way)
            state = told.check(pair, step=0.1, pressures=pressures)
        said = str(told.watch.explain(error, state))
        weak = CHANNELS[opposite if side > 0.0 else rod]
        words = f"regulators: the chamber of {weak} leaks behind its tube, or its monitor is off"
        assert said.startswith(words) is crept, said


@pytest.mark.parametrize("rod", range(4))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rod_that_starts_while_it_should_stand_is_told_with_the_chamber_that_let_it_go(rod, side):
    error = Shifted.by(rod, "way of a rod in 10 ms", side * 0.6e-3, 0.5e-3, ran=True)
    weak = CHANNELS[rod if side < 0.0 else (rod + 2) % 4]
    assert f"the chamber of {weak} leaks behind its tube" in str(
        explain(error, TILTED, TILTED, TILTED)
    )
    slow = Shifted.by(rod, "way of a rod", side * 6e-3, 5e-3)
    assert f"the chamber of {weak} leaks" in str(explain(slow, TILTED, TILTED, TILTED))
    off = tuple(x + 2e-3 * (k == rod) for k, x in enumerate(TILTED))
    assert "leaks" not in str(explain(slow, off, off, off)), "no pose shows these: it is a wire"
