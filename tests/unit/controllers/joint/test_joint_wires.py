"""The wires' lengths: the paper's against its equations, the exact ones against pulled strings."""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_axes import angular_velocity, around, axes, twisted
from string_shortening import shortest_strings

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.paper_wire import PaperWires, paper_wire_length
from controllers.spherical_joint.poses import (
    ROTATIONS,
    axis_from_tilt,
    move_axis,
    natural_rotation,
    paper_rotation,
    rotate,
    twist_of,
)
from controllers.spherical_joint.wires import InverseKinematics

GEOMETRY = SphericalJointGeometry()
EXACT, PAPER = ExactWires(GEOMETRY), PaperWires(GEOMETRY)


# ------------------------------------------------------------------------------ the paper's wire


def straightforward_paper_length(anchor, adjust, radius):
    """Evaluate eq. (7)-(13) with vectors; the arc is eq. (10)'s, without its arc cosine.

    As printed it loses half of its digits where the arc is short, at anchors on the equator.
    """
    a, b = np.asarray(anchor), np.asarray(adjust)
    if a[2] < 0.0:
        return np.linalg.norm(b - a)
    d = a + (b - a) * a[2] / (a[2] - b[2])
    c = radius * d / np.linalg.norm(d)
    arc = radius * np.arctan2(np.linalg.norm(np.cross(a, c)), np.dot(a, c))
    if arc > 0.1 * radius:
        printed = radius * np.arccos(1.0 - np.dot(a - c, a - c) / (2.0 * radius**2))
        assert arc == pytest.approx(printed, abs=1e-12)
    return arc + np.linalg.norm(b - c)


@given(axes(most=89.0), st.sampled_from(["natural", "paper"]))
def test_paper_wire_is_what_its_equations_say(axis, pose):
    rotation = ROTATIONS[pose](axis)
    for length, home, adjust in zip(
        PAPER.lengths(rotation), GEOMETRY.anchors, GEOMETRY.adjust_points, strict=True
    ):
        anchor = rotate(rotation, home)
        expected = straightforward_paper_length(anchor, adjust, GEOMETRY.ball_radius)
        assert length == pytest.approx(expected, abs=1e-12)


def test_paper_wire_has_the_lengths_of_home():
    home = GEOMETRY.ball_radius * (1.0 + 0.5 * math.pi - GEOMETRY.ring_half_angle)
    assert home == pytest.approx(41.0875e-3, abs=5e-8)
    for wires in (PAPER, EXACT):
        assert wires.lengths(natural_rotation((0.0, 0.0, 1.0))) == pytest.approx([home] * 4)


def test_paper_wire_that_crosses_the_balls_axis_is_refused():
    with pytest.raises(ValueError, match="through the ball's axis"):
        paper_wire_length((-25e-3, 0.0, 25e-3), (25e-3, 0.0, -25e-3), 25e-3)
    flat = replace(GEOMETRY, ring_radius=math.sqrt(0.5) * 25e-3)
    down = natural_rotation(axis_from_tilt(0.5 * math.pi, math.pi))
    with pytest.raises(ValueError, match="wire 4: the line from anchor"):
        PaperWires(flat).lengths(down)


def test_paper_wire_is_straight_below_the_equator():
    """An arc to the equator would run backwards: 2.7 mm at 40 degrees, 20 mm at 60."""
    for tilt, backwards in ((40.0, 2.7e-3), (60.0, 20e-3)):
        anchor = rotate(
            natural_rotation(axis_from_tilt(math.radians(tilt), 0.0)), GEOMETRY.anchors[3]
        )
        adjust = GEOMETRY.adjust_points[3]
        length = paper_wire_length(anchor, adjust, GEOMETRY.ball_radius)
        assert length == pytest.approx(math.dist(anchor, adjust), abs=1e-15)
        below = GEOMETRY.ball_radius * math.asin(-anchor[2] / GEOMETRY.ball_radius)
        assert below + GEOMETRY.ball_radius - length == pytest.approx(backwards, rel=0.2)


