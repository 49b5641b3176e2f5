"""What the joint does for the loop besides reading, limiting and writing: words, stop, memory."""

import dataclasses
import math
import random
from types import SimpleNamespace

import numpy as np
import pytest
from joint_fakes import (
    CHANNELS,
    GEOMETRY,
    TILT,
    UPRIGHT,
    JointBench,
    joint_settings,
    off,
    rods_at,
)
from pneumatic_fakes import BASE, HIGHEST, LOWEST, PERIOD, TINY, FakeCamera

from controllers.spherical_joint.laws import JointPid, JointPidSettings
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import JointCommand, JointEstimate, JointReference
from rig.hal import ConfigurationError, EmergencyStop, LimitExceeded, Markers, SafetyError
from rig.mechanisms.joint import hindsight
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.motion import JointDrawing, JointMotion

ZERO = (0.0,) * 3
UP = JointReference((0.0, 0.0, 1.0), ZERO, ZERO)
EASY = JointCommand(*(BASE,) * 4)
BELIEFS = SimpleNamespace(settings=SimpleNamespace(wire="exact", pose="natural"))


class Wanting:
    """A controller that wants the ring upright, whatever it is told."""

    learning = None
    estimate = JointEstimate(ZERO, ZERO, 0.0, UPRIGHT, (0.0,) * 4)


def swing(bench, times, tilt=0.08, half_period=64):
    """Let the ring swing to two sides of upright, where it should be; return the state."""
    for k in range(times * half_period):
        lean = tilt * math.cos(math.pi * k / half_period)
        bench.place(rods_at(abs(lean), 0.4 if lean > 0.0 else 0.4 + math.pi))
        state = bench.cycles(1)
        bench.joint.check_command(UP, EASY)
    return state


def swinging(times=3):
    bench = JointBench()
    bench.joint.attach(Wanting(), None)
    return bench, swing(bench, times)


FAULT = LimitExceeded("tilt of something", 1.0, -0.5, 0.5, "rad")


@pytest.mark.parametrize("tilt", [0.0, 0.25])
def test_a_ring_that_moves_while_its_chambers_fill_is_a_fault(tilt):
    """From where it stood when it began, upright or not; how far its wires give does not count."""
    bench = JointBench()
    bench.lean(tilt)
    bench.joint.start_limiting(bench.cycles(1))
    stood, limits = rods_at(tilt, 0.4), bench.joint.settings.limits
    most = min(limits.following, 0.2 * limits.tilt * GEOMETRY.ball_radius)
    for rod, fault in ((0.99 * most, False), (1.01 * most, True)):
        bench.place(off(stood, 3, rod))
        bench.cycles(1)
        if not fault:
            bench.joint.check_still(UP)
            continue
        with pytest.raises(LimitExceeded, match="way of the rod of ch3 while nothing controls it"):
            bench.joint.check_still(UP)


@pytest.mark.parametrize("rod", [1, 2, 3, 4])
def test_a_ring_that_is_released_strays_by_any_rod_that_goes_too_far(rod):
    bench, stood = JointBench(), rods_at(0.2, 0.4)
    most = bench.joint.settings.limits.following
    found = []
    for way in (0.0, 0.99, -0.99, -1.01):
        bench.place(off(stood, rod, way * most))
        found.append(bench.joint.strays(bench.cycles(1)))
    assert found == [False, False, False, True]


@pytest.mark.parametrize("k", range(4))
def test_a_chamber_whose_monitor_has_jumped_is_not_known_to_be_vented(k):
    bench = JointBench()
    state = bench.cycles(3)
    assert bench.joint.unsafe(state.t + 1e-3) == ""
    bench.joint._watch.pressures.jumps[k] = -500e3
    assert f": ch{k + 1} still holds " in bench.joint.unsafe(state.t + 2e-3)


def test_a_ring_that_nothing_controls_goes_a_fifth_of_its_tilt_at_most_whatever_it_follows():
    """A procedure that sets what follows aside still has the ring stay where it stands."""
    following = 18e-3
    limits = dataclasses.replace(joint_settings().limits, following=following)
    bench = JointBench(joint_settings(limits))
    bench.joint.start_limiting(bench.cycles(1))
    stood = rods_at(0.0, 0.4)
    most = 0.2 * limits.tilt * GEOMETRY.ball_radius
    assert most < following
    for rod, fault in ((0.99 * most, False), (1.01 * most, True)):
        bench.place(off(stood, 2, -rod))
        bench.cycles(1)
        if not fault:
            bench.joint.check_still(UP)
            continue
        with pytest.raises(LimitExceeded, match="way of the rod of ch2 while nothing controls it"):
            bench.joint.check_still(UP)


# The cause of a fault --------------------------------------------------------------------------


