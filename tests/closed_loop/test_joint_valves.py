"""The joint on proportional valves that are drawn, and not as the laws are told."""

import numpy as np
import pytest

from rig.tuning.score import STRAYED
from rig.tuning.workbench import Request, Workbench

SLOW = [pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 6)]
FRICTION = ("coulomb", "breakaway", "viscous", "ring_friction", "wire_friction")


@pytest.fixture(scope="module")
def bench():
    return Workbench(Request("joint-valves", "cascade", None, (), None, 0))


def drawn(bench, seed):
    """Return a plant within what the data sheet of the spools and the seals leave open."""
    rng = np.random.default_rng(seed)
    told = bench._coarse.told()
    friction = rng.uniform(0.6, 1.6)
    for name in FRICTION:
        told[name] *= friction
    told["spool_bandwidth"] *= rng.uniform(0.67, 1.5)
    told["spool_dead_time"] += rng.uniform(-1e-3, 1e-3)
    return told


@pytest.mark.parametrize("seed", [1, *SLOW])
def test_drawn_valves_are_tracked_and_held_without_shaking(bench, seed):
    trial = bench._coarse.trial(bench.settings, drawn(bench, seed), seed)
    assert trial.lasted == 1.0
    errors = dict(trial.errors)
    assert errors.pop("hold") < 1.5e-3
    assert max(errors.values()) < 1.2e-3  # regulators come to 1.8 mm at best
    assert trial.reversals < 25.0
    assert trial.strayed < STRAYED


def test_the_loop_keeps_its_distance_from_instability(bench):
    (margin,) = bench._coarse.margins(bench.settings, [bench._coarse.told()])
    assert margin.stable
    assert margin.sensitivity < 2.0
