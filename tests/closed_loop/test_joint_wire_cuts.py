"""The wire that broke is the one that is named: any wire, at any moment of any motion."""

from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment

CONFIGS = Path(__file__).parents[2] / "configs"
EXPERIMENTS = (
    "joint-ideal-circle",
    "joint-ideal-circle-low-speed",
    "joint-poses",
    "joint-poses-low-speed",
    "joint-range",
    "joint-wide",
)


def message_of_a_cut(folder, backend, wire, draw):
    """Return what is said of a wire that is cut at a drawn moment of a drawn experiment."""
    rng = np.random.default_rng([wire, draw])
    at, seed = rng.uniform(2.2, 7.5), rng.integers(10_000)
    options = [
        "metrics={}",
        "figures=[]",
        f"simulation.seed={seed}",
        f"simulation.faults=[{{at: {at}, device: plant, fault: wire_cut, value: {wire}}}]",
    ]
    plan = load_plan(EXPERIMENTS[rng.integers(len(EXPERIMENTS))], options, configs=CONFIGS)
    result = run_experiment(plan, backend, folder, report=False)
    assert result.exit_code == 4
    return result.message


@pytest.mark.parametrize("wire", [0, 1, 2, 3])
def test_a_cut_wire_is_named(tmp_path, wire):
    message = message_of_a_cut(tmp_path, Backend.SIM, wire, 0)
    assert message.startswith(f"the wire of ch{wire + 1} is ")


@pytest.mark.slow
def test_of_sixteen_cut_wires_over_the_bus_fifteen_are_named(tmp_path):
    cases = [(wire, draw) for wire in range(4) for draw in range(1, 5)]
    messages = {case: message_of_a_cut(tmp_path, Backend.VIRTUAL, *case) for case in cases}
    right = [
        message.startswith(f"the wire of ch{wire + 1} is ")
        for (wire, _), message in messages.items()
    ]
    assert sum(right) >= 15, messages
