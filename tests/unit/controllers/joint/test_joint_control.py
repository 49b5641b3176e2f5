"""What all pose controllers have in common."""

import math
from dataclasses import replace

import numpy as np
import pytest
from ball_sliding import BallFriction
from pose_bench import (
    BASE,
    MODEL,
    PERIOD,
    build,
    circle,
    every,
    pressures_at,
    resting,
    rods_at,
)

from controllers.cylinder.types import PairReference, PairState
from controllers.spherical_joint.camera_loop import CameraLoopSettings
from controllers.spherical_joint.laws import (
    JointCascade,
)
from controllers.spherical_joint.pose_control import JointLearningSettings
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import (
    CameraSample,
    JointState,
    Lap,
)
from controllers.spherical_joint.wires import InverseKinematics


def wander(count):
    """Return states and references of some motion, and no more meaning than that."""
    for k in range(count):
        t = k * PERIOD
        reference = circle(t)
        rods = tuple(rod - 1e-4 for rod in rods_at(reference.axis))
        yield (
            JointState(t, rods, (0.13e6, 0.11e6, 0.12e6 + 1e4 * math.sin(9 * t), 0.1e6)),
            reference,
        )


@every
def test_joint_controller_gives_the_same_commands_for_the_same_inputs(kind):
    start = JointState(0.0, rods_at(circle(0.0).axis), BASE)
    first, second = build(kind), build(kind)
    for controller in (first, second):
        controller.reset(start)
    assert [first.update(*step) for step in wander(200)] == [
        second.update(*step) for step in wander(200)
    ]


@every
def test_joint_controller_forgets_everything_on_reset(kind):
    used, fresh = build(kind), build(kind)
    for step in wander(200):
        used.update(*step)
    start = JointState(0.0, rods_at(circle(0.0).axis), BASE)
    for controller in (used, fresh):
        controller.reset(start)
    assert [used.update(*step) for step in wander(50)] == [
        fresh.update(*step) for step in wander(50)
    ]


@every
def test_joint_starts_bumplessly(kind):
    controller = build(kind, dither=kind.Settings().dither)
    pressures = (130e3, 105e3, 110e3, 125e3)
    axis = axis_from_tilt(0.2, 0.4)
    state = JointState(0.0, rods_at(axis), pressures)
    controller.reset(state)
    command = controller.update(state, resting(axis))
    assert command == pytest.approx(pressures, abs=600.0)


@every
def test_a_ring_where_it_should_be_gets_the_pressures_that_hold_it(kind):
    """After the start-up the differentials stay as measured, the means are what keeps all taut."""
    axis = axis_from_tilt(math.radians(30.0), 0.5)
    pressures = pressures_at(axis)
    controller = build(kind)
    state = JointState(0.0, rods_at(axis, pressures), pressures)
    controller.reset(state)
    for _ in range(1500):
        command = controller.update(state, resting(axis))
    assert command == pytest.approx(pressures, rel=0.02)


@every
def test_pull_goes_towards_the_reference(kind):
    """A reference towards +X asks more of ch4, at +X, than of ch2; ch1 and ch3 stay as they are."""
    controller = build(kind)
    home = (0.0, 0.0, 1.0)
    state = JointState(0.0, rods_at(home), BASE)
    controller.reset(state)
    controller.update(state, resting(home))
    for _ in range(60):
        command = controller.update(state, resting(axis_from_tilt(5e-3, 0.0)))
    assert command.ch4 - command.ch2 > 1e3
    assert abs(command.ch1 - command.ch3) < 0.2 * (command.ch4 - command.ch2)


@every
def test_no_setpoint_lets_a_wire_go_slack_or_pulls_too_hard(kind):
    controller = build(kind)
    state = JointState(0.0, rods_at((0.0, 0.0, 1.0)), BASE)
    controller.reset(state)
    seal = 0.5 * MODEL.breakaway
    lowest, highest = math.inf, 0.0
    for k in range(400):
        # A ring that does not follow: all laws end up at their limits.
        command = controller.update(state, circle(k * PERIOD, tilt=40.0, rate=8.0))
        lowest, highest = min(lowest, *command), max(highest, *command)
    assert MODEL.area * lowest - seal >= MODEL.least_tension - 1e-6
    assert MODEL.area * highest + seal <= MODEL.most_tension + 1e-6
    assert highest - lowest > 50e3


