"""What a cycle of an arm costs that follows twists: ours, and the rivals, on the same ones."""

import math
import time

import numpy as np
import pytest

from controllers.arm.geometry import ArmGeometry
from controllers.arm.online.commands import twist_at
from controllers.arm.online.follower import OnDirection
from controllers.arm.online.rivals import DampedTwist, HaltingTwist

pytestmark = pytest.mark.benchmark

GEOMETRY = ArmGeometry()
START = tuple(math.radians(angle) for angle in (0.0, -20.0, 100.0, 0.0, 30.0, 0.0))
ROWS = [  # those of configs/experiments/arm-twist.yaml: wrist, shoulder, boundary
    (0.0, 0.0, 0.001, 0.0, 0.02, -0.3, 0.0),
    (7.0, -0.1, 0.0, 0.0, 0.0, 0.0, 0.0),
    (14.5, -0.1, 0.05, 0.1, 0.0, 0.0, 0.0),
    (19.0, 0.1, 0.05, -0.05, 0.0, 0.0, 0.1),
    (21.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
]
MOST = {5e-3: (150e-6, 1.5e-3), 1e-3: (600e-6, math.inf)}
"""Median, and what 99 of 100 cycles may take, s."""
FOLLOWERS = {
    "esc": lambda period: OnDirection(GEOMETRY, period, through=False),
    "dls": lambda period: DampedTwist(GEOMETRY, period, 0.02, 0.1),
    "servo-halt": lambda period: HaltingTwist(GEOMETRY, period, 17.0, 30.0),
}


@pytest.mark.parametrize("period", MOST)
def test_a_cycle_of_twists(table, period):
    for name, make in FOLLOWERS.items():
        follower = make(period)
        follower.rest(START)
        follower.step((0.0,) * 6)  # compiled, or read from the cache
        costs = []
        for k in range(round(ROWS[-1][0] / period)):
            asked = twist_at(ROWS, k * period)
            began = time.thread_time()
            follower.step(asked)
            costs.append(time.thread_time() - began)
        median, most, worst = np.quantile(costs, (0.5, 0.99, 1.0))
        table(
            what=f"{name} at {1.0 / period:g} Hz",
            median_us=1e6 * median, p99_us=1e6 * most, max_us=1e6 * worst,
        )  # fmt: skip
        if name == "esc":
            assert median <= MOST[period][0]
            assert most <= MOST[period][1]