# ------------------------------------------------------------------------- paper against exact


@lru_cache
def paper_error(tilt, pose):
    """Return the greatest error of the paper's path round a circle, per wire, m."""
    errors = []
    for axis in around(tilt, step=1):
        rotation = ROTATIONS[pose](axis)
        errors.append(np.subtract(EXACT.lengths(rotation), PAPER.lengths(rotation)))
    return np.abs(errors).max(axis=0)


@pytest.mark.parametrize(
    ("tilt", "odd", "even", "natural"),
    [
        (20, 0.01, 0.01, 0.01),
        (30, 0.14, 0.06, 0.08),
        (40, 1.2, 0.4, 0.5),
        (50, 7.5, 2.3, 2.1),
        (60, 37, 7.9, 7.6),
        (70, 169, 14, 24),
        (80, 743, 19, 75),
    ],
)
def test_error_of_the_papers_path(tilt, odd, even, natural):
    """In µm, with the number of digits that is given."""

    def agrees(error, expected):
        return error * 1e6 == pytest.approx(expected, rel=0.06, abs=4.5e-3)

    first, second, third, fourth = paper_error(tilt, "paper")
    assert agrees(first, odd)
    assert agrees(third, odd)
    assert agrees(second, even)
    assert agrees(fourth, even)
    assert agrees(paper_error(tilt, "natural").max(), natural)


@given(axes(most=69.0))
def test_paper_path_is_never_too_long(axis):
    rotation = paper_rotation(axis)
    for exact, paper in zip(EXACT.lengths(rotation), PAPER.lengths(rotation), strict=True):
        assert paper <= exact + 1e-15


@pytest.mark.parametrize("tilt", [5, 20, 36, 60])
def test_paper_path_of_a_wire_in_a_vertical_plane_is_exact(tilt):
    rotation = natural_rotation(axis_from_tilt(math.radians(tilt), 0.0))
    for wire in (1, 3):
        assert PAPER.lengths(rotation)[wire] == pytest.approx(
            EXACT.lengths(rotation)[wire], abs=1e-15
        )


# ------------------------------------------------------------------------------ the exact wire


def test_exact_wires_against_string_shortening():
    generator = np.random.default_rng(3)
    starts, ends, lengths = [], [], []
    for _ in range(6):
        geometry = replace(
            GEOMETRY,
            ring_radius=generator.uniform(18e-3, 24e-3),
            adjust_radius=generator.uniform(20e-3, 32e-3),
            adjust_depth=generator.uniform(20e-3, 32e-3),
        )
        tilt, azimuth, twist = generator.uniform((0.0, -np.pi, -0.3), (1.1, np.pi, 0.3))
        rotation = twisted(natural_rotation(axis_from_tilt(tilt, azimuth)), twist)
        starts += [rotate(rotation, anchor) for anchor in geometry.anchors]
        ends += geometry.adjust_points
        lengths += ExactWires(geometry).lengths(rotation)
    pulled = shortest_strings(starts, ends, GEOMETRY.ball_radius)
    assert pulled == pytest.approx(lengths, rel=1e-6)
    assert (pulled < np.array(lengths) * (1.0 + 1e-9)).all()
    free = [
        a == pytest.approx(math.dist(b, c)) for a, b, c in zip(lengths, starts, ends, strict=True)
    ]
    assert 2 <= sum(free) <= 20