def test_a_limit_that_is_exceeded_before_anything_was_checked_is_told_as_it_is():
    bench = JointBench()
    assert bench.joint.explain(FAULT, bench.joint.read(0.0)) is FAULT


@pytest.mark.usefixtures("moved_by_hand")
def test_a_limit_that_is_exceeded_by_a_swing_is_told_with_the_swing():
    bench, state = swinging()
    told = bench.joint.explain(FAULT, state)
    assert isinstance(told, SafetyError)
    assert str(told).startswith("the rod of ch")
    assert "oscillates at 8." in str(told)
    assert str(told).endswith(f"({FAULT})")
    assert "; or regulators: the chamber of " in str(told)  # nothing pulls it to and fro here
    bench.joint._watch.restart()
    said = str(bench.joint.explain(FAULT, state))
    assert said.endswith(f"and dead time; unless it was pushed ({FAULT})"), "it swung once"
    stop = EmergencyStop("stop")
    assert bench.joint.explain(stop, state) is stop


@pytest.mark.usefixtures("moved_by_hand")
def test_what_swung_before_a_new_start_is_forgotten():
    bench, state = swinging()
    bench.joint.start_limiting(state)
    assert bench.joint.explain(FAULT, state) is FAULT


@pytest.mark.usefixtures("moved_by_hand")
def test_what_swung_while_it_was_controlled_is_forgotten_when_it_is_not():
    for leave in ("push", "controller"):
        bench, state = swinging()
        if leave == "push":
            bench.joint.controller.estimate = Wanting.estimate._replace(push=(1.0, 2.0))
            bench.joint.check_command(UP, EASY)
        else:
            bench.joint.controller = None
            bench.joint.check_command(UP, EASY)
        assert "oscillates" not in str(bench.joint.explain(FAULT, state))


def test_a_jump_before_a_new_start_is_no_speed():
    for restarted in (False, True):
        bench = JointBench()
        state = bench.cycles(1)
        bench.lean(0.45)
        bench.now += 2.0**-6 - PERIOD
        if restarted:
            bench.joint.start_limiting(state)
            bench.cycles(1)
            continue
        with pytest.raises(LimitExceeded, match="speed of the rod"):
            bench.cycles(1)


def test_a_camera_that_sees_the_marker_elsewhere_is_named():
    camera = FakeCamera("eye")
    bench = JointBench(camera=camera)
    with pytest.raises(SafetyError, match=r"^eye: "):
        for _ in range(256):
            camera.t, camera.sees = bench.now, Markers((0,), ((0.01, 0.0, 0.05),))
            bench.cycles(1)


@pytest.mark.usefixtures("moved_by_hand")
def test_a_rod_that_does_not_follow_is_a_fault_after_its_time():
    settings = joint_settings()
    lost = settings.alarms.oscillation.lost
    bench = JointBench(settings)
    bench.joint.attach(Wanting(), None)
    bench.cycles(1)
    bench.joint.check_command(UP, EASY)
    bench.lean(0.2)
    with pytest.raises(LimitExceeded, match="following error of the rod of ch"):
        for _ in range(int(lost / PERIOD) + 3):
            bench.cycles(1)
            bench.joint.check_command(UP, EASY)
    assert bench.now > lost


@pytest.mark.parametrize("k", range(4))
def test_a_pressure_that_no_controller_may_ask_for_names_the_chamber(k):
    bench = JointBench()
    asked = JointCommand(*off((BASE,) * 4, k + 1, 11.0 * HIGHEST))
    with pytest.raises(SafetyError, match=f"command of {CHANNELS[k]} is"):
        bench.joint.check_command(UP, asked)


@pytest.mark.parametrize("k", range(4))
def test_a_chamber_that_does_not_follow_what_was_sent_is_named(k):
    bench = JointBench()
    bench.joint.start_limiting(bench.cycles(1))
    sent = JointCommand(*off((BASE,) * 4, k + 1, 200e3))
    with pytest.raises(SafetyError, match=CHANNELS[k]):
        for _ in range(1024):
            bench.cycles(1)
            bench.joint.write(sent)
    assert set(bench.regulators.sent) == {sent}


def test_the_log_is_asked_for_a_cause_only_where_pneumatics_may_have_one(monkeypatch):
    bench = JointBench()
    asked = []
    monkeypatch.setattr(hindsight, "joint_suspects", lambda *given: asked.append(given) or ("a",))
    assert bench.joint.diagnose(EmergencyStop("stop"), np.zeros) == ()
    assert bench.joint.diagnose(FAULT, np.zeros) == ("a",)
    assert asked == [(np.zeros, bench.joint.settings)]


