"""Forward, inverse and velocity kinematics against differences, matrices and MuJoCo."""

import math

import mujoco
import numpy as np
import pytest
from arm_cases import GEOMETRIES, START_FIG4, random_joints

from controllers.arm.decomposition import full_scale, joint_rates
from controllers.arm.geometry import ArmGeometry
from controllers.arm.inverse import (
    BRANCHES,
    OutOfReach,
    branch_of,
    inverse,
    reachable,
)
from controllers.arm.kinematics import (
    dimensions_of,
    forward,
    jacobian_columns,
    link_points,
    singularity_indices,
    wrist_centre,
    wrist_velocity,
)
from controllers.arm.types import Pose


def test_start_of_figure_4_is_where_the_lengths_put_it():
    arm = dimensions_of(ArmGeometry())
    pose = forward(arm, START_FIG4)
    np.testing.assert_allclose(wrist_centre(arm, START_FIG4), (0.423695, 0, 0.026941), atol=5e-7)
    axis = [row[2] for row in pose.rotation]
    np.testing.assert_allclose(axis, (0.9121, -0.3830, -0.1460), atol=5e-5)


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_jacobian_is_the_derivative_of_the_pose(geometry):
    arm, h = dimensions_of(geometry), 1e-6
    for q in random_joints(10):
        J = np.array(jacobian_columns(arm, q)).T
        rotation = np.array(forward(arm, q).rotation)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
        for j in range(6):
            step = h * np.eye(6)[j]
            ahead, behind = forward(arm, tuple(q + step)), forward(arm, tuple(q - step))
            linear = np.subtract(ahead.position, behind.position) / (2 * h)
            turning = np.subtract(ahead.rotation, behind.rotation) / (2 * h) @ rotation.T
            angular = (turning[2, 1], turning[0, 2], turning[1, 0])
            np.testing.assert_allclose(J[:, j], (*linear, *angular), atol=2e-9)


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_determinants_are_the_products_of_the_indices(geometry):
    arm = dimensions_of(geometry)
    for q in random_joints(30):
        c, s3, s5 = singularity_indices(arm, q)
        J = np.array(jacobian_columns(arm, q)).T
        assert np.linalg.det(J) == pytest.approx(-arm.a2 * arm.a3 * s3 * c * s5, abs=1e-13)
        J = np.array(jacobian_columns(arm, q, wrist_centre(arm, q))).T
        assert np.linalg.det(J[:3, :3]) == pytest.approx(arm.a2 * arm.a3 * s3 * c, abs=1e-13)


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_decomposed_inverse_is_the_inverse_of_the_matrix(geometry):
    arm, rng = dimensions_of(geometry), np.random.default_rng(2)
    for q in random_joints(100):
        if min(abs(index) for index in singularity_indices(arm, q)) < 0.03:
            continue
        twist = rng.normal(size=6)
        linear, angular = tuple(twist[:3].tolist()), tuple(twist[3:].tolist())
        rates = joint_rates(arm, q, linear, angular, full_scale(arm, q))
        J = np.array(jacobian_columns(arm, q)).T
        np.testing.assert_allclose(rates, np.linalg.solve(J, twist), rtol=1e-9, atol=1e-10)


def test_wrist_centre_moves_as_equation_1_says():
    arm, rng = dimensions_of(ArmGeometry()), np.random.default_rng(3)
    for q in random_joints(10):
        rates = rng.normal(size=6)
        v = np.array(jacobian_columns(arm, q)).T @ rates
        at_wrist = np.array(jacobian_columns(arm, q, wrist_centre(arm, q))).T @ rates
        axis = tuple(row[2] for row in forward(arm, q).rotation)
        np.testing.assert_allclose(
            wrist_velocity(arm, v[:3], v[3:], axis), at_wrist[:3], atol=1e-14
        )


def test_out_of_reach_on_all_branches_is_told_of_the_nearest():
    """Of an arm with a1 one shoulder reaches farther: what is left there is left last."""
    arm = dimensions_of(GEOMETRIES["shoulder ahead"])
    q = (0.4, 1.2, 0.2, 0.2, 0.7, 0.1)
    pose = forward(arm, q)
    out = np.array((math.cos(0.4), math.sin(0.4), 0.0))
    for step in np.linspace(0.0, 1.0, 200):  # outwards until no branch reaches it
        place = tuple((np.array(pose.position) + step * out).tolist())
        moved = pose._replace(position=place)
        beyond = {}
        for branch in BRANCHES:
            try:
                inverse(arm, moved, branch, q)
            except OutOfReach as error:
                beyond[branch] = error.beyond
        if len(beyond) == len(BRANCHES):
            break
    for branches in (BRANCHES, BRANCHES[::-1]):
        with pytest.raises(OutOfReach) as refused:
            reachable(arm, moved, branches, q)
        assert refused.value.beyond == min(beyond.values())
    assert min(beyond.values()) < 0.01 < max(beyond.values())


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_every_branch_leads_to_the_pose_and_one_is_the_arm(geometry):
    arm = dimensions_of(geometry)
    for q in random_joints(40):
        pose = forward(arm, q)
        solutions = {}
        for branch in BRANCHES:
            try:
                solutions[branch] = inverse(arm, pose, branch, q)
            except OutOfReach:  # one that leans back reaches less far
                assert arm.a1 != 0.0
                assert branch.shoulder != branch_of(arm, q).shoulder
        assert len(solutions) == 8 or (arm.a1 != 0.0 and len(solutions) == 4)
        for branch, found in solutions.items():
            there = forward(arm, found)
            np.testing.assert_allclose(there.position, pose.position, atol=1e-13)
            np.testing.assert_allclose(there.rotation, pose.rotation, atol=1e-12)
            assert branch_of(arm, found) == branch
        np.testing.assert_allclose(solutions[branch_of(arm, q)], q, atol=1e-10)


