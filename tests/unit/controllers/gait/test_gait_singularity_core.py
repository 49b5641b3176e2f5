"""The ray of the singularity-consistent method, for any chain."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matrix_rays import Ray, adjugate, null_ray, path_ray

from controllers.gait.geometry import LegGeometry
from controllers.gait.kinematics import jacobian
from controllers.singularity.one_path import one_rate, two_starts
from controllers.singularity.two_link import two_link_frame, two_link_parts

GEOMETRY = LegGeometry()
STRAIGHT = (0.0, -0.1, -0.2, 0.0, 0.2, 0.1)
BENT = (0.0, -0.1, -0.5, 0.7, -0.2, 0.1)


def cofactors(matrix):
    """Return the adjugate by its definition."""
    n = len(matrix)
    minors = [
        [np.linalg.det(np.delete(np.delete(matrix, i, 0), j, 1)) for j in range(n)]
        for i in range(n)
    ]
    signs = (-1.0) ** np.add.outer(range(n), range(n))
    return (signs * np.array(minors)).T


def together(one, other):
    first, second, path = one_rate(one.path, other.path)
    return Ray(np.concatenate((first * one.joints, second * other.joints)), path)


@given(
    st.floats(0.05, 1.0), st.floats(0.05, 1.0), st.floats(-3.0, 3.0), st.floats(-3.1, 3.1),
    st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.booleans(),
)  # fmt: skip
def test_two_links_have_the_ray_of_their_jacobian(first, second, lean, bend, x, z, are_alike):
    if are_alike:
        second = first
    s1, c1, s12, c12 = np.sin(lean), np.cos(lean), np.sin(lean + bend), np.cos(lean + bend)
    J = np.array(
        [
            [first * c1 + second * c12, second * c12],
            [-first * s1 - second * s12, -second * s12],
        ]
    )
    frame = two_link_frame(first, second, lean, bend)
    swing, stretch, fold = two_link_parts(first, second, frame, x, z)
    determinant = np.sin(bend)
    ray = path_ray(J, np.array((x, z)))
    scale = -first * second
    assert ray.path == pytest.approx(scale * determinant, abs=1e-15)
    np.testing.assert_allclose(
        ray.joints, (scale * (determinant * swing + stretch), scale * fold), atol=1e-14
    )


@pytest.mark.parametrize("lengths", [(0.3, 0.3), (0.3, 0.2)])
def test_straight_links_move_and_their_path_stands_still(lengths):
    frame = two_link_frame(*lengths, 0.4, 0.0)
    outwards = np.sin(0.4), np.cos(0.4)
    swing, stretch, fold = two_link_parts(*lengths, frame, *outwards)
    assert swing == pytest.approx(0.0, abs=1e-15)
    # Where they are straight, the tip stays: what one joint leans, the other folds back.
    assert sum(lengths) * stretch == pytest.approx(-lengths[1] * fold)
    assert abs(fold) > 1.0


@pytest.mark.parametrize("rank", [5, 4, 3])
def test_adjugate_is_that_of_the_cofactors_at_any_rank(rank):
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(5, rank)) @ rng.normal(size=(rank, 5))
    np.testing.assert_allclose(adjugate(matrix), cofactors(matrix), atol=1e-11)
    assert np.any(np.abs(adjugate(matrix)) > 1e-2) == (rank >= 4)


def test_adjugate_times_matrix_is_the_determinant():
    matrix = np.random.default_rng(4).normal(size=(12, 12))
    product = adjugate(matrix) @ matrix
    det = np.linalg.det(matrix)
    np.testing.assert_allclose(product, det * np.eye(12), atol=1e-11 * abs(det) * 12)


@pytest.mark.parametrize("q", [STRAIGHT, BENT])
def test_ray_and_null_vector_agree(q):
    u = np.array((0.04, 0.0, -0.01, 0.0, 0.0, 0.0))
    rows = np.repeat((5.0, 1.0), 3)  # metres to the size of radians
    J = jacobian(GEOMETRY, 0, q)
    ray = path_ray(J, u)
    null = null_ray(rows[:, None] * J, rows * u, previous=ray)
    along = np.array((*ray.joints, ray.path))
    np.testing.assert_allclose((*null.joints, null.path), along / np.linalg.norm(along), atol=1e-13)
    np.testing.assert_allclose(J @ ray.joints, u * ray.path, atol=1e-16)


def test_both_legs_share_one_path_rate():
    u = np.array((0.04, 0.0, 0.0, 0.0, 0.0, 0.0))
    J_1, J_2 = jacobian(GEOMETRY, 0, BENT), jacobian(GEOMETRY, 1, (0, 0, -0.2, 0.3, -0.1, 0))
    block = np.block([[J_1, np.zeros((6, 6))], [np.zeros((6, 6)), J_2]])
    literal = path_ray(block, np.concatenate((u, u)))
    ray = together(path_ray(J_1, u), path_ray(J_2, u))
    scale = literal.path / ray.path
    np.testing.assert_allclose(literal.joints, scale * ray.joints, rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(block @ ray.joints, np.concatenate((u, u)) * ray.path, atol=1e-13)


def test_only_the_straight_leg_moves_at_the_instant_of_touch():
    u = np.array((0.04, 0.0, -0.01, 0.0, 0.0, 0.0))
    straight = path_ray(jacobian(GEOMETRY, 0, STRAIGHT), u)
    bent = path_ray(jacobian(GEOMETRY, 1, BENT), u)
    ray = together(Ray(straight.joints, 0.0), bent).unit()
    assert ray.path == 0.0
    assert np.any(ray.joints[:6])
    assert not np.any(ray.joints[6:])


def test_literal_equation_deadlocks_where_both_legs_are_straight_and_the_null_space_does_not():
    u = np.array((0.0, 0.0, -0.1, 0.0, 0.0, 0.0))
    straight = (0.0,) * 6
    J_1, J_2 = jacobian(GEOMETRY, 0, straight), jacobian(GEOMETRY, 1, straight)
    block = np.block([[J_1, np.zeros((6, 6))], [np.zeros((6, 6)), J_2]])
    both = np.concatenate((u, u))
    assert not np.any(np.abs(path_ray(block, both).joints) > 1e-20)
    squat = np.array((0, 0, -1, 2, -1, 0) * 2, float)
    rows = np.tile(np.repeat((5.0, 1.0), 3), 2)
    ray = null_ray(rows[:, None] * block, rows * both, previous=Ray(squat, 0.0))
    assert abs(ray.path) < 1e-12
    np.testing.assert_allclose(ray.joints, squat / np.linalg.norm(squat), atol=1e-12)


def test_two_singular_chains_start_at_the_rates_that_keep_them_together():
    # Chains whose determinants grow 4 : 1 along their rays: det_k = g_k s_k t and s_k / det_k must
    # agree, so s_1² g_1 = s_2² g_2.
    assert two_starts(4.0, 1.0) == pytest.approx((0.5, 1.0))
    assert two_starts(-1.0, 9.0) == pytest.approx((1.0, 1.0 / 3.0))


def test_two_singular_chains_have_no_common_ray():
    assert one_rate(0.0, 0.0) == (0.0, 0.0, 0.0)


def test_unit_ray_has_joint_rates_of_norm_one():
    ray = Ray(np.array((3.0, -4.0, 0.0)), 0.5).unit()
    assert np.linalg.norm(ray.joints) == pytest.approx(1.0)
    assert ray.path == pytest.approx(0.1)
    still = Ray(np.zeros(3), 0.5)
    assert still.unit() is still
