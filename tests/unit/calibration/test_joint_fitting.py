"""Posteriors of fits with tolerances, blocks, and parameters that are considered and not fitted."""

import numpy as np
import pytest

from rig.mechanisms.joint.calibration.parameters import Prior
from rig.mechanisms.joint.calibration.pose_fit import Data, fit_posterior

BLOCKS, ROWS = 12, 10
NOISE, BOUND = 0.3, 0.2
GROUPS = np.repeat(np.arange(BLOCKS), ROWS)
T = np.random.default_rng(0).uniform(0.5, 1.5, BLOCKS * ROWS)
START = {"slope": 0.0, "offset": 0.0, "lost": 0.0}


def priors(considered):
    even = BOUND / np.sqrt(3.0)
    return [
        Prior("slope", "1", 0.0, 10.0), Prior("offset", "1", 0.0, 10.0),
        Prior("lost", "1", 0.0, even, True, considered),
    ]  # fmt: skip


def fitted(measured, considered=True):
    def misfit(values):
        slope, offset, lost = values["slope"], values["offset"], values["lost"]
        return ((measured - offset - (slope + lost) * T) / NOISE)[:, None]

    data = Data(misfit, GROUPS, lambda values: np.zeros(0))
    return fit_posterior(priors(considered), data, START)


@pytest.mark.parametrize("considered", [True, False])
def test_what_nothing_tells_apart_is_left_to_its_tolerance(considered):
    rng = np.random.default_rng(1)
    posterior = fitted(2.0 + 3.0 * T + 1e-4 * NOISE * rng.standard_normal(T.size), considered)
    found = posterior.estimate("slope")
    assert posterior.by_name["lost"] == pytest.approx(0.0, abs=1e-3)
    assert found.value == pytest.approx(3.0, abs=1e-2)
    assert 0.5 * (found.high - found.low) == pytest.approx(0.95 * BOUND, rel=0.03)


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng, held = np.random.default_rng(2), []
    for _ in range(120):
        slope, lost = rng.uniform(-1.0, 1.0), rng.uniform(-BOUND, BOUND)
        each = 0.5 * NOISE * rng.standard_normal(BLOCKS)[GROUPS]  # a block errs together
        noise = NOISE * rng.standard_normal(T.size) + each
        found = fitted(1.0 + (slope + lost) * T + noise).estimate("slope")
        held.append(found.low <= slope <= found.high)
    assert 0.90 <= np.mean(held) <= 0.99
