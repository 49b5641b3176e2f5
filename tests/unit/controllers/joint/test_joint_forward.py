"""From wires to the pose, and what tells that they do not agree."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_axes import around, axes, twisted

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import (
    axis_from_tilt,
    natural_rotation,
    tilt_of,
)
from controllers.spherical_joint.wires import InverseKinematics

GEOMETRY = SphericalJointGeometry()
INVERSE = InverseKinematics(GEOMETRY)
HOME = ExactWires(GEOMETRY).lengths(natural_rotation((0.0, 0.0, 1.0)))


def measured(rotation):
    """Return the shortenings of a ring's rotation."""
    return tuple(np.subtract(HOME, ExactWires(GEOMETRY).lengths(rotation)).tolist())


@given(axes(most=75.0))
def test_forward_undoes_inverse_from_home(axis):
    pose = ForwardKinematics(GEOMETRY).update(INVERSE.shortening(axis))
    assert math.dist(pose.axis, axis) < 1e-10
    assert pose.residual < 1e-11


def test_forward_undoes_inverse_to_rounding_on_the_way():
    forward = ForwardKinematics(GEOMETRY)
    for k in range(400):
        axis = axis_from_tilt(math.radians(0.15 * k), 0.05 * k)
        pose = forward.update(INVERSE.shortening(axis))
        assert math.dist(pose.axis, axis) < 1e-10
    assert math.dist(forward.update(INVERSE.shortening(axis)).axis, axis) < 1e-14


@given(axes(most=60.0), st.lists(st.floats(-1e-4, 1e-4), min_size=4, max_size=4))
def test_no_other_pose_explains_the_wires_better(axis, noise):
    shortening = tuple(np.add(INVERSE.shortening(axis), noise).tolist())
    pose = ForwardKinematics(GEOMETRY).update(shortening)
    least = np.sum(np.square(pose.residuals))
    for heading in np.linspace(0.0, 2 * np.pi, 7):
        column = np.array(natural_rotation(pose.axis)) @ (math.cos(heading), math.sin(heading), 0)
        other = np.array(pose.axis) + 1e-4 * column
        other = tuple((other / np.linalg.norm(other)).tolist())
        residuals = np.subtract(shortening, INVERSE.shortening(other))
        assert np.sum(np.square(residuals)) >= least
    assert pose.residuals == pytest.approx(
        np.subtract(shortening, INVERSE.shortening(pose.axis)), abs=1e-9
    )


@pytest.mark.parametrize("wire", range(4))
def test_slack_wire_shows_in_the_residual(wire):
    shortening = list(INVERSE.shortening(axis_from_tilt(0.3, 0.4)))
    shortening[wire] += 1e-3
    pose = ForwardKinematics(GEOMETRY).update(tuple(shortening))
    # A wire shares two of the four dimensions: about half of the error stays a residual.
    assert 0.4e-3 < abs(pose.residuals[wire]) < 0.8e-3
    assert pose.residual > 0.3e-3


def test_wires_see_the_rings_twist_off_the_axes_and_hardly_even_there():
    """Half a degree moves the residual by 1 µm at 20 degrees of tilt, by 6 at 50."""
    forward = ForwardKinematics(GEOMETRY)
    twist = math.radians(0.5)

    def residual(tilt, azimuth):
        rotation = natural_rotation(axis_from_tilt(math.radians(tilt), azimuth))
        return forward.update(measured(twisted(rotation, twist))).residual

    for tilt in (20, 50):
        assert residual(tilt, 0.0) < 1e-6
    assert 0.9e-6 < residual(20, 0.8) < 2e-6
    assert 4e-6 < residual(50, 0.8) < 8e-6


@pytest.mark.parametrize(("tilt", "error"), [(20, 0.32), (40, 2.6), (60, 9.1)])
def test_marker_of_a_natural_ring_on_wires_of_a_paper_pose(tilt, error):
    forward = ForwardKinematics(GEOMETRY)
    paper = InverseKinematics(GEOMETRY, pose="paper")
    most = max(
        GEOMETRY.marker_height * math.dist(forward.update(paper.shortening(axis)).axis, axis)
        for axis in around(tilt, 3)
    )
    assert most * 1e3 == pytest.approx(error, rel=0.03)


@pytest.mark.parametrize(("tilt", "error"), [(20, 8e-6), (40, 0.0014), (60, 0.054)])
def test_marker_on_wires_of_the_papers_path(tilt, error):
    forward = ForwardKinematics(GEOMETRY)
    paper = InverseKinematics(GEOMETRY, wire="paper", pose="natural")
    most = max(
        GEOMETRY.marker_height * math.dist(forward.update(paper.shortening(axis)).axis, axis)
        for axis in around(tilt, 3)
    )
    assert most * 1e3 < 2.0 * error


def test_encoder_noise_of_10_um_moves_the_marker_by_15_to_22():
    generator = np.random.default_rng(1)
    for tilt in (20, 40, 60, 70):
        forward = ForwardKinematics(GEOMETRY)
        axis = axis_from_tilt(math.radians(tilt), 0.6)
        true = INVERSE.shortening(axis)
        moved = [
            math.dist(forward.update(tuple((true + 10e-6 * noise).tolist())).axis, axis)
            for noise in generator.standard_normal((600, 4))
        ]
        rms = GEOMETRY.marker_height * math.sqrt(np.mean(np.square(moved)))
        assert 13e-6 < rms < 24e-6


@pytest.mark.parametrize(("tilt", "condition"), [(20, 1.04), (40, 1.17), (60, 1.34), (70, 1.37)])
def test_tilt_is_well_conditioned_and_twist_is_not(tilt, condition):
    wires = ExactWires(GEOMETRY)
    worst, spin = 1.0, math.inf
    for axis in around(tilt, 5):
        rows = np.array(wires.jacobian(natural_rotation(axis))) @ np.array(natural_rotation(axis))
        singular = np.linalg.svd(rows[:, :2], compute_uv=False)
        worst = max(worst, singular[0] / singular[1])
        spin = min(spin, np.linalg.cond(rows))
    assert worst == pytest.approx(condition, abs=0.05)
    if tilt == 20:
        assert spin > 40.0


def test_forward_search_that_does_not_settle_is_refused_and_starts_again():
    forward = ForwardKinematics(GEOMETRY)
    with pytest.raises(ValueError, match=r"no pose of the ring explains .* mm"):
        forward.update((math.nan, 0.0, 0.0, 0.0))
    assert tilt_of(forward.update((0.0, 0.0, 0.0, 0.0)).axis) < 1e-12


def test_forward_reset_starts_at_home():
    forward = ForwardKinematics(GEOMETRY)
    first = forward.update(INVERSE.shortening(axis_from_tilt(0.9, 1.0)))
    forward.reset()
    assert forward.update(INVERSE.shortening(axis_from_tilt(0.9, 1.0))) == first