def test_exact_wires_against_mujocos_wrapped_tendons():
    mujoco = pytest.importorskip("mujoco")
    # MuJoCo does not wrap a site on the very surface: a ball smaller by 1e-9 changes the length
    # by as much.
    radius = GEOMETRY.ball_radius * (1.0 - 1e-9)
    sites, tendons, fixed = "", "", ""
    for number, (anchor, adjust) in enumerate(
        zip(GEOMETRY.anchors, GEOMETRY.adjust_points, strict=True)
    ):
        sites += f'<site name="a{number}" pos="{" ".join(map(repr, anchor))}"/>'
        fixed += f'<site name="b{number}" pos="{" ".join(map(repr, adjust))}"/>'
        path = f'<site site="a{number}"/><geom geom="ball"/><site site="b{number}"/>'
        tendons += f"<spatial>{path}</spatial>"
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><geom name="ball" type="sphere" size="{radius!r}"/>{fixed}
        <body><joint type="ball"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{sites}</body>
        </worldbody><tendon>{tendons}</tendon></mujoco>"""
    )
    data = mujoco.MjData(model)
    for axis in [*around(10, 40), *around(35, 40), *around(38, 40), *around(60, 25)]:
        rotation = twisted(natural_rotation(axis), 0.1)
        mujoco.mju_mat2Quat(data.qpos, np.array(rotation).ravel())
        mujoco.mj_forward(model, data)
        assert data.ten_length == pytest.approx(EXACT.lengths(rotation), rel=1e-8)
        # Its Jacobian is about the ring's own axes.
        arms = np.array(EXACT.jacobian(rotation)) @ np.array(rotation)
        assert np.reshape(data.ten_J, (4, 3)) == pytest.approx(arms, abs=1e-9)


@given(axes(most=75.0), st.floats(-0.3, 0.3))
def test_jacobian_against_finite_differences(axis, twist):
    rotation = twisted(natural_rotation(axis), twist)
    rows, step = np.array(EXACT.jacobian(rotation)), 1e-6
    for column, spin in enumerate(np.eye(3)):
        cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
        ahead, back = (
            EXACT.lengths(tuple(map(tuple, (np.eye(3) + s * step * cross) @ np.array(rotation))))
            for s in (1.0, -1.0)
        )
        assert np.subtract(ahead, back) / (2 * step) == pytest.approx(rows[:, column], abs=2e-8)


@given(axes(most=60.0))
def test_a_wound_wire_is_a_pulley_of_the_balls_radius(axis):
    rotation = natural_rotation(axis)
    for row, wound in zip(EXACT.jacobian(rotation), EXACT.wound_angles(rotation), strict=True):
        arm = math.hypot(*row)
        if wound > 0.0:
            assert arm == pytest.approx(GEOMETRY.ball_radius)
        else:
            assert arm < GEOMETRY.ball_radius * (1.0 + 1e-12)


def test_length_is_smooth_where_the_wire_leaves_the_ball():
    leave = math.pi - GEOMETRY.ring_half_angle - 0.5 * math.pi
    around_it = [leave - 2e-6, leave - 1e-6, leave + 1e-6, leave + 2e-6]
    a, b, c, d = (
        EXACT.lengths(natural_rotation(axis_from_tilt(tilt, 0.0)))[3] for tilt in around_it
    )
    assert (b - a) / 1e-6 == pytest.approx((d - c) / 1e-6, rel=1e-5)
    assert (c - b) / 2e-6 == pytest.approx((b - a) / 1e-6, rel=1e-5)


def test_wire_opposite_its_adjust_point_has_no_jacobian():
    opposite = GEOMETRY.ring_half_angle + 0.25 * math.pi
    # Ch4 is at +X: leaning to -X takes its anchor over the top.
    rotation = natural_rotation(axis_from_tilt(opposite, math.pi))
    with pytest.raises(ValueError, match="wire 4"):
        EXACT.jacobian(rotation)


@given(axes(most=60.0), st.floats(-0.2, 0.2))
def test_directions_are_how_anchors_shorten_their_wires(axis, twist):
    """Moving an anchor along its wire shortens it by as much: torque is anchor x direction."""
    rotation = twisted(natural_rotation(axis), twist)
    for direction, home, row in zip(
        EXACT.directions(rotation), GEOMETRY.anchors, EXACT.jacobian(rotation), strict=True
    ):
        assert math.hypot(*direction) == pytest.approx(1.0)
        torque = np.cross(rotate(rotation, home), direction)
        assert -torque == pytest.approx(row, abs=1e-12)


# --------------------------------------------------------------------------------- poses to wires


@pytest.mark.parametrize(("tilt", "change"), [(20, 0.13), (30, 0.49), (40, 1.25), (60, 5.0)])
def test_the_spin_of_paper_poses_changes_the_wires(tilt, change):
    natural, paper = (InverseKinematics(GEOMETRY, pose=pose) for pose in ("natural", "paper"))
    most = max(
        np.abs(np.subtract(natural.shortening(axis), paper.shortening(axis))).max()
        for axis in around(tilt, 1)
    )
    assert most * 1e3 == pytest.approx(change, rel=0.06)


@pytest.mark.parametrize(("tilt", "twist"), [(20, 0.034), (30, 0.17), (40, 0.5), (60, 2.5)])
def test_equal_tensions_hold_the_ring_near_the_natural_pose(tilt, twist):
    """Where four equal tensions have no moment about the axis, their summed length is least."""
    found = 0.0
    for axis in around(tilt, 2):
        rotation = natural_rotation(axis)

        def moment(spin, rotation=rotation, axis=axis):
            return np.sum(EXACT.jacobian(twisted(rotation, spin)), axis=0) @ np.array(axis)

        low, high = -0.2, 0.2
        assert moment(low) * moment(high) < 0.0
        for _ in range(20):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if moment(middle) * moment(low) > 0 else (low, middle)
        found = max(found, abs(twist_of(twisted(rotation, low))))
    assert math.degrees(found) == pytest.approx(twist, rel=0.05)


def test_circle_moves_every_wire_by_an_arc():
    """20 degrees on a ball of 25 mm: 8.727 mm, and a pair's sum changes by 1.29 mm."""
    inverse = InverseKinematics(GEOMETRY)
    moved = np.array([inverse.shortening(axis) for axis in around(20, 1)])
    assert moved.max(axis=0) == pytest.approx([8.727e-3] * 4, abs=1e-6)
    sums = moved[:, 0] + moved[:, 2]
    assert np.ptp(sums) == pytest.approx(1.29e-3, abs=5e-6)


