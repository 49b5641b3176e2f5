"""Somebody pushes the pair's carriage or the joint's ring: lightly, hard, and either way."""

import numpy as np
import pytest
from pair_fault_bench import CONFIGS

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

PLACES = {
    "cylinder-ideal-sine": ("along.carriage_push",),
    "joint-ideal-circle": ("forward.ring_push", "left.ring_push"),
}
LAPS = {"cylinder-ideal-sine": "periods", "joint-ideal-circle": "laps"}
HARMLESS = 0.5
"""N s: what the table of faults says must be ridden through."""
LIGHT = {"cylinder-ideal-sine": ("position", 3e-3), "joint-ideal-circle": ("axis", 0.025)}
"""By so much a light push may move it: the following error that is a fault, m; 1.4 degrees."""


def run_pushed(folder, experiment, seed, low, high, backend):
    """Return the result, the truth over time, and when and what the push was."""
    rng = np.random.default_rng([len(experiment), seed])
    place = PLACES[experiment][int(rng.integers(len(PLACES[experiment])))]
    size = float(rng.choice([-1.0, 1.0]) * rng.uniform(low, high))
    at = float(rng.uniform(2.2, 3.4))
    faults = [f"{{at: {at}, device: plant, fault: {place}, value: {size}}}"] if size else []
    options = [
        f"reference.tones=[{{frequency: 0.5 Hz, {LAPS[experiment]}: 2}}]",
        "approach=0.5 s",
        "metrics={}",
        "figures=[]",
        f"simulation.seed={seed}",
        f"simulation.faults=[{', '.join(faults)}]",
    ]
    result = run_experiment(
        load_plan(experiment, options, configs=CONFIGS), backend, folder, report=False
    )
    return result, read_log(RunFolder.open(result.path).log_path), (place, size)


def moved(log, still, what):
    """Return how far it was off where it would have been, by the truth."""
    rows = min(len(log.t), len(still.t))
    names = log.names(f"truth.{what}")
    off = [log.column(name)[:rows] - still.column(name)[:rows] for name in names]
    return float(np.sqrt(np.sum(np.square(off), axis=0)).max())


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("experiment", PLACES)
def test_a_light_push_is_ridden_through_and_moves_little(tmp_path, experiment, seed):
    result, log, push = run_pushed(
        tmp_path / "pushed", experiment, seed, 0.1, HARMLESS, Backend.SIM
    )
    assert (result.exit_code, result.message) == (0, None), push
    _, still, _ = run_pushed(tmp_path / "still", experiment, seed, 0.0, 0.0, Backend.SIM)
    what, most = LIGHT[experiment]
    assert 0.0 < moved(log, still, what) < most, push


@pytest.mark.parametrize("seed", range(3))
def test_a_hard_push_is_told_from_an_encoder_that_jumps(tmp_path, seed):
    """Over the bus, whose encoders say that nothing moves so fast."""
    result, _, push = run_pushed(tmp_path, "cylinder-ideal-sine", seed, 6.0, 12.0, Backend.VIRTUAL)
    assert result.exit_code == 4, push
    assert result.message.startswith("the carriage was pushed or struck: it pulls the rod"), push
