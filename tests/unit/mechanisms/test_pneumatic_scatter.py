"""Which encoder scatters, told from the samples before a fault."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.scatter import explain_scatter, scatter

PERIOD = 1e-3
T = PERIOD * np.arange(64)


def moving(rng):
    """A rod that swings and drifts, as quickly as a rig can."""
    size, rate = rng.uniform(0.0, 10e-3), rng.uniform(1.0, 60.0)
    return size * np.sin(rate * T + rng.uniform(0.0, 6.0)) + rng.uniform(-0.3, 0.3) * T


def alternating(size, count=64):
    """Samples to both sides: each second difference is four times the size, with turns of sign."""
    return [size * (-1.0) ** k for k in range(count)]


@pytest.mark.parametrize("seed", range(20))
def test_noise_is_told_by_its_size_whatever_moves(seed):
    rng = np.random.default_rng((0x5CA7, seed))
    noise = float(np.exp(rng.uniform(*np.log((5e-5, 1e-3)))))
    assert scatter((moving(rng) + rng.normal(0.0, noise, 64)).tolist()) == pytest.approx(
        noise, rel=0.4
    )


@pytest.mark.parametrize("seed", range(20))
def test_a_motion_is_no_noise(seed):
    assert scatter(moving(np.random.default_rng(seed)).tolist()) == 0.0


def test_the_deviation_of_known_samples():
    """Second differences of ±s are ±4 s, and white noise has √6 times its own."""
    for count in (16, 17, 64):
        found = scatter(alternating(1e-3, count))
        assert found == pytest.approx(4e-3 / math.sqrt(6.0), rel=1e-12)
    assert scatter(alternating(1e-3, 15)) == 0.0
    assert scatter([0.0] * 64) == 0.0


def test_what_is_noise_alternates_by_two_fifths_at_least():
    """Bends of a first-order series have its correlation; the sums here are exact."""
    for follows, is_noise in ((-0.36, False), (-0.44, True)):
        bends = [1.0]
        rng = np.random.default_rng(1)
        drive = rng.normal(0.0, 1.0, 4000)
        for kick in drive:
            bends.append(follows * bends[-1] + math.sqrt(1.0 - follows**2) * kick)
        power = float(sum(bend * bend for bend in bends))
        lag = float(sum(a * b for a, b in pairwise(bends))) / power
        samples = np.cumsum(np.cumsum([0.0, 0.0, *bends])).tolist()
        assert (lag < -0.4) is is_noise, "the series itself"
        assert (scatter(samples) > 0.0) is is_noise


def test_the_encoder_that_scatters_most_is_named():
    names = ("first", "second", "third")
    still = [0.0] * 64
    size = math.sqrt(6.0) / 4.0
    for ends in ((still, alternating(20e-6 * size), alternating(40e-6 * size)),):
        said = explain_scatter(names, list(zip(*ends, strict=True)))
        assert said == "third scatters by 0.04 mm, which shakes setpoints"
    for deviation, is_told in ((14.9e-6, False), (15.1e-6, True)):
        samples = list(zip(alternating(deviation * size), still, still, strict=True))
        assert (explain_scatter(names, samples) is not None) is is_told
    assert explain_scatter(names, []) is None
