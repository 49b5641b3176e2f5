"""One leg: forward and inverse kinematics, the Jacobian and what its determinant is made of."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from matrix_rays import path_ray

from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.kinematics import (
    hip_from_ankle,
    inverse,
    jacobian,
    waist_from_foot,
)
from controllers.gait.phase_curve_kernel import upright_ray
from controllers.motion import InfeasibleMotion

GEOMETRY = LegGeometry(thigh=0.105, shank=0.095)

HIP_ON_ANKLE_AXIS = math.atan2(0.095 + 0.105 * math.cos(0.5), 0.105 * math.sin(0.5))
"""Ankle pitch that lays the hip level with the ankle at a knee of 0.5 rad."""

angles = st.tuples(
    *(
        st.floats(low, high)
        for low, high in (
            (-1.0, 1.0),
            (-0.6, 0.6),
            (-1.2, 1.2),
            (0.0, 2.0),
            (-1.0, 1.0),
            (-0.4, 0.4),
        )
    )
)
vectors = st.tuples(*(st.floats(-1.0, 1.0),) * 3)
legs = st.sampled_from((0, 1))


class Factors(NamedTuple):
    """Knee (m²), height (m) and gimbal (1), whose product is the Jacobian's determinant."""

    knee: float
    height: float
    gimbal: float


def determinant_factors(q):
    """Return ``l1 l2 sin(q4)``, the hip's height above the ankle's roll axis, and ``cos(q2)``."""
    thigh, shank = GEOMETRY.thigh, GEOMETRY.shank
    height = shank * math.cos(q[4]) + thigh * math.cos(q[3] + q[4])
    return Factors(thigh * shank * math.sin(q[3]), height, math.cos(q[1]))


