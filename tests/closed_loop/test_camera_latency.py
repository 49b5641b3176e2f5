"""A camera whose latency is not the profile's is told at the end of the run, by how much."""

from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder

CONFIGS = Path(__file__).parents[2] / "configs"
CALIBRATED = 40.0
"""Latency of the profile, ms."""
OFF = (
    "plant.camera={{latency: {latency} ms, latency_jitter: 2 ms, drop_rate: 0.1, "
    "rotation_error: [0.001, -0.001, 0.01], position_error: [0.5 mm, 0.5 mm, -0.5 mm]}}"
)


def told(folder, experiment, seed, late):
    """Return what a run says of its camera; None if nothing."""
    rng = np.random.default_rng([40, seed])
    options = ["metrics={}", "figures=[]", "controllers.cascade.dither.amplitude=0"]
    options.append(OFF.format(latency=CALIBRATED + late))
    options.append(f"simulation.seed={rng.integers(1000)}")
    if experiment == "joint-ideal-circle":
        tone = rng.uniform(0.15, 0.6)
        options.append(f"reference.tones=[{{frequency: {tone} Hz, laps: 2}}]")
        options.append(f"reference.tilt={rng.uniform(15.0, 30.0)} deg")
    plan = load_plan(experiment, options, configs=CONFIGS)
    result = run_experiment(plan, Backend.SIM, folder, report=False)
    assert result.message is None
    events = RunFolder.open(result.path).events()
    said = [event["message"] for event in events if event["kind"] == "camera"]
    assert len(said) <= 1
    return said[0] if said else None


def assert_told(folder, experiment, seed, late):
    message = told(folder, experiment, seed, late)
    if abs(late) < 1.0:
        assert message is None
        return
    assert message is not None, late
    assert message.startswith("camera: the profile says a latency of 40 ms, I see ")
    seen = float(message.partition("I see ")[2].partition(" ")[0])
    assert seen == pytest.approx(CALIBRATED + late, abs=1.5)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_drawn_latency_is_told_if_it_is_wrong(tmp_path, seed):
    rng = np.random.default_rng([41, seed])
    late = rng.uniform(6.0, 20.0) * rng.choice([-1.0, 1.0]) if seed else rng.uniform(-1.0, 1.0)
    assert_told(tmp_path, "joint-ideal-circle", seed, late)


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ["joint-ideal-circle", "joint-poses", "joint-range"])
@pytest.mark.parametrize("seed", range(2, 8))
def test_drawn_latencies_are_told_on_other_motions(tmp_path, experiment, seed):
    rng = np.random.default_rng([41, seed])
    late = rng.uniform(6.0, 20.0) * rng.choice([-1.0, 1.0]) if seed % 3 else rng.uniform(-1.0, 1.0)
    assert_told(tmp_path, experiment, seed, late)
