"""Motions of the spherical joint: smooth, from rest to rest, and where the paper puts them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import axis_from_tilt, tilt_of
from rig.experiment.references.joint_circle import CircleTone, JointCircle
from rig.experiment.references.joint_poses import (
    JointPose,
    JointPoses,
)

TILT = math.radians(20.0)
CIRCLE = JointCircle(TILT, (CircleTone(0.1, 1), CircleTone(0.5, 2)))
POSES = JointPoses((JointPose(0.0), JointPose(0.3, 1.0), JointPose(0.5, -2.0)))
STEP = 1e-5


@pytest.mark.parametrize("motion", [CIRCLE, POSES], ids=["circle", "poses"])
def test_velocity_and_acceleration_are_derivatives(motion):
    for t in np.linspace(0.01, motion.duration - 0.01, 701):
        before, here, after = (motion.at(t + k * STEP) for k in (-1, 0, 1))
        assert math.hypot(*here.axis) == pytest.approx(1.0, abs=1e-12)
        slope = np.subtract(after.axis, before.axis) / (2 * STEP)
        assert slope == pytest.approx(np.array(here.velocity), abs=1e-7)
        slope = np.subtract(after.velocity, before.velocity) / (2 * STEP)
        assert slope == pytest.approx(np.array(here.acceleration), abs=1e-3)


@pytest.mark.parametrize("motion", [CIRCLE, POSES], ids=["circle", "poses"])
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
