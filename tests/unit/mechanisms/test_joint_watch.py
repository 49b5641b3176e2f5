"""What the joint's checks make of its readings: speeds, tilt and stretch, and its camera."""

import math

import pytest
from joint_fakes import (
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
from joint_rods import Rods
from pneumatic_fakes import BASE, HOME, PERIOD, SPEED, TINY, FakeCamera

from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import CameraSample
from rig.hal import LimitExceeded, Markers, SafetyError
from rig.mechanisms.joint import watch as watched
from rig.mechanisms.joint.settings import JointFriction

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
    bench.regulators.reads = off((BASE,) * 4, 2, 45e3)
    bench.cycles(5)  # 3.9 ms: nobody has asked for it
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


# The watch on its own ----------------------------------------------------------------------------


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
