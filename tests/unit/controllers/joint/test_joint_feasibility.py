"""What a joint refuses before it moves, and the dimensions that it refuses at all."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from joint_axes import axes

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.feasibility import (
    FeasibilityCheck,
    InfeasiblePose,
    JointBounds,
    antipode_tilt,
    calculability_angle,
    free_wire_tilt,
    refuse,
)
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import axis_from_tilt, natural_rotation

GEOMETRY = SphericalJointGeometry()


def leaning(degrees, azimuth=0.0):
    return axis_from_tilt(math.radians(degrees), azimuth)


def found(axis, geometry=GEOMETRY, wire="exact", pose="natural", **bounds):
    check = FeasibilityCheck(geometry, JointBounds(**bounds), wire, pose)
    return {finding.check: finding for finding in check.check_pose(axis)}


def test_dimensions_of_the_paper():
    assert GEOMETRY.ring_height == pytest.approx(15e-3)
    assert math.degrees(GEOMETRY.ring_half_angle) == pytest.approx(53.13, abs=0.005)
    assert GEOMETRY.marker_height * math.sin(math.radians(20)) == pytest.approx(18e-3, abs=1e-6)
    for anchor in GEOMETRY.anchors:
        assert math.hypot(*anchor) == pytest.approx(GEOMETRY.ball_radius, rel=1e-15)
    assert GEOMETRY.anchors[0] == pytest.approx((0.0, 20e-3, 15e-3))
    assert GEOMETRY.adjust_points[1] == pytest.approx((-25e-3, 0.0, -25e-3))
    assert GEOMETRY.marker((0.6, 0.0, 0.8)) == pytest.approx((31.5768e-3, 0.0, 42.1024e-3))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ring_radius": 25e-3}, "anchors lie on the ball"),
        ({"adjust_radius": 10e-3, "adjust_depth": 15e-3}, "lie inside the ball"),
        ({"marker_height": 14e-3}, "above the ring"),
        ({"anchor_angles": (1.57, 2.9, 4.71, 6.28)}, "wires 4 and 2 are a pair"),
        ({"anchor_angles": (0.2, 3.14, 3.34, 6.28)}, "across each other"),
    ],
)
def test_impossible_dimensions_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(GEOMETRY, **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"extension": (0.03, 0.06)}, "home_extension"),
        ({"least_tension": 95.0}, "least_tension"),
    ],
)
def test_impossible_bounds_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        JointBounds(**change)


@pytest.mark.parametrize(
    ("ring", "leaves", "antipode"),
    [(18.0, 43.9, 91.1), (20.0, 36.9, 98.1), (22.0, 28.4, 106.6), (23.5, 19.9, 115.1)],
)
def test_tilts_at_which_wires_leave_or_flip(ring, leaves, antipode):
    geometry = replace(GEOMETRY, ring_radius=ring * 1e-3)
    assert math.degrees(free_wire_tilt(geometry)) == pytest.approx(leaves, abs=0.06)
    assert math.degrees(antipode_tilt(geometry)) == pytest.approx(antipode, abs=0.06)


def test_a_wire_leaves_the_ball_where_it_is_said_to():
    wires = ExactWires(GEOMETRY)
    tilt = free_wire_tilt(GEOMETRY)
    before, after = (
        wires.wound_angles(natural_rotation(axis_from_tilt(tilt + d, 0.0)))[3]
        for d in (-1e-6, 1e-6)
    )
    assert before > 0.0 > after


def test_eq_17_is_the_general_limit_at_90_degrees():
    """The paper's condition, upsilon > 45 degrees, says r_ri > r_c / sqrt 2, as does the limit."""
    assert math.degrees(calculability_angle(GEOMETRY)) == pytest.approx(48.37, abs=0.005)
    edge = 25e-3 * math.sqrt(0.5)
    for ring, allowed in ((edge * 0.999, False), (edge * 1.001, True)):
        geometry = replace(GEOMETRY, ring_radius=ring)
        assert (calculability_angle(geometry) > 0.25 * math.pi) == allowed
        assert (antipode_tilt(geometry) > 0.5 * math.pi) == allowed


