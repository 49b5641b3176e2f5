"""The legs' algebra against a rigid-body engine that knows none of it."""

import math

import mujoco
import numpy as np
import pytest

from controllers.gait.balance import link_centres
from controllers.gait.geometry import AXIS_NAMES, LEGS, LegGeometry
from controllers.gait.kinematics import jacobian, waist_from_foot
from controllers.gait.leg_postures import leg_posture
from drivers.sim.plants.legs_model import CHANNELS, build_model
from drivers.sim.plants.legs_settings import LegServoSettings

GEOMETRY = LegGeometry(thigh=0.103, shank=0.097)


@pytest.fixture(scope="module")
def model():
    return build_model(GEOMETRY, LegServoSettings(), floor_friction=0.8, timestep=1e-3)


def postures(count=20):
    rng = np.random.default_rng(11)
    low, high = np.array(GEOMETRY.limits).T
    return low + (high - low) * rng.uniform(size=(count, 12))


def posed(model, q):
    """Return the engine's data with the waist at its origin."""
    data = mujoco.MjData(model)
    data.qpos[:7] = (0, 0, 0, 1, 0, 0, 0)
    data.qpos[7:] = q
    mujoco.mj_forward(model, data)
    return data


def test_both_sides_name_the_joints_alike():
    assert CHANNELS == AXIS_NAMES


@pytest.mark.parametrize("leg", [0, 1])
def test_forward_kinematics(model, leg):
    for q in postures():
        data = posed(model, q)
        site = model.site(f"{LEGS[leg]}_sole").id
        R = data.site_xmat[site].reshape(3, 3).T
        position, rotation = waist_from_foot(GEOMETRY, leg, tuple(q[6 * leg : 6 * leg + 6]))
        np.testing.assert_allclose(rotation, R, atol=2e-15)
        np.testing.assert_allclose(position, -R @ data.site_xpos[site], atol=2e-15)
        posture = leg_posture(GEOMETRY, leg, q[None])
        np.testing.assert_allclose(posture.sole[0], data.site_xpos[site], atol=2e-15)
        knee = data.body(f"{LEGS[leg]}_shank").xpos
        np.testing.assert_allclose(posture.knee[0], knee, atol=2e-15)


@pytest.mark.parametrize("leg", [0, 1])
def test_jacobian(model, leg):
    for q in postures():
        data = posed(model, q)
        site = model.site(f"{LEGS[leg]}_sole").id
        moves, turns = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jacSite(model, data, moves, turns, site)
        mine = slice(6 + 6 * leg, 12 + 6 * leg)
        moves, turns = moves[:, mine], turns[:, mine]
        # The sole's twist seen from the waist, turned into the waist's seen from the sole.
        R = data.site_xmat[site].reshape(3, 3).T
        lever = -data.site_xpos[site]
        waist = moves + np.cross(turns.T, lever).T
        np.testing.assert_allclose(
            jacobian(GEOMETRY, leg, tuple(q[6 * leg : 6 * leg + 6])),
            -np.vstack((R @ waist, R @ turns)),
            atol=5e-15,
        )


def test_centre_of_mass(model):
    q = postures()
    links = link_centres(GEOMETRY, q, np.zeros((len(q), 3)))
    for angles, centre in zip(q, links.centre, strict=True):
        np.testing.assert_allclose(centre, posed(model, angles).subtree_com[0], atol=2e-15)
    assert math.isclose(links.masses.sum(), model.body_mass.sum())