@settings(max_examples=50, deadline=None)
@given(angles, legs)
def test_jacobian_is_the_derivative_of_the_waist_pose(q, leg):
    J = jacobian(GEOMETRY, leg, q)
    step = 1e-6
    _, R = waist_from_foot(GEOMETRY, leg, q)
    for joint in range(6):
        poses = []
        for sign in (1, -1):
            moved = list(q)
            moved[joint] += sign * step
            poses.append(waist_from_foot(GEOMETRY, leg, tuple(moved)))
        (p_1, R_1), (p_0, R_0) = poses
        velocity = (np.array(p_1) - np.array(p_0)) / (2 * step)
        spin = (np.array(R_1) - np.array(R_0)) / (2 * step) @ np.array(R).T
        np.testing.assert_allclose(J[:3, joint], velocity, atol=1e-9)
        np.testing.assert_allclose(J[3:, joint], (spin[2, 1], spin[0, 2], spin[1, 0]), atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(angles, legs)
def test_determinant_is_the_product_of_its_factors(q, leg):
    factors = determinant_factors(q)
    with np.errstate(
        divide="ignore"
    ):  # a product under the smallest number, which numpy takes for 0
        expected = np.linalg.det(jacobian(GEOMETRY, leg, q))
    assert math.prod(factors) == pytest.approx(expected, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("q", "factor"),
    [
        ((0.1, 0.2, -0.3, 0.0, 0.2, 0.1), "knee"),
        ((0.1, math.pi / 2, -0.3, 0.5, 0.2, 0.1), "gimbal"),
        ((0.1, 0.2, -0.3, 0.5, HIP_ON_ANKLE_AXIS, 0.1), "height"),
    ],
)
def test_each_factor_vanishes_at_its_singularity(q, factor):
    assert getattr(determinant_factors(q), factor) == pytest.approx(0.0, abs=1e-15)
    singular = np.linalg.svd(jacobian(GEOMETRY, 0, q), compute_uv=False)
    assert singular[-1] < 1e-12 < 1e-4 < singular[-2]


@settings(max_examples=100, deadline=None)
@given(angles, legs)
def test_inverse_undoes_forward(q, leg):
    assume(determinant_factors(q).height > 0.01)  # below the ankle is another branch
    _, R = waist_from_foot(GEOMETRY, leg, q)
    found = inverse(GEOMETRY, hip_from_ankle(GEOMETRY, q), R)
    # 1e-16 of the squared distance is 1e-8 rad of an almost straight knee.
    np.testing.assert_allclose(found, q, atol=1e-12 if q[3] > 1e-2 else 1e-6)


def test_one_degree_of_knee_is_a_few_micrometres_of_reach():
    geometry = LegGeometry()
    assert geometry.reach - geometry.distance(math.radians(1.0)) == pytest.approx(7.6e-6, rel=0.01)
    assert geometry.reach - geometry.distance(math.radians(8.0)) == pytest.approx(0.5e-3, rel=0.03)


def test_inverse_reaches_the_straight_knee_and_no_further():
    q = inverse(GEOMETRY, (0.0, 0.0, GEOMETRY.reach))
    assert q == (0.0, -0.0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(InfeasibleMotion, match=r"200\.0100 mm from the ankle; .* 200 mm"):
        inverse(GEOMETRY, (0.0, 0.0, GEOMETRY.reach + 1e-5))


ANGLES = ((0.0, 2.0), (-1.0, 1.0), (-0.4, 0.4))
"""Of knee, ankle pitch and ankle roll, rad; LAPACK divides by what is below 2e-308."""


@settings(max_examples=100, deadline=None)
@given(*(st.floats(*at, allow_subnormal=False) for at in ANGLES), vectors, legs)
def test_upright_ray_is_the_adjugate_times_the_path(knee, ankle_pitch, ankle_roll, velocity, leg):
    q = (0.0, -ankle_roll, -knee - ankle_pitch, knee, ankle_pitch, ankle_roll)
    factors = determinant_factors(q)
    assume(factors.height > 0.01)  # below, the leg lies on the floor
    ray = path_ray(jacobian(GEOMETRY, leg, q), np.array((*velocity, 0.0, 0.0, 0.0)))
    knee_rate, pitch_rate, roll_rate, path = upright_ray(
        GEOMETRY.thigh, GEOMETRY.shank, knee, ankle_pitch, ankle_roll, *velocity
    )
    hip = (0.0, -roll_rate, -knee_rate - pitch_rate)
    scale = factors.height * factors.gimbal * GEOMETRY.thigh * GEOMETRY.shank
    short = [scale * rate for rate in (*hip, knee_rate, pitch_rate, roll_rate, path)]
    np.testing.assert_allclose((*ray.joints, ray.path), short, atol=1e-15)


def test_straight_leg_has_a_ray_where_it_has_no_inverse():
    knee, *_, path = upright_ray(GEOMETRY.thigh, GEOMETRY.shank, 0.0, 0.2, 0.1, 0.02, 0.0, -0.01)
    assert path == 0.0
    assert abs(knee) > 1e-2


def test_limits_of_the_right_leg_mirror_the_left():
    limits = dict(zip(AXIS_NAMES, LegGeometry().limits, strict=True))
    assert limits["left_hip_yaw"] == tuple(map(math.radians, (-30.0, 90.0)))
    assert limits["right_hip_yaw"] == tuple(map(math.radians, (-90.0, 30.0)))
    assert limits["right_ankle_roll"] == pytest.approx(tuple(map(math.radians, (-24.0, 24.0))))
    assert limits["right_knee"] == limits["left_knee"] == (0.0, math.radians(129.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axes": ("z", "y", "x", "y", "y", "x")}, "made for z x y y y x"),
        ({"min_angle": (0.0, 0.0, 0.0, -0.1, 0.0, 0.0)}, "bends backwards"),
        ({"min_angle": (2.0, 0.0, 0.0, 0.0, 0.0, 0.0)}, r"hip_yaw: min_angle \(114.6 deg\)"),
    ],
)
def test_impossible_geometry_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        LegGeometry(**change)


def test_masses_add_up_to_the_robot():
    masses = LegGeometry().masses
    assert masses.leg == pytest.approx(1.265)
    assert masses.total == pytest.approx(6.0)