def test_geometry_that_cannot_reach_its_greatest_tilt_is_refused_with_eq_17():
    geometry = replace(GEOMETRY, ring_radius=17e-3)
    check = FeasibilityCheck(geometry, JointBounds(max_tilt=math.radians(90.0)))
    (finding,) = check.check_geometry()
    assert finding.bound == pytest.approx(antipode_tilt(geometry))
    assert "Eq. (17)" in finding.message
    assert not FeasibilityCheck(geometry, JointBounds()).check_geometry()


def test_general_limit_holds_where_eq_17_does_not_speak():
    geometry = replace(GEOMETRY, ring_radius=14e-3, adjust_radius=21e-3, adjust_depth=40e-3)
    (finding,) = FeasibilityCheck(geometry, JointBounds(max_tilt=1.1)).check_geometry()
    assert "Eq. (17)" not in finding.message
    assert math.degrees(finding.bound) == pytest.approx(61.7, abs=0.1)


@given(axes(most=60.0))
def test_the_default_joint_takes_60_degrees(axis):
    assert not found(axis)


def test_tilt_beyond_the_limit_names_number_and_pose():
    finding = found(leaning(61.0, 0.5))["tilt"]
    assert finding.value == pytest.approx(math.radians(61.0))
    assert finding.message.startswith("at 61.00 deg tilt towards 28.6 deg")
    assert "max_tilt is 60.00 deg" in finding.message


def test_antipode_is_refused_before_anything_else():
    assert list(found(leaning(99.0))) == ["antipode"]
    assert "98.13 deg" in found(leaning(99.0))["antipode"].message


def test_stroke_is_refused_with_the_rods_number():
    finding = found(leaning(40.0), extension=(10e-3, 45e-3))["stroke"]
    assert finding.value == pytest.approx(30e-3 + 25e-3 * math.radians(40.0))
    assert finding.bound == 45e-3
    assert "rod 2 would extend to 47.45 mm, beyond 45.00 mm" in finding.message
    assert "rod 4" in found(leaning(50.0), extension=(11e-3, 59e-3))["stroke"].message


def test_free_wire_is_refused_only_if_the_profile_says_so():
    assert "wire-free" not in found(leaning(40.0))
    finding = found(leaning(40.0), free_wires=False)["wire-free"]
    assert "wire 4 leaves the ball" in finding.message
    assert "36.87 deg" in finding.message
    assert "wire-free" not in found(leaning(36.0), free_wires=False)


def test_slack_wire_is_refused():
    assert "wire 4" in found(leaning(76.0), max_tilt=1.5)["slack"].message


def test_the_papers_poses_are_judged_where_the_ring_goes_and_not_where_it_cannot_stay():
    """No four taut wires hold the ring spun by R_Y R_X, but nothing makes it spin either."""
    assert not found(leaning(20.0, 0.8), pose="paper")


def test_tension_that_keeps_all_wires_taut_but_is_too_much_is_refused():
    finding = found(leaning(72.0, 0.2), max_tilt=1.4, least_tension=5.0, most_tension=80.0)[
        "tension"
    ]
    assert finding.value > 80.0
    assert "most_tension is 80 N" in finding.message


def test_ring_that_leaves_its_seat_is_refused():
    geometry = replace(GEOMETRY, ring_radius=23.5e-3)
    assert "seat" in found(leaning(75.0), geometry, max_tilt=1.5)
    assert "seat" not in found(leaning(75.0), geometry, max_tilt=1.5, seat_margin=-math.pi)
    assert "seat" in found(leaning(70.0), geometry, max_tilt=1.5, seat_margin=math.radians(12.0))


def test_pose_is_refused_with_the_first_finding():
    check = FeasibilityCheck(GEOMETRY, JointBounds(extension=(12e-3, 48e-3)))
    findings = check.check_pose(leaning(65.0))
    assert {finding.check for finding in findings} == {"tilt", "stroke"}
    with pytest.raises(InfeasiblePose, match=r"at 65\.00 deg"):
        refuse(findings)
    refuse([])
