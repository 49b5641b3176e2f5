"""Drawn twists through every singularity, judged by kinematics that are not ours."""

import numpy as np
import pytest
from arm_cases import GEOMETRIES
from twist_oracle import drawn_case, jacobian_of, off_line

from controllers.arm.online.follower import OnDirection

PERIOD = 5e-3
BACK, FORTH, AFTER = 160, 800, 60
"""Cycles in which the hand goes back from the singularity, through it, and comes to rest."""
TAKEN_UP = 100
FOLLOWERS = {}


def follower_of(name, period=PERIOD, *, through=False):
    """Return a follower; a kernel is compiled once for each."""
    key = name, period, through
    if key not in FOLLOWERS:
        FOLLOWERS[key] = OnDirection(GEOMETRIES[name], period, through=through)
    return FOLLOWERS[key]


def follow(follower, asked):
    """Return the joints, with those before the first cycle, and the mean rates of each cycle."""
    positions = [follower.positions]
    rates = []
    for twist in asked:
        q, u = follower.step(twist)
        positions.append(q)
        rates.append(u)
    return np.array(positions), np.array(rates)


def judge(name, seed):
    """Return what is wrong with a drawn twist, and what is known of it."""
    geometry = GEOMETRIES[name]
    rng = np.random.default_rng((20, seed))
    kind, q, twist = drawn_case(rng, geometry, seed)
    follower = follower_of(name)
    follower.rest(q)
    rest = (0.0,) * 6
    back = tuple(-value for value in twist)
    follow(follower, [back] * BACK + [rest] * AFTER)
    positions, rates = follow(follower, [twist] * FORTH + [rest] * AFTER)
    limits, accelerations = np.array(geometry.rate_limits), np.array(geometry.acceleration_limits)
    moved = np.diff(positions, axis=0) / PERIOD
    change = np.diff(moved, axis=0, prepend=np.zeros((1, 6)))
    away, beside, progress = off_line(geometry, positions, twist)
    steps = np.diff(progress)
    found = {
        "rate": float((np.abs(moved) / limits).max()),
        "acceleration": float((np.abs(change) / PERIOD / accelerations).max()),
        "jump": float((np.abs(change) / limits).max() / (1e3 * PERIOD)),
        "told": float(np.abs(moved - rates).max()),
        "away": away,
        "beside": beside,
        "backwards": float(-min(steps.min(), 0.0)),
        "range": float(
            max(
                (positions - geometry.position_max).max(), (geometry.position_min - positions).max()
            )
        ),
        "at_rest": float(np.abs(moved[-1]).max()),
        "lag": FORTH * PERIOD - float(progress[-1]),
    }
    bounds = {
        "rate": 1.0 + 1e-6, "acceleration": 1.0 + 1e-6, "jump": 0.2, "told": 1e-9, "away": 2e-6,
        "beside": 2e-5, "backwards": 1e-7, "range": 1e-9, "at_rest": 0.0,
    }  # fmt: skip
    wrong = {what: found[what] for what, most in bounds.items() if not found[what] <= most}
    if not all(np.isfinite(value) for value in found.values()):
        wrong["finite"] = found
    free = is_free(geometry, positions, twist)
    if free and found["lag"] > 5.0:
        wrong["lag"] = found["lag"]
    return kind, wrong, found


def is_free(geometry, positions, twist):
    """Return whether nothing but its joints' rates holds the hand back: no range, no boundary."""
    room = np.minimum(
        np.array(geometry.position_max) - positions, positions - np.array(geometry.position_min)
    ).min()
    s3 = np.abs(np.sin(positions[:, 2] + geometry.elbow_angle)).min()
    least = np.linalg.svd(jacobian_of(geometry, positions[-1]), compute_uv=False)[-1]
    return room > 0.05 and s3 > 0.05 and least > 1e-3


@pytest.mark.parametrize("name", ["paper", "other wrist"])
def test_a_few_drawn_twists(name):
    wrong = {seed: judge(name, seed)[1] for seed in range(12)}
    assert not {seed: what for seed, what in wrong.items() if what}


@pytest.mark.slow
@pytest.mark.sampled(3)
@pytest.mark.parametrize("block", range(6))
@pytest.mark.parametrize(
    "name",
    [
        "paper",
        "other wrist",
        "equal links",
        "offsets",
        pytest.param("shoulder ahead", marks=pytest.mark.lengthy),
        pytest.param("all offsets", marks=pytest.mark.lengthy),
    ],
)
def test_three_hundred_drawn_twists(name, block):
    wrong = {seed: judge(name, seed)[1] for seed in range(1000 + 50 * block, 1050 + 50 * block)}
    assert not {seed: what for seed, what in wrong.items() if what}
