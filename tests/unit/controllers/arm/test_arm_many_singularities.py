"""Drawn curves of the joints, written as poses: through and past shoulder and wrist, in any order.

A planner that gets the poses alone has to find its way through all of them: between the rows a
spline misses by micrometres what the curve hits, singularities follow and meet each other.
"""

import dataclasses

import numpy as np
import pytest
import torque_oracle
from drawn_cases import WIDE, faults_of, hand_of
from scipy.interpolate import CubicSpline
from test_arm_torques import needs_of

from controllers.arm.dynamics.settings import ArmDynamics
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.pose_path import PosePath
from controllers.arm.singular_places import singular_places

GEOMETRY = ArmGeometry(**WIDE)
PERIOD = 5e-3
EVERY = range(6)
ROWS = 40


def plan(path):
    return LookAhead(LookAheadSettings(), GEOMETRY, PERIOD).prepare(path)


def drawn_curve(seed):
    """Return joints of which q2 carries the wrist over the axis of q1, and q5 changes its sign."""
    rng = np.random.default_rng((101, seed))
    knots, q = np.linspace(0.0, 1.0, 5), np.zeros((5, 6))
    q[:, 0] = rng.uniform(-1.5, 1.5) + np.cumsum(rng.normal(scale=0.25, size=5))
    q[:, 2] = rng.uniform(0.7, 1.8) + rng.normal(scale=0.15, size=5)
    a2, a3 = GEOMETRY.a2, GEOMETRY.a3
    lean = np.arctan2(a3 * np.sin(q[:, 2]), a2 + a3 * np.cos(q[:, 2]))
    q[:, 1] = rng.normal(scale=0.25, size=5) - lean
    q[:, 3] = rng.uniform(-2.0, 2.0) + np.cumsum(rng.normal(scale=0.2, size=5))
    q[:, 4] = rng.normal(scale=0.35, size=5)
    q[:, 5] = rng.uniform(-2.0, 2.0) + np.cumsum(rng.normal(scale=0.2, size=5))
    return CubicSpline(knots, q)(np.linspace(0.0, 1.0, ROWS))


def quaternion_of(turn):
    """Return a rotation's quaternion, w first: the eigenvector of Bar-Itzhack's matrix."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    matrix = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    x, y, z, w = np.linalg.eigh(matrix)[1][:, -1]
    return w, x, y, z


def written(seed, folder):
    """Return a path through the poses of a drawn curve, and that curve."""
    curve = drawn_curve(seed)
    rows = [(*hand, *quaternion_of(turn)) for hand, turn in (hand_of(GEOMETRY, q) for q in curve)]
    lines = [", ".join(repr(float(value)) for value in row) for row in rows]
    file = folder / "poses.csv"
    file.write_text("\n".join(["x (m), y (m), z (m), qw, qx, qy, qz", *lines, ""]), "utf-8")
    return PosePath(file=str(file), near=tuple(curve[0].tolist()), speed=0.3), curve


def check(path, curve, made):
    assert faults_of(GEOMETRY, path, made, EVERY, EVERY) == []
    assert made.path_deviation < 1e-6
    for row, q in ((0, curve[0]), (-1, curve[-1])):
        hand, turned = hand_of(GEOMETRY, made.positions[row])
        wanted, tool = hand_of(GEOMETRY, q)
        np.testing.assert_allclose(hand, wanted, atol=1e-8)
        np.testing.assert_allclose(turned, tool, atol=1e-8)
    # Each row's hand is where the motion comes by.
    hands = np.array([hand_of(GEOMETRY, q)[0] for q in made.positions.tolist()])
    far = 0.3 * PERIOD
    for q in curve:
        assert np.linalg.norm(hands - hand_of(GEOMETRY, q)[0], axis=1).min() < far


@pytest.mark.parametrize("seed", [0, 9])
def test_it_goes_through_them_all_as_fast_as_can_be(seed, tmp_path, monkeypatch):
    path, curve = written(seed, tmp_path)
    made = plan(path)
    check(path, curve, made)
    found = singular_places(made.indices, made.positions)
    assert {place.kind for place in found} == {"shoulder", "wrist"}
    strong = ArmDynamics(torque_limits=(1e5,) * 6)
    monkeypatch.setattr(torque_oracle, "POINTS", 2000)
    best = torque_oracle.least_time(
        GEOMETRY, strong, needs_of(dataclasses.replace(GEOMETRY, dynamics=strong), path), made,
        lambda q: hand_of(GEOMETRY, q)[0], path.speed,
    )  # fmt: skip
    assert 0.99 * best <= made.duration <= 1.02 * best


@pytest.mark.slow
@pytest.mark.sampled(3)
@pytest.mark.parametrize("seed", [k for k in range(16) if k not in (0, 9)])
def test_it_goes_through_them_all_at_the_speed_that_is_asked_for(seed, tmp_path):
    path, curve = written(seed, tmp_path)
    check(path, curve, plan(path))
