"""What the joint's checks make of its readings: speeds, tilt, stretch, and the cause of a fault."""

import math

import numpy as np
import pytest
from joint_fakes import (
    CHANNELS,
    ENCODERS,
    EXCESS,
    GEOMETRY,
    GRACE,
    TILT,
    UPRIGHT,
    JointBench,
    joint_limits,
    joint_settings,
    off,
    rods_at,
)
from pneumatic_fakes import BASE, HOME, PERIOD, SPEED, TINY, FakeCamera

from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import CameraSample, JointState
from rig.hal import DeviceFault, LimitExceeded, Markers, SafetyError, StaleReading
from rig.mechanisms.joint import watch as watched
from rig.mechanisms.joint.settings import JointFriction
from rig.mechanisms.joint.watch import JointWatch
from rig.mechanisms.pneumatic.alarms.pressures import PressureOff

TILTED = rods_at(0.3, 0.4)
ERROR = LimitExceeded("speed of something", 1.0, -0.5, 0.5, "m/s")
GRACE_CYCLES = round(GRACE / PERIOD)


def one(number, rod):
    """Return rods of which one (1 … 4) is pulled in, m."""
    return off(UPRIGHT, number, rod)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("number", [0, 1, 2, 3])
@pytest.mark.parametrize("what", ["rod", "pressure"])
def test_a_reading_that_is_not_a_number_is_a_fault(what, number, bad):
    bench = JointBench()
    if what == "rod":
        bench.encoders[number].extension = bad
    else:
        bench.regulators.reads = off((BASE,) * 4, number + 1, bad)
    with pytest.raises(SafetyError, match="a reading is not a number"):
        bench.cycles(1)


# Speeds ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_rod_may_go_as_fast_as_the_limit_and_not_faster(number, way):
    window = 2.0**-6
    for beyond in (0.0, TINY):
        bench = JointBench()
        bench.cycle(0.0)
        bench.place(one(number, way * (SPEED * window + beyond)))
        if not beyond:
            bench.cycle(window)
            continue
        with pytest.raises(LimitExceeded) as caught:
            bench.cycle(window)
        error = caught.value
        assert error.quantity == f"speed of the rod of ch{number}"
        assert (error.lower, error.upper, error.unit) == (-SPEED, SPEED, "m/s")
        assert error.value == way * (SPEED + TINY / window)


def test_speeds_are_judged_over_ten_milliseconds():
    bench = JointBench()
    bench.cycle(0.0)
    bench.place(one(2, 0.4 * HOME))
    bench.cycle(math.nextafter(0.01, 0.0))
    with pytest.raises(LimitExceeded, match="speed of the rod of ch2"):
        bench.cycle(0.01)


def test_each_window_of_speed_starts_where_the_last_one_ended():
    window = 2.0**-6
    bench = JointBench()
    bench.cycle(0.0)
    bench.cycle(window)
    bench.place(one(3, SPEED * window + TINY))
    bench.cycle(1.5 * window)  # too soon
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle(2.0 * window)
    assert caught.value.value == SPEED + TINY / window


def test_a_new_motion_forgets_where_the_rods_were():
    bench = JointBench()
    state = bench.cycle(0.0)
    bench.place(one(1, 0.4 * HOME))
    bench.joint.start_limiting(state)
    bench.cycle(0.01)
    bench.place(one(1, 0.0))
    with pytest.raises(LimitExceeded, match="speed of the rod of ch1"):
        bench.cycle(0.02)


# Tilt and stretch --------------------------------------------------------------------------------


@pytest.mark.parametrize("azimuth", [0.0, 0.4, 2.0, 4.0])
def test_the_ring_may_lean_by_the_limit_and_its_excess(azimuth):
    bench = JointBench()
    bench.lean(TILT + EXCESS - 1e-7, azimuth)
    bench.cycles(20)
    bench = JointBench()
    bench.lean(TILT + EXCESS + 1e-7, azimuth)
    bench.cycles(3)  # the pose is worked out in every fourth
    with pytest.raises(LimitExceeded) as caught:
        bench.cycles(1)
    error = caught.value
    assert (error.quantity, error.lower, error.upper, error.unit) == (
        "tilt of the ring",
        0.0,
        TILT + EXCESS,
        "rad",
    )
    assert error.value == pytest.approx(TILT + EXCESS, abs=1e-6)


def test_what_the_wires_stretch_is_taken_off_before_the_pose_is_worked_out():
    settings = joint_settings(wire_stiffness=80e3)
    bench = JointBench(settings)
    pressures = (50e3, 150e3, 400e3, 250e3)
    bench.regulators.reads = pressures
    stretch = [settings.area * pressure / 80e3 for pressure in pressures]
    bench.place([rod + more for rod, more in zip(TILTED, stretch, strict=True)])
    state = bench.cycles(4)
    axis = axis_from_tilt(0.3, 0.4)
    assert bench.joint.reference_of(state).axis == pytest.approx(axis, abs=1e-9)
    margins = {margin.name: margin.fraction for margin in bench.joint._watch.margins()}
    assert margins == pytest.approx(
        {"tilt": 1.0 - 0.3 / (TILT + EXCESS), "wire agreement": 1.0}, abs=1e-6
    )


def test_the_margin_of_the_wires_is_what_they_disagree_by():
    bench = JointBench()
    bench.place(one(1, 0.5e-3))  # half of it is left at either end of the pair
    bench.cycles(4)
    _, margin = bench.joint._watch.margins()
    assert margin.fraction == pytest.approx(1.0 - 0.25e-3 / joint_limits().residual, rel=1e-3)


