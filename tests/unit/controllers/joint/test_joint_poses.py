import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_axes import angular_velocity, around, axes, axis_from_paper_angles, spin_rate, twisted

from controllers.spherical_joint.poses import (
    ROTATIONS,
    axis_from_tilt,
    azimuth_of,
    move_axis,
    natural_rotation,
    paper_rotation,
    rotate,
    tilt_of,
    twist_of,
)

both = pytest.mark.parametrize("convention", ["natural", "paper"])


def turn(axis, angle):
    """Return the matrix of a rotation, by Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


@both
@given(axis=axes(most=89.0))
def test_rotation_is_one_and_has_its_axis(convention, axis):
    rotation = np.array(ROTATIONS[convention](axis))
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-14)
    assert rotation[:, 2] == pytest.approx(axis, abs=1e-15)


@given(st.floats(0.01, 3.1), st.floats(-math.pi, math.pi))
def test_natural_rotation_turns_about_a_horizontal_axis(tilt, azimuth):
    horizontal = (-math.sin(azimuth), math.cos(azimuth), 0.0)
    assert np.allclose(
        natural_rotation(axis_from_tilt(tilt, azimuth)), turn(horizontal, tilt), atol=1e-11
    )


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_paper_rotation_is_y_after_x(theta, phi):
    expected = turn((0, 1, 0), theta) @ turn((1, 0, 0), phi)
    axis = axis_from_paper_angles(theta, phi)
    assert axis == pytest.approx(expected[:, 2], abs=1e-15)
    assert np.allclose(paper_rotation(axis), expected, atol=1e-13)


def test_paper_rotation_of_an_axis_along_y_does_not_turn_about_y():
    assert np.allclose(paper_rotation((0.0, 1.0, 0.0)), turn((1, 0, 0), -0.5 * math.pi))


def test_straight_down_has_no_natural_rotation():
    with pytest.raises(ValueError, match="straight down"):
        natural_rotation((0.0, 0.0, -1.0))


@given(st.floats(0.01, 3.0), st.floats(-3.1, 3.1))
def test_tilt_and_azimuth_round_trip(tilt, azimuth):
    axis = axis_from_tilt(tilt, azimuth)
    assert tilt_of(axis) == pytest.approx(tilt, abs=1e-12)
    assert azimuth_of(axis) == pytest.approx(azimuth, abs=1e-10)


@pytest.mark.parametrize(("tilt", "twist"), [(20, 1.8), (30, 4.1), (40, 7.6), (60, 19.5)])
def test_paper_pose_spins_the_ring(tilt, twist):
    found = max(abs(twist_of(paper_rotation(axis))) for axis in around(tilt))
    assert math.degrees(found) == pytest.approx(twist, abs=0.06)


@given(axes(most=80.0), st.floats(-1.0, 1.0))
def test_twist_is_the_spin_about_the_own_axis(axis, twist):
    rotation = twisted(natural_rotation(axis), twist)
    assert twist_of(rotation) == pytest.approx(twist, abs=1e-12)
    assert np.allclose(rotation, turn(axis, twist) @ np.array(natural_rotation(axis)), atol=1e-12)


def test_the_papers_angles_of_a_circle_draw_none():
    """theta = 20° cos t, phi = -20° sin t leaves the radius by 0.09 of 18 mm."""
    lean = math.radians(20.0)
    radii = [
        18e-3
        / math.sin(lean)
        * math.hypot(*axis_from_paper_angles(lean * math.cos(t), -lean * math.sin(t))[:2])
        for t in np.linspace(0, 2 * math.pi, 721)
    ]
    assert min(radii) == pytest.approx(17.911e-3, abs=1e-6)
    assert max(radii) == pytest.approx(18.0e-3, abs=1e-6)


@both
@given(axis=axes(most=75.0), heading=st.floats(-math.pi, math.pi))
def test_angular_velocity_against_finite_differences(convention, axis, heading):
    rotation_of, step = ROTATIONS[convention], 1e-5
    x, y, _ = natural_rotation(axis)
    tangent = rotate((x, y, natural_rotation(axis)[2]), (math.cos(heading), math.sin(heading), 0))
    ahead = np.array(rotation_of(move_axis(axis, tangent, (0, 0, 0), step)))
    back = np.array(rotation_of(move_axis(axis, tangent, (0, 0, 0), -step)))
    skew = (ahead - back) / (2 * step) @ np.array(rotation_of(axis)).T
    expected = (skew[2, 1], skew[0, 2], skew[1, 0])
    omega = angular_velocity(convention, axis, tangent)
    assert omega == pytest.approx(expected, abs=1e-8)
    assert spin_rate(convention, axis, tangent) == pytest.approx(np.dot(expected, axis), abs=1e-8)


def test_move_axis_follows_constant_acceleration():
    rate, t = 0.7, 0.3
    axis = (math.sin(rate * t), 0.0, math.cos(rate * t))
    velocity = (rate * math.cos(rate * t), 0.0, -rate * math.sin(rate * t))
    acceleration = (-rate * rate * axis[0], 0.0, -rate * rate * axis[2])
    later = (math.sin(rate * (t + 1e-3)), 0.0, math.cos(rate * (t + 1e-3)))
    assert move_axis(axis, velocity, acceleration, 1e-3) == pytest.approx(later, abs=1e-10)