@pytest.mark.parametrize("wire", ["exact", "paper"])
@pytest.mark.parametrize("pose", ["natural", "paper"])
def test_wire_motion_against_the_positions(wire, pose):
    inverse = InverseKinematics(GEOMETRY, wire, pose)
    rate, lean = 3.0, math.radians(33.0)

    def at(t):
        turn = rate * t
        x, y = math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn)
        return (
            (x, y, math.cos(lean)),
            (-rate * y, rate * x, 0.0),
            (-rate * rate * x, -rate * rate * y, 0.0),
        )

    for t in (0.0, 0.31, 0.77):
        position, velocity, acceleration = inverse.motion(*at(t))
        h = 1e-4
        back, here, ahead = (np.array(inverse.shortening(at(t + k * h)[0])) for k in (-1, 0, 1))
        assert position == pytest.approx(here, abs=1e-15)
        assert velocity == pytest.approx((ahead - back) / (2 * h), abs=1e-6)
        assert acceleration == pytest.approx((ahead - 2 * here + back) / h**2, abs=1e-5)


@given(axes(most=60.0), st.floats(-math.pi, math.pi))
def test_wire_velocity_is_jacobian_times_angular_velocity(axis, heading):
    tangent = rotate(natural_rotation(axis), (math.cos(heading), math.sin(heading), 0.0))
    for pose in ("natural", "paper"):
        rows = np.array(EXACT.jacobian(ROTATIONS[pose](axis)))
        expected = -rows @ np.array(angular_velocity(pose, axis, tangent))
        step = 1e-6
        inverse = InverseKinematics(GEOMETRY, pose=pose)
        ahead, back = (
            inverse.shortening(move_axis(axis, tangent, (0.0, 0.0, 0.0), s * step))
            for s in (1.0, -1.0)
        )
        assert np.subtract(ahead, back) / (2 * step) == pytest.approx(expected, abs=3e-8)