def test_a_wrist_on_the_axes_keeps_what_is_left_open():
    arm = dimensions_of(ArmGeometry())
    for q5 in (0.0, math.pi):
        q = (0.3, 0.5, 1.0, 0.4, q5, -0.9)
        found = inverse(arm, forward(arm, q), branch_of(arm, q), q)
        np.testing.assert_allclose(found, q, atol=1e-12)
    on_axis = (0.7, 0.0, 0.0, 0.2, 0.5, 0.1)
    found = inverse(arm, forward(arm, on_axis), branch_of(arm, on_axis), on_axis)
    np.testing.assert_allclose(found, on_axis, atol=2e-8)


def test_equal_links_keep_their_digits_when_folded():
    arm = dimensions_of(ArmGeometry(a2=0.4, a3=0.4))
    for gap in (1e-3, 1e-6, 1e-9):
        q = (0.2, 0.6, math.pi - gap, 0.3, 0.7, 0.1)
        v = (0.01, 0.02, -0.03)
        rates = joint_rates(arm, q, v, (0.0, 0.0, 0.0), full_scale(arm, q))
        lean = q[1] + 0.5 * q[2]
        radial = (
            math.sin(lean) * (math.cos(q[0]) * v[0] + math.sin(q[0]) * v[1]) + math.cos(lean) * v[2]
        )
        assert rates[2] == pytest.approx(-radial / (arm.a2 * math.sin(0.5 * q[2])), rel=1e-12)
        J = np.array(jacobian_columns(arm, q)).T
        np.testing.assert_allclose(J[:3] @ rates, v, rtol=1e-6)


@pytest.mark.parametrize("position", [(0.9, 0.0, 0.3), (0.001, 0.0, 0.118)])
def test_a_pose_out_of_reach_says_from_where_to_where_the_arm_reaches(position):
    arm = dimensions_of(ArmGeometry())
    upright = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(OutOfReach, match=r"reaches from 0\.01\d* m to 0\.79 m"):
        inverse(arm, Pose(position, upright), BRANCHES[0])


def test_the_void_of_an_offset_shoulder_is_out_of_reach():
    arm = dimensions_of(ArmGeometry(shoulder_offset=0.1))
    upright = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(OutOfReach, match=r"offset of 0\.1 m"):
        inverse(arm, Pose((0.05, 0.0, 0.5), upright), BRANCHES[0])


def test_an_empty_joint_range_is_refused():
    with pytest.raises(ValueError, match="position_min of q2"):
        ArmGeometry(position_min=(-3, 4, -3, -3, -3, -3))


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_mujoco_puts_the_same_arm_in_the_same_places(geometry):
    model = mujoco.MjModel.from_xml_string(mjcf(geometry))
    data = mujoco.MjData(model)
    arm = dimensions_of(geometry)
    for q in random_joints(20):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        pose = forward(arm, q)
        np.testing.assert_allclose(data.site("tool").xpos, pose.position, atol=1e-12)
        np.testing.assert_allclose(data.site("tool").xmat.reshape(3, 3), pose.rotation, atol=1e-12)
        _, _, elbow, wrist, _ = link_points(arm, q)
        np.testing.assert_allclose(data.body("forearm").xpos, elbow, atol=1e-12)
        np.testing.assert_allclose(data.body("hand").xpos, wrist, atol=1e-12)


def mjcf(geometry):
    g = geometry
    mass = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    return f"""
    <mujoco><compiler angle="radian"/><worldbody>
      <body name="column" pos="0 0 {g.base_height}">{mass}<joint name="q1" axis="0 0 1"/>
       <body name="upper" pos="{g.a1} {g.shoulder_offset} 0">{mass}<joint name="q2" axis="0 1 0"/>
        <body name="forearm" pos="0 0 {g.a2}">{mass}<joint name="q3" axis="0 1 0"/>
         <body name="hand" pos="{g.elbow_offset} 0 {g.a3}">{mass}<joint name="q4" axis="0 0 1"/>
          <body name="pitch">{mass}<joint name="q5" axis="0 {g.wrist_sign} 0"/>
           <body name="roll">{mass}<joint name="q6" axis="0 0 1"/>
            <site name="tool" pos="0 0 {g.d6}"/>
      </body></body></body></body></body></body>
    </worldbody></mujoco>"""
