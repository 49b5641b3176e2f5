"""Drawn ranges of the joints: the branch that is taken, or the refusal, against all postures.

The postures at the beginning are found by Newton's method from many starts, none of the planner's
closed forms; each of them is followed along the path with ranges that nothing reaches.
"""

import dataclasses
import functools
import math
import re

import numpy as np
import pytest
from drawn_cases import WIDE, hand_of
from test_arm_path import drawn, spline_of

from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.motion import InfeasibleMotion

FREE = ArmGeometry(position_min=(-50.0,) * 6, position_max=(50.0,) * 6)
PATH = drawn(3)
PERIOD = 5e-3
STEP = 1e-7


def plan(path, geometry):
    return LookAhead(LookAheadSettings(), geometry, PERIOD).prepare(path)


def error_of(q, place, tool):
    hand, turned = hand_of(FREE, tuple(q))
    skew = tool @ turned.T
    turn = 0.5 * np.array(
        (skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1])
    )
    return np.concatenate((place - hand, turn)), np.trace(skew)


def solved(q, place, tool):
    """Return joints for a pose from a guess, None if Newton's method does not get there."""
    for _ in range(60):
        error, trace = error_of(q, place, tool)
        if np.abs(error).max() < 1e-11 and trace > 2.9:
            return q
        slopes = np.column_stack(
            [(error_of(q + STEP * row, place, tool)[0] - error) / STEP for row in np.eye(6)]
        )
        step = np.linalg.lstsq(slopes, -error, rcond=1e-8)[0]
        q = q + step * min(1.0, 0.5 / max(np.abs(step).max(), 1e-12))
    return None


def turned(q, near):
    """Return joints with whole turns so that each is nearest to others."""
    return q - math.tau * np.round((q - near) / math.tau)


@functools.cache
def postures():
    """Return the eight postures at the path's beginning with where each leads, near first."""
    rng, near = np.random.default_rng(103), np.array(PATH.near)
    at, tool = hand_of(FREE, PATH.near)
    spline, _ = spline_of(np.array(PATH.points) @ tool.T + at)
    found = []
    while len(found) < 8:
        q = solved(rng.uniform(-3.0, 3.0, 6), spline(0.0), tool)
        if q is None:
            continue
        q = turned(q, near)
        if all(np.abs(turned(q, other) - other).max() > 1e-3 for other in found):
            found.append(q)
    found.sort(key=lambda q: float(np.linalg.norm(q - near)))
    return [
        (q, plan(dataclasses.replace(PATH, begin=tuple(q.tolist())), FREE).positions) for q in found
    ]


def keeps(positions, low, high):
    """Return whether whole turns bring a motion into the ranges."""
    least = np.ceil((low - positions.min(axis=0)) / math.tau)
    most = np.floor((high - positions.max(axis=0)) / math.tau)
    return bool((least <= most).all())


def drawn_ranges(seed):
    rng = np.random.default_rng((104, seed))
    low, high = np.array(WIDE["position_min"]), np.array(WIDE["position_max"])
    for joint in rng.choice(6, 2, replace=False):
        middle, half = rng.uniform(-1.5, 1.5), rng.uniform(0.8, 2.0)
        low[joint], high[joint] = middle - half, middle + half
    return low, high


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 20))]
)
def test_it_begins_on_the_nearest_branch_that_keeps_the_ranges_or_there_is_none(seed):
    low, high = drawn_ranges(seed)
    geometry = ArmGeometry(position_min=tuple(low.tolist()), position_max=tuple(high.tolist()))
    kept = [q for q, positions in postures() if keeps(positions, low, high)]
    if not kept:
        with pytest.raises(InfeasibleMotion) as refused:
            plan(PATH, geometry)
        said = str(refused.value)
        assert said.endswith("None of 7 other branches keeps all ranges.")
        t, joint, angle = re.match(
            r"after (\S+) s(?:, between .*)? q(\d) would be at (\S+) deg, outside", said
        ).groups()
        # The one that is nearest leaves its range there.
        free = plan(PATH, FREE)
        row = free.positions[round(float(t) / PERIOD), int(joint) - 1]
        assert math.radians(float(angle)) == pytest.approx(row, abs=1e-4)
        assert not low[int(joint) - 1] <= row <= high[int(joint) - 1]
        return
    made = plan(PATH, geometry)
    assert (made.positions >= low).all()
    assert (made.positions <= high).all()
    np.testing.assert_allclose(turned(made.positions[0], kept[0]), kept[0], atol=1e-6)