# What the profile's numbers do in the alarms ---------------------------------------------------


@pytest.mark.parametrize("pressed", [1.0, -1.0])
def test_a_chamber_too_weak_to_move_its_rod_does_not_make_its_wire_taut(pressed):
    """Half of the pair's breakaway is one rod's: 5 N."""
    settings = joint_settings(friction=JointFriction(0.0, 10.0, 8e-3, 50.0))
    bench = JointBench(settings)
    bench.place(TILTED)
    bench.cycles(4)
    bench.place(off(TILTED, 1, 2e-3))
    bench.regulators.reads = (5.0 / settings.area + pressed, BASE, BASE, BASE)
    words = "has slipped, or its wire was slack" if pressed > 0.0 else "is slack or cut"
    with pytest.raises(SafetyError, match=rf"^the (anchor|wire) of ch1 {words}"):
        bench.cycles(GRACE_CYCLES + 8)


@pytest.mark.parametrize("share", [0.26, 0.24])
def test_swapped_encoders_are_told_by_a_share_of_coulomb_friction(share):
    settings = joint_settings()
    bench = JointBench(settings)
    bench.regulators.reads = off((BASE,) * 4, 3, share * 7.0 / settings.area)

    def lean_on():
        for k in range(120):
            bench.lean(0.001 * k, 0.5 * math.pi)
            bench.cycles(4)

    if share < 0.25:
        lean_on()
        return
    with pytest.raises(SafetyError, match=r"^e1 and e3 are swapped, or the tubes of ch1 and ch3"):
        lean_on()


def test_a_stuck_regulator_is_named_in_the_alarms_time():
    bench = JointBench()
    state = bench.cycles(1)
    bench.joint.start_limiting(state)
    bench.joint.write((BASE,) * 4)
    assert bench.regulators.sent == [(BASE,) * 4]
    bench.cycles(4)
    bench.regulators.reads = off((BASE,) * 4, 2, 41e3)
    bench.cycles(51)  # 49.8 ms
    with pytest.raises(SafetyError, match=r"^regulators: the regulator of ch2 is stuck open"):
        bench.cycles(1)


def seen(bench, by, twist=None):
    """Let the camera see the marker beside where it is, m, in each cycle."""
    x, y, z = GEOMETRY.marker((0.0, 0.0, 1.0))
    bench.camera.t = bench.now
    bench.camera.sees = Markers((0,), ((x + by, y, z),), () if twist is None else (twist,))


def look_on(bench, cycles, by, twist):
    for _ in range(cycles):
        seen(bench, by, twist)
        bench.cycles(1)


def test_the_camera_has_its_own_bounds():
    look_on(JointBench(camera=FakeCamera()), 300, 2.0**-8 - 1e-9, math.radians(10.0) - 1e-9)


@pytest.mark.parametrize(
    ("by", "twist", "silent", "words"),
    [
        # Looked at every fourth cycle; the first sample is older than what is remembered.
        (2.0**-8 + 1e-9, None, 8 + GRACE_CYCLES + 3, "camera: it is not where the joint"),
        (0.0, math.radians(10.0) + 1e-9, 107, "camera: the ring is twisted"),
    ],
)
def test_the_camera_has_its_own_graces(by, twist, silent, words):
    bench = JointBench(camera=FakeCamera())
    look_on(bench, silent, by, twist)
    with pytest.raises(SafetyError, match=words):
        look_on(bench, 1, by, twist)


# The cause of a fault ----------------------------------------------------------------------------


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


# The watch on its own ----------------------------------------------------------------------------


class Rods:
    """The watch of a joint that a test tells rods, and what a camera saw."""

    def __init__(self, camera=None, settings=None):
        self.watch = JointWatch(settings or joint_settings(), "regulators", ENCODERS, camera)
        self.now = 0.0

    def state(self, rods, sample=None):
        return JointState(self.now, tuple(rods), (BASE,) * 4, sample)

    def check(self, rods, sample=None, step=PERIOD):
        self.now += step
        state = self.state(rods, sample)
        self.watch.check(state, self.now)
        return state


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


def test_who_let_go_is_told_by_the_cycles_before():
    """Rods 1 and 3 of one pair run; rod 3 began, and its opposite one followed faster."""
    rods, way = np.zeros(4), 2.0**-13
    told = Rods()
    for third, first in ((0, 0), (0, 0), (2, 0), (2, 0), (2, 0), (2, 3), (2, 9)):
        rods[[2, 0]] += np.array((third, first)) * way
        state = told.check(rods)
    assert "the wire of ch3 is slack or cut" in str(told.watch.explain(ERROR, state))


def test_the_ring_may_lean_by_just_the_limit(monkeypatch):
    told = Rods()
    for beyond in (0.0, 2.0**-50):
        monkeypatch.setattr(watched, "tilt_of", lambda _, beyond=beyond: TILT + EXCESS + beyond)
        if not beyond:
            for _ in range(4):
                told.check(UPRIGHT)
            continue
        with pytest.raises(LimitExceeded, match="tilt of the ring"):
            for _ in range(4):
                told.check(UPRIGHT)


def test_without_a_sample_nothing_is_said_of_the_camera():
    told = Rods(camera="camera")
    for _ in range(4 * GRACE_CYCLES):
        told.check(UPRIGHT)


def test_without_a_camera_a_sample_is_not_looked_at():
    told = Rods()
    for _ in range(8 * GRACE_CYCLES):
        told.check(UPRIGHT, CameraSample((1.0, 0.0, 0.0), told.now, 1.0))


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
