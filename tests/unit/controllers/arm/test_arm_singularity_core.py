"""The arm's closed form is the ray of its whole Jacobian, at the elbow's singularity as well."""

import numpy as np
import pytest
from arm_cases import GEOMETRIES, random_joints
from matrix_rays import path_ray

from controllers.arm.decomposition import Scale, joint_rates
from controllers.arm.kinematics import dimensions_of, jacobian_columns, singularity_indices

STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("is_singular", [False, True], ids=["anywhere", "straight elbow"])
@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES)
def test_decomposition_is_the_adjugate_times_the_path(geometry, is_singular):
    arm = dimensions_of(geometry)
    generator = np.random.default_rng(5)
    for joints in random_joints(20):
        elbow_at = -arm.elbow_angle if is_singular else joints[2]
        q = (*joints[:2], elbow_at, *joints[3:])
        v = tuple(generator.normal(size=3).tolist())
        J = np.array(jacobian_columns(arm, q)).T
        ray = path_ray(J, np.array((*v, *STILL)))
        shoulder, elbow, wrist = singularity_indices(arm, q)
        rates = np.array(joint_rates(arm, q, v, STILL, Scale(elbow, elbow, 1.0)))
        # The decomposition leaves out the factors of the determinant that it is not made for.
        others = -arm.a2 * arm.a3 * shoulder * wrist
        np.testing.assert_allclose(others * rates, ray.joints, atol=1e-12)
        assert ray.path == pytest.approx(others * elbow, abs=1e-13)
        assert not is_singular or abs(ray.path) < 1e-15