def test_wanted_rods_are_the_inverse_kinematics_and_the_stretch():
    controller = build(JointCascade, ball_friction=0.0)
    axis = axis_from_tilt(0.3, 1.1)
    pressures = pressures_at(axis)
    state = JointState(0.0, rods_at(axis, pressures), pressures)
    controller.reset(state)
    controller.update(state, resting(axis))
    assert controller.estimate.rods == pytest.approx(state.rods, abs=1e-8)
    assert controller.estimate.marker == pytest.approx(MODEL.geometry.marker(axis), abs=1e-7)
    assert controller.estimate.residual < 1e-7
    assert controller.estimate.tensions == pytest.approx(
        [MODEL.area * pressure for pressure in pressures], rel=1e-9
    )


@pytest.mark.parametrize("wire", ["exact", "paper"])
@pytest.mark.parametrize("pose", ["natural", "paper"])
def test_wire_and_pose_are_selectable(wire, pose):
    controller = build(JointCascade, wire=wire, pose=pose, stretch=0.0)
    reference = circle(0.3, tilt=40.0)
    state = JointState(0.0, rods_at(reference.axis), BASE)
    controller.reset(state)
    controller.update(state, reference)
    expected = InverseKinematics(MODEL.geometry, wire, pose).shortening(reference.axis)
    assert controller.estimate.rods == pytest.approx(expected, abs=1e-12)


def test_camera_loop_moves_the_reference_by_what_the_camera_sees():
    """Where the camera sees the marker 0.2 mm short of +X, the rods are sent as much further."""
    axis, offset = axis_from_tilt(0.35, 0.0), 0.2e-3
    short = np.subtract(MODEL.geometry.marker(axis), (offset, 0.0, 0.0))
    controller = build(
        JointCascade, camera=CameraLoopSettings(gain=1.0, bandwidth=50.0), ball_friction=0.0
    )
    pressures = pressures_at(axis)
    rods = rods_at(axis, pressures)
    controller.reset(JointState(0.0, rods, pressures))
    for k in range(400):
        t = k * PERIOD
        sample = CameraSample(tuple(short.tolist()), t - t % 0.016)
        controller.update(JointState(t, rods, pressures, sample), resting(axis))
    plain = build(JointCascade, ball_friction=0.0)
    plain.reset(JointState(0.0, rods, pressures))
    plain.update(JointState(0.0, rods, pressures), resting(axis))
    moved = np.subtract(controller.estimate.rods, plain.estimate.rods)
    geometry = MODEL.geometry
    beyond = np.array(axis) + np.array((offset, 0.0, 0.0)) / geometry.marker_height
    beyond = tuple((beyond / np.linalg.norm(beyond)).tolist())
    inverse = InverseKinematics(geometry)
    expected = np.subtract(inverse.shortening(beyond), inverse.shortening(axis))
    assert moved == pytest.approx(expected, abs=2e-6)


def test_camera_that_disagrees_by_more_than_the_limit_is_followed_to_the_limit():
    axis, geometry, limit = axis_from_tilt(0.35, 0.0), MODEL.geometry, 1e-3
    far = CameraSample(tuple(np.subtract(geometry.marker(axis), (0.0, 8e-3, 0.0)).tolist()), 1e-4)
    camera = CameraLoopSettings(gain=1.0, bandwidth=100.0, limit=limit)
    controller = build(JointCascade, camera=camera, ball_friction=0.0)
    pressures = pressures_at(axis)
    rods = rods_at(axis, pressures)
    controller.reset(JointState(0.0, rods, pressures))
    for k in range(200):
        controller.update(JointState(k * PERIOD, rods, pressures, far), resting(axis))
    beyond = np.array(axis) + np.array((0.0, limit, 0.0)) / geometry.marker_height
    beyond = tuple((beyond / np.linalg.norm(beyond)).tolist())
    assert controller.estimate.rods == pytest.approx(rods_at(beyond, pressures), abs=20e-6)
    assert "bias" in controller.marker.alarms