def test_a_log_is_asked_for_the_latency_of_a_camera_that_is_there(monkeypatch):
    asked = []
    monkeypatch.setattr(
        hindsight, "remark_on_latency", lambda *given: asked.append(given) or ("late",)
    )
    monkeypatch.setattr(hindsight, "remarks_on_hunting", lambda *given: ())
    assert JointBench().joint.remarks(np.zeros) == ()
    camera = FakeCamera("eye")
    assert JointBench(camera=camera).joint.remarks(np.zeros) == ("late",)
    assert asked == [(np.zeros, "eye", camera.latency)]


# Put together ----------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [GEOMETRY.marker_height + 1e-3, None, GEOMETRY.marker_height])
def test_a_camera_that_looks_at_another_sphere_is_refused(radius):
    camera = FakeCamera("eye", radius)
    if radius is None or radius == GEOMETRY.marker_height:
        JointBench(camera=camera)
        return
    with pytest.raises(ConfigurationError, match=r"^eye: marker\.sphere_radius"):
        JointBench(camera=camera)


@pytest.mark.parametrize("known", ["camera", "stop", None])
def test_a_joint_is_put_together_from_the_devices_that_the_profile_names(known):
    bench = JointBench()
    camera = FakeCamera("eye")
    camera.sees = Markers((0,), ((1.0, 2.0, 3.0),))
    devices = {"regulators": bench.regulators, "eye": camera, "stop": bench.stop}
    devices |= {encoder.name: encoder for encoder in bench.encoders}
    named = {"camera": "eye" if known == "camera" else None}
    named["emergency_stop"] = "stop" if known == "stop" else None
    joint = SphericalJoint.assemble(joint_settings(**named), devices, PERIOD)
    bench.lean(0.3, 1.0)
    state = joint.read(0.0)
    assert state.rods == pytest.approx(rods_at(0.3, 1.0))
    assert (state.camera is None) == (known != "camera")
    assert joint.stop_input() is (bench.stop if known == "stop" else None)
    with pytest.raises(ConfigurationError, match=r"joint\.regulators: no device is called"):
        SphericalJoint.assemble(joint_settings(regulators="valves"), devices, PERIOD)
    with pytest.raises(ConfigurationError, match=r"joint\.encoders: stop is no"):
        SphericalJoint.assemble(
            joint_settings(encoders=("e1", "e2", "e3", "stop")), devices, PERIOD
        )


def test_a_motion_whose_poses_are_known_is_kept_and_another_is_not():
    class Leaning(JointDrawing):
        duration, segments = 1.0, ()

        def at(self, t):
            return UP

    bench, posed = JointBench(), JointMotion(Leaning(), PERIOD)
    bench.joint.attach(Wanting(), posed)
    assert bench.joint.motion is posed
    bench.joint.attach(Wanting(), SimpleNamespace(duration=1.0))
    assert bench.joint.motion is None


# Before a run ----------------------------------------------------------------------------------


def test_it_says_what_a_cut_wire_and_an_alarm_come_to():
    told = {expected.name: expected for expected in SphericalJoint.expected_of(joint_settings())}
    assert told["alarm: a pressure off a healthy regulator by"].value == 40e3
    assert any("wire" in name for name in told)


def test_the_chambers_are_those_of_rods_at_their_homes():
    offsets = (1e-3, 0.0, -2e-3, 0.0)
    settings = joint_settings(wire_offsets=offsets)
    constants = SphericalJoint.constants_of(settings)
    empty = settings.dead_volume + settings.area * settings.stroke
    for name, offset in zip(CHANNELS, offsets, strict=True):
        taken = settings.area * (settings.home + offset)
        assert constants[f"volume_{name}"] == pytest.approx(empty - taken)
    assert constants["area"] == settings.area


def test_what_is_told_of_it_is_what_the_profile_says():
    settings = joint_settings()
    model = SphericalJoint.model_of(settings)
    assert (model.geometry, SphericalJoint.geometry_of(settings)) == (GEOMETRY, GEOMETRY)
    assert (model.ring_friction, model.wire_friction) == (0.07, 0.11)
    assert (model.least_tension, model.most_tension) == (5.0, 90.0)
    assert model.wire_stiffness == settings.wire_stiffness
    assert (model.pressure_min, model.pressure_max) == (LOWEST, HIGHEST)
    assert SphericalJoint.wiring(settings) == dict(zip(settings.encoders, CHANNELS, strict=True))


def test_margins_are_known_of_laws_of_ours_alone():
    settings = joint_settings()
    law = JointPid(JointPidSettings(), SphericalJoint.model_of(settings), PERIOD)
    loop = SphericalJoint.closed_loop(settings, law)
    assert loop is not None
    assert loop.crossover > 0.0
    assert SphericalJoint.closed_loop(settings, Wanting()) is None


def test_it_may_be_sent_where_every_pose_is_permitted():
    targets = SphericalJoint.targets(joint_settings(), BELIEFS)
    targets.check(targets.rest([TILT]))
    with pytest.raises(ValueError, match="tilt"):
        targets.check(targets.rest([TILT + 0.01]))


