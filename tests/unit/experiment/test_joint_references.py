"""Motions of the spherical joint: smooth, from rest to rest, and where the paper puts them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import axis_from_tilt, tilt_of
from rig.mechanisms.joint.references.circle import CircleTone, JointCircle
from rig.mechanisms.joint.references.poses import (
    JointPose,
    JointPoses,
)
from rig.mechanisms.joint.references.sweeps import JointSpiral, JointStiffness

TILT = math.radians(20.0)
CIRCLE = JointCircle(TILT, (CircleTone(0.1, 1), CircleTone(0.5, 2)))
POSES = JointPoses((JointPose(0.0), JointPose(0.3, 1.0), JointPose(0.5, -2.0)))
SPIRAL = JointSpiral(math.radians(60.0), turns=3, duration_out=8.0)
WIDE = JointCircle(TILT, (CircleTone(0.5, 1, math.radians(40.0)), CircleTone(0.5, 1)), laps=2)
STEP = 1e-5
MOTIONS = pytest.mark.parametrize(
    "motion", [CIRCLE, WIDE, POSES, SPIRAL], ids=["circle", "wide", "poses", "spiral"]
)


@MOTIONS
def test_velocity_and_acceleration_are_derivatives(motion):
    for t in np.linspace(0.01, motion.duration - 0.01, 701):
        before, here, after = (motion.at(t + k * STEP) for k in (-1, 0, 1))
        assert math.hypot(*here.axis) == pytest.approx(1.0, abs=1e-12)
        slope = np.subtract(after.axis, before.axis) / (2 * STEP)
        assert slope == pytest.approx(np.array(here.velocity), abs=1e-7)
        slope = np.subtract(after.velocity, before.velocity) / (2 * STEP)
        assert slope == pytest.approx(np.array(here.acceleration), abs=1e-3)


@MOTIONS
def test_motions_start_and_end_at_rest(motion):
    for t in (0.0, motion.duration):
        assert motion.at(t).velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_circle_keeps_its_tilt_and_its_speed():
    for segment, rate in zip(CIRCLE.segments[:2], (0.1, 0.5), strict=True):
        for t in np.linspace(segment.start, segment.end, 9):
            reference = CIRCLE.at(t)
            assert tilt_of(reference.axis) == pytest.approx(TILT)
            expected = math.tau * rate * math.sin(TILT)
            assert math.hypot(*reference.velocity) == pytest.approx(expected)
    names = [segment.name for segment in CIRCLE.segments]
    assert names == ["0.1 Hz", "0.5 Hz", "0.5 Hz last lap"]


def test_laps_repeat():
    (_, (start, lap, laps)) = CIRCLE.repetitions
    assert (lap, laps) == (2.0, 2)
    for t in np.linspace(0.0, lap, 7):
        assert CIRCLE.at(start + t).axis == pytest.approx(CIRCLE.at(start + lap + t).axis)


def test_circles_of_several_tilts_go_from_one_to_the_next():
    assert [segment.name for segment in WIDE.segments] == [
        "40 deg 0.5 Hz",
        "40 deg 0.5 Hz last lap",
        "20 deg 0.5 Hz",
        "20 deg 0.5 Hz last lap",
    ]
    for segment, tilt in zip(WIDE.segments, (40.0, 40.0, 20.0, 20.0), strict=True):
        for t in (segment.start, segment.end):
            assert math.degrees(tilt_of(WIDE.at(t).axis)) == pytest.approx(tilt)
    for _, lap, laps in WIDE.repetitions:
        assert (lap, laps) == (2.0, 2)


def test_a_spiral_passes_every_direction_in_every_round():
    axes = np.array([SPIRAL.at(t).axis for t in np.linspace(0.0, 8.0, 4001)])
    turned = np.unwrap(np.arctan2(axes[50:, 1], axes[50:, 0]))
    assert turned[-1] == pytest.approx(math.tau * 3)
    assert tilt_of(SPIRAL.at(8.0).axis) == pytest.approx(math.radians(60.0))
    assert tilt_of(SPIRAL.at(SPIRAL.duration).axis) == pytest.approx(0.0, abs=1e-9)


def test_pushes_come_at_rest_and_leave_the_pose_to_the_pressures():
    sweep = JointStiffness((0.1e6, 0.2e6), force=4.0, frequency=1.0, periods=3, rest=2.0)
    assert [segment.name for segment in sweep.segments] == ["100 kPa", "200 kPa"]
    for segment, pressure in zip(sweep.segments, (0.1e6, 0.2e6), strict=True):
        pushes = [sweep.at(t) for t in np.linspace(segment.start, segment.end - 1e-6, 401)]
        assert all(reference.base_pressure == pressure for reference in pushes)
        assert max(reference.push[0] for reference in pushes) == pytest.approx(4.0, rel=1e-3)
    assert sweep.at(1.0).push is None
    assert sweep.at(sweep.duration).push is None
    assert sweep.at(5.5).base_pressure == pytest.approx(0.15e6)


def test_the_circle_of_the_paper_is_nearly_a_circle():
    """The printed angles give a radius that is off by up to 0.1 mm of 18 mm."""
    height = 52.628e-3
    radii = []
    for a in np.linspace(0.0, math.tau, 100):
        theta, phi = TILT * math.cos(a), -TILT * math.sin(a)
        x, y = math.sin(theta) * math.cos(phi), -math.sin(phi)
        radii.append(height * math.hypot(x, y))
    assert max(radii) == pytest.approx(height * math.sin(TILT), abs=1e-9)
    assert min(radii) == pytest.approx(17.911e-3, abs=2e-6)


def test_dwells_are_judged_in_their_second_half():
    assert [segment.name for segment in POSES.segments] == [
        "hold 17.1887 deg at 57.2958 deg #1",
        "hold 28.6479 deg at -114.592 deg #2",
    ]
    for segment, pose in zip(POSES.segments, POSES.poses[1:], strict=True):
        for t in (segment.start, segment.end):
            assert POSES.at(t).axis == pytest.approx(pose.axis)


@given(st.floats(0, 1.2), st.floats(-3, 3), st.floats(0, 1.2), st.floats(-3, 3), st.floats(0, 1))
def test_the_way_between_two_poses_is_the_shortest(tilt, azimuth, other, across, share):
    start, end = axis_from_tilt(tilt, azimuth), axis_from_tilt(other, across)
    here = great_circle(start, end, 1.0, share).axis

    def angle(a, b):
        return math.atan2(math.hypot(*np.cross(a, b)), float(np.dot(a, b)))

    assert angle(start, here) + angle(here, end) == pytest.approx(angle(start, end), abs=1e-9)
    assert great_circle(start, end, 1.0, 0.0).axis == pytest.approx(start, abs=1e-9)
    assert great_circle(start, end, 1.0, 1.0).axis == pytest.approx(end, abs=1e-9)