def test_learning_adds_what_the_last_lap_needed():
    axis = axis_from_tilt(0.3, 0.7)
    pressures = pressures_at(axis)
    away = (-3e-5, 0.0, 3e-5, 0.0)
    rods = tuple(rod + d for rod, d in zip(rods_at(axis, pressures), away, strict=True))
    state = JointState(0.0, rods, pressures)
    controllers = build(JointCascade, learning=JointLearningSettings()), build(JointCascade)
    for controller in controllers:
        controller.reset(state)
    for lap in range(2):
        for tick in range(300):
            reference = resting(axis)._replace(lap=Lap(lap, tick, 300))
            learnt, plain = (controller.update(state, reference) for controller in controllers)
            if lap == 0:
                assert learnt == plain
    assert len(controllers[0].learning.scores) == 1
    first = (learnt.ch1 - learnt.ch3) - (plain.ch1 - plain.ch3)
    second = (learnt.ch4 - learnt.ch2) - (plain.ch4 - plain.ch2)
    assert first > 1e3
    assert abs(second) < 0.2 * first


def test_friction_of_the_ring_is_one_vector():
    friction = BallFriction(ring=0.08, wire=0.0, distance=10e-6, period=PERIOD)
    for heading in np.linspace(0.0, 6.0, 7):
        friction.reset()
        velocity = (20e-3 * math.cos(heading), 20e-3 * math.sin(heading))
        for _ in range(200):
            force = friction.update(velocity, (40.0, 45.0))
        assert force == pytest.approx(
            (0.08 * 85.0 * math.cos(heading), 0.08 * 85.0 * math.sin(heading)), rel=0.01, abs=1e-6
        )


def test_friction_of_the_wires_is_one_per_pair_and_turns_over_a_distance():
    friction = BallFriction(ring=0.0, wire=0.06, distance=10e-6, period=PERIOD)
    for _ in range(100):
        friction.update((5e-3, -5e-3), (40.0, 50.0))
    assert friction.update((5e-3, -5e-3), (40.0, 50.0)) == pytest.approx((2.4, -3.0), rel=1e-3)
    assert friction.update((0.0, 0.0), (40.0, 50.0)) == pytest.approx((2.4, -3.0), rel=1e-3)
    forces = [friction.update((-5e-3, -5e-3), (40.0, 50.0))[0] for _ in range(20)]
    assert forces == sorted(forces, reverse=True)
    assert forces[0] > 0.0 > forces[4]
    assert forces[-1] == pytest.approx(-2.4, rel=0.01)


@pytest.mark.parametrize("change", [{"base_pressure": 20e3}, {"most_tension": 20.0}])
def test_base_pressure_that_breaks_the_tension_limits_is_refused(change):
    with pytest.raises(ValueError, match="base_pressure"):
        replace(MODEL, **change)


@every
def test_a_known_load_of_a_pair_is_fed_forward_at_once(kind):
    """The law of a pair puts a load into its command; it does not count as a correction."""
    plain, loaded = (build(kind)._laws[0] for _ in range(2))
    state = PairState(0.0, 0.0, 120e3, 120e3)
    for law in (plain, loaded):
        law.reset(state)
        law.update(state, PairReference(0.0, 0.0, 0.0))
    for _ in range(3):
        without = plain.update(state, PairReference(0.0, 0.0, 0.0))
        command = loaded.update(state, PairReference(0.0, 0.0, 0.0), 2.0)
    assert command.agonist - command.antagonist > without.agonist - without.antagonist + 2.0e3
    assert loaded.correction == pytest.approx(plain.correction, abs=0.15)


@every
def test_a_push_comes_over_held_tensions_and_nothing_is_controlled(kind):
    """However far the ring is off, the pressures are those of its pose and the push."""
    controller = build(kind)
    home = (0.0, 0.0, 1.0)
    controller.reset(JointState(0.0, rods_at(home), BASE))
    off = JointState(0.0, rods_at(axis_from_tilt(0.02, 0.3)), BASE)
    goal = resting(home)._replace(push=(4.0, 0.0), base_pressure=0.16e6)
    for _ in range(50):
        command = controller.update(off, goal)
    assert command.ch1 - command.ch3 == pytest.approx(4.0 / MODEL.area, rel=1e-6)
    assert command.ch2 == pytest.approx(0.16e6, rel=1e-3)
    assert command.ch4 == pytest.approx(0.16e6, rel=1e-3)
