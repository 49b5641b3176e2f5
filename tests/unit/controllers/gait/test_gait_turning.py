"""Legs that turn, step aside, climb and tilt: the curve against kinematics of the test's own."""

import math

import numpy as np
import pytest
from test_gait_drawn import GEOMETRY, turns

from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase
from controllers.gait.turning import PhaseTurning


def attitude(roll, pitch, yaw):
    one = np.ones(1)
    return (turns("z", yaw * one) @ turns("y", pitch * one) @ turns("x", roll * one))[0]


def sole_of(joints, leg, waist, yaw):
    """Return position and rotation of a sole under a waist that only heads somewhere."""
    first, second, third, knee, ankle, last = (np.ones(1) * angle for angle in joints)
    side = GEOMETRY.hip_half_spacing * (1.0 if leg else -1.0)
    frame = attitude(0.0, 0.0, yaw)
    thigh = frame @ (turns("z", first) @ turns("x", second) @ turns("y", third))[0]
    shank = thigh @ turns("y", knee)[0]
    foot = shank @ (turns("y", ankle) @ turns("x", last))[0]
    hip = np.array(waist) + frame @ (0.0, side, 0.0)
    at = hip - GEOMETRY.thigh * thigh[:, 2] - GEOMETRY.shank * shank[:, 2]
    return at - GEOMETRY.ankle_height * foot[:, 2], foot


def draw(seed):
    """Return a phase in which one foot swings or none does, and everything turns."""
    rng = np.random.default_rng((81, seed))
    swings = seed % 3
    standing = (swings != 1, swings != 2)
    feet = [(0.0, -0.04, 0.0), (float(rng.uniform(-0.02, 0.02)), 0.045, 0.004)]
    angles = rng.uniform(-0.12, 0.12, (3, 3))
    turning = PhaseTurning(
        float(rng.uniform(-0.2, 0.2)),
        float(rng.uniform(-0.2, 0.2)),
        (tuple(angles[0].tolist()), tuple(angles[1].tolist())),
        tuple(angles[2].tolist()),
        tuple(rng.uniform((-0.03, -0.01, -0.01), (0.03, 0.01, 0.01)).tolist()),
    )
    travel = tuple(rng.uniform(-0.01, 0.01, 3).tolist())
    return GaitPhase(
        "drawn", 1.0, standing, (0.0, 0.0, 0.215), travel, tuple(feet), 0.0, 0.012, 0.0, 0.15,
        turning,
    )  # fmt: skip


def off(phase, joints, xi):
    """Return how far a posture's soles are from where they belong: m, and as a rotation."""
    worst = 0.0
    for leg in (0, 1):
        at, foot = sole_of(joints[6 * leg : 6 * leg + 6], leg, phase.waist_at(xi), phase.yaw_at(xi))
        wanted = attitude(*phase.attitude_at(leg, xi))
        worst = max(worst, np.abs(at - phase.foot_at(leg, xi)).max(), np.abs(foot - wanted).max())
    return worst


@pytest.mark.parametrize("seed", range(12))
def test_curve_puts_both_soles_where_they_belong(seed):
    phase = draw(seed)
    curve = PhaseCurve(GEOMETRY, phase, 1e-2)
    for xi in (0.0, 0.13, 0.5, 1.0):
        assert off(phase, curve.joints_at(xi), xi) < 1e-12


@pytest.mark.parametrize("seed", range(12))
def test_ray_follows_the_same_curve_as_the_inverse(seed):
    phase = draw(seed)
    curve = PhaseCurve(GEOMETRY, phase, 1e-2)
    for _ in range(120):
        before = np.array(curve.joints)
        curve.follow_joints(2e-3)
        moved = np.linalg.norm(np.array(curve.joints) - before)
        if curve.path < 1.0:
            assert moved == pytest.approx(2e-3, rel=1e-3)
            np.testing.assert_allclose(curve.velocities, (curve.joints - before) / 1e-2, atol=1e-9)
        assert off(phase, curve.joints, curve.path) < 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_tangents_are_the_derivatives_of_the_paths(seed):
    for path in draw(seed).legs(GEOMETRY):
        for xi in (0.2, 0.7):
            h = 1e-6
            difference = (np.array(path.at(xi + h)) - np.array(path.at(xi - h))) / (2.0 * h)
            np.testing.assert_allclose(path.tangent(xi), difference, atol=1e-9)


def test_what_does_not_turn_is_the_path_of_the_straight_walk():
    straight = GaitPhase(
        "straight", 1.0, (True, True), (0.0, 0.0, 0.22), (0.01, 0.02, 0.0),
        ((0.0, -0.039, 0.0), (0.02, 0.039, 0.0)),
    )  # fmt: skip
    turned = straight._replace(turning=PhaseTurning())
    for a, b in zip(straight.legs(GEOMETRY), turned.legs(GEOMETRY), strict=True):
        for xi in (0.0, 0.4, 1.0):
            np.testing.assert_allclose(a.at(xi), b.at(xi), atol=1e-15)
            np.testing.assert_allclose(a.tangent(xi), b.tangent(xi), atol=1e-15)
    one, other = (PhaseCurve(GEOMETRY, phase, 1e-2) for phase in (straight, turned))
    one.follow_joints(0.05)
    other.follow_joints(0.05)
    np.testing.assert_allclose(one.joints, other.joints, atol=1e-12)
    assert one.path == pytest.approx(other.path, abs=1e-12)
    assert math.isfinite(one.path)