def test_a_plan_is_a_motion_of_the_joint():
    with pytest.raises(ValueError, match="not one for the spherical joint"):
        SphericalJoint.plan(joint_settings(), object(), BELIEFS, PERIOD)


def test_an_approach_goes_from_rest_to_rest_on_a_great_circle():
    start, end = (JointReference(axis_from_tilt(0.3, a), (1.0,) * 3, (1.0,) * 3) for a in (0, 2))
    for t, reached in ((0.0, start), (2.0, end)):
        axis, velocity, acceleration, *_ = SphericalJoint.approach(start, end, 2.0, t)
        assert axis == pytest.approx(reached.axis, abs=1e-12)
        assert (*velocity, *acceleration) == pytest.approx((0.0,) * 6, abs=1e-9)
    middle = SphericalJoint.approach(start, end, 2.0, 1.0)
    assert np.cross(start.axis, end.axis) @ np.array(middle.axis) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_a_slowed_reference_is_the_same_way_at_another_pace(seed):
    """Differences of x(s(t)) with s' = rate, s'' = change are the oracle."""
    chance = random.Random(seed)
    v, a = ([chance.uniform(-2.0, 2.0) for _ in range(3)] for _ in range(2))
    rate, change = (chance.uniform(-2.0, 2.0) for _ in range(2))
    reference = UP._replace(velocity=tuple(v), acceleration=tuple(a), push=(1.0, 2.0))
    slowed = SphericalJoint.slow_down(reference, rate, change)

    def way(t):
        s = rate * t + 0.5 * change * t * t
        return np.array(v) * s + 0.5 * np.array(a) * s * s

    step = 1e-4
    speed = (way(step) - way(-step)) / (2.0 * step)
    assert slowed.velocity == pytest.approx(speed, abs=1e-6)
    assert slowed.acceleration == pytest.approx((way(step) + way(-step)) / step**2, abs=1e-5)
    assert (slowed.axis, slowed.push) == (reference.axis, reference.push)
    two = (UP._replace(axis=tuple(way(t))) for t in (-step, step))
    pace = SphericalJoint.pace_between(*two, 2.0 * step)
    assert pace == pytest.approx(np.linalg.norm(speed), abs=1e-6)


# The log ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_what_was_logged_is_recalled_as_it_was(seed):
    chance = random.Random(seed)
    camera, other = FakeCamera(), FakeCamera()
    bench, again = JointBench(camera=camera), JointBench(camera=other)
    bench.lean(chance.uniform(0.0, 0.9 * TILT), chance.uniform(-3.0, 3.0))
    bench.regulators.reads = tuple([chance.uniform(50e3, 300e3) for _ in CHANNELS])
    if seed:
        marker = tuple([chance.uniform(-0.05, 0.05) for _ in range(3)])
        camera.sees = Markers((0,), (marker,), (0.25,) if seed % 2 else ())
        camera.t = 6.875
    bench.refresh(7.0 - 0.25 * PERIOD)
    state = bench.joint.read(7.0)
    row = bench.joint.row(state, UP, EASY, EASY)
    logged = dict(zip([column.name for column in bench.joint.columns], row, strict=True))
    again.stop.pressed = True  # of another day: it is not asked
    recalled = again.joint.recall({**logged, "clock": 7.0})
    assert recalled == state
    shown = (0.25, 1.0) if seed % 2 else (0.0, 0.0)
    assert (logged["reading.twist"], logged["reading.twist_shown"]) == shown
    assert logged["reading.marker_time"] == (camera.t if seed else 0.0)
    again.joint.check(recalled, 7.0)
    assert again.joint.row(recalled, UP, EASY, EASY) == row


def test_without_a_controller_nothing_is_wanted_but_where_the_rods_are():
    bench = JointBench()
    bench.lean(0.3, 1.0)
    state = bench.cycles(1)
    row = bench.joint.row(state, UP, EASY, EASY)
    named = dict(zip([column.name for column in bench.joint.columns], row, strict=True))
    assert [named[f"reference.rod_{name}"] for name in CHANNELS] == list(state.rods)
    assert [named[f"estimate.marker_{axis}"] for axis in "xyz"] == [0.0] * 3
    assert len(row) == len(bench.joint.columns)


def test_a_margin_of_nothing_is_left_on_the_least_tension():
    settings = joint_settings()
    bench = JointBench(settings)
    bench.regulators.reads = (BASE, BASE, 5.0 / settings.area, BASE)
    state = bench.cycles(4)
    margin = bench.joint.worst_margin(state, (0.0,) * 4, bench.now)
    assert (margin.name, margin.fraction) == ("slack wire", pytest.approx(0.0, abs=TINY))
