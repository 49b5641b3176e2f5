"""An arm that follows twists: turning to a new one, stopping, the boundary, and who refuses."""

import sys

import numpy as np
import pytest
from arm_cases import GEOMETRIES, radians
from test_arm_twist_drawn import PERIOD, follow, follower_of
from twist_oracle import hand_of, off_line

from controllers import compiled
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.online.commands import TwistRows
from controllers.arm.online.follower import OnDirection
from controllers.motion import InfeasibleMotion

GEOMETRY = GEOMETRIES["paper"]
START = radians(10, 10, 100, 20, 40, 0)
REST = (0.0,) * 6


def accelerations(positions):
    moved = np.diff(positions, axis=0, prepend=positions[:1]) / PERIOD
    return np.abs(np.diff(moved, axis=0)) / PERIOD / np.array(GEOMETRY.acceleration_limits)


def test_a_new_follower_has_its_kernel_before_the_loop(monkeypatch):
    monkeypatch.setattr(compiled, "kernel_of", compiled.kernel_of.__wrapped__)  # as the first one
    follower = OnDirection(GEOMETRY, PERIOD, through=False)
    calls = []
    sys.setprofile(lambda _, event, what: calls.append(what) if "call" in event else None)
    try:
        follower.step(REST)
    finally:
        sys.setprofile(None)
    assert len(calls) < 50  # a kernel that is loaded makes some 30 000
    assert follower.positions == REST


@pytest.mark.parametrize("seed", range(10))
def test_a_new_direction_is_taken_up_as_fast_as_the_joints_can(seed):
    rng = np.random.default_rng(seed)
    first, second = (tuple((rng.normal(size=6) * 0.06).tolist()) for _ in range(2))
    follower = follower_of("paper")
    follower.rest(START)
    positions, _ = follow(follower, [first] * 100 + [second] * 120)
    assert accelerations(positions).max() <= 1.0 + 1e-6
    # Both directions take all joints at most 2 limits apart: 0.2 s, and as much to turn in.
    away, beside, progress = off_line(GEOMETRY, positions[180:], second)
    assert away < 1e-6
    assert beside < 1e-6
    assert progress[-1] == pytest.approx(40 * PERIOD, rel=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_a_stop_takes_no_longer_than_the_accelerations_need(seed):
    rng = np.random.default_rng(seed)
    twist = tuple((rng.normal(size=6) * 0.2).tolist())
    follower = follower_of("paper")
    follower.rest(START)
    _, before = follow(follower, [twist] * 60)
    positions, rates = follow(follower, [REST] * 40)
    need = np.max(np.abs(before[-1]) / np.array(GEOMETRY.acceleration_limits))
    at_rest = np.flatnonzero(~rates.any(axis=1))[0] * PERIOD
    assert at_rest <= 1.5 * need + 2 * PERIOD
    assert off_line(GEOMETRY, positions[: len(positions)], twist)[0] < 1e-6


def test_the_hand_stays_at_the_boundary_and_leaves_it_on_a_new_direction():
    follower = follower_of("paper")
    follower.rest(START)
    out, back = (0.15, 0.0, 0.05, 0.0, 0.0, 0.0), (-0.1, 0.05, 0.0, 0.0, 0.0, 0.0)
    positions, _ = follow(follower, [out] * 1200)
    assert off_line(GEOMETRY, positions, out)[0] < 1e-6
    assert abs(positions[-1][2]) < 1e-3
    assert positions[:, 2].min() >= -1e-9
    away, _ = follow(follower, [back] * 400)
    assert off_line(GEOMETRY, away[60:], back)[0] < 1e-6
    assert away[-1][2] > 0.5


def test_back_from_the_boundary_the_elbow_is_on_its_other_side():
    follower = follower_of("paper", through=True)
    follower.rest(START)
    out = (0.15, 0.0, 0.05, 0.0, 0.0, 0.0)
    positions, rates = follow(follower, [out] * 1200)
    assert positions[:, 2].min() < -0.5
    assert accelerations(positions).max() <= 1.0 + 1e-6
    assert (np.abs(rates) / np.array(GEOMETRY.rate_limits)).max() <= 1.0 + 1e-6
    away, beside, _ = off_line(GEOMETRY, positions, out)
    assert away < 2e-6
    assert beside < 1e-6
    hands = np.array([hand_of(GEOMETRY, q)[0] for q in positions])
    reached = np.linalg.norm(hands - hands[0], axis=1)
    assert reached[-1] < reached.max() - 0.05


def test_who_plans_whole_paths_says_who_follows_twists():
    law = LookAhead(LookAheadSettings(), GEOMETRY, PERIOD)
    with pytest.raises(InfeasibleMotion, match="look-ahead plans whole paths; esc, dls and servo"):
        law.prepare_twists(TwistRows(rows=((0.0, *REST), (1.0, *REST))))
