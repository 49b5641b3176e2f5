"""What a drawn plant does that nobody told the profile of is named, whatever it looks like first.

Found by somebody who had not read the code: slow spools were a lost supply, a loop that late air
and little friction make unstable was a leak, and a pair that was 7 mm off for a moment was well.
"""

import random

import numpy as np
import pytest
from stop_bench import CONFIGS

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_facts import RunStatus
from rig.scripting.running import load

DRAWN = random.Random(4217)


def ended(folder, name, *options):
    plan = load_plan(name, (*options, "figures=[]"), configs=CONFIGS)
    return run_experiment(plan, Backend.SIM, folder, report=False)


@pytest.mark.parametrize(
    ("bandwidth", "seed"), [(DRAWN.uniform(60.0, 80.0), DRAWN.randrange(10**6)) for _ in range(8)]
)
def test_spools_that_are_far_too_slow_are_called_slow(bandwidth, seed, tmp_path):
    options = f"plant.valve.bandwidth={bandwidth} rad/s", f"simulation.seed={seed}"
    result = ended(tmp_path, "cylinder-valves-sine", *options)
    assert result.status is RunStatus.FAULTED
    assert "slow" in result.message, result.message


@pytest.mark.parametrize(
    ("late", "friction", "seed"),
    [
        (DRAWN.uniform(24e-3, 30e-3), DRAWN.uniform(0.35, 0.45), DRAWN.randrange(10**6))
        for _ in range(6)
    ],
)
def test_a_loop_that_late_air_and_little_friction_make_unstable_is_not_only_a_leak(
    late, friction, seed, tmp_path
):
    options = (
        f"plant.regulator.dead_time={late} s", f"plant.friction_scale={friction}",
        f"simulation.seed={seed}",
    )  # fmt: skip
    result = ended(tmp_path, "cylinder-step", *options)
    said = (result.path / "events.jsonl").read_text()
    words = ("friction", "late", "slow", "oscillates", "hunts", "sticks", "off its reference")
    assert any(word in said for word in words), said


@pytest.mark.parametrize("seed", [DRAWN.randrange(10**6) for _ in range(6)])
def test_who_was_farther_off_than_is_permitted_for_a_moment_is_told(seed, tmp_path):
    options = (
        f"plant.regulator.sampling={DRAWN.uniform(15e-3, 20e-3)} s",
        f"plant.friction_scale={DRAWN.uniform(0.35, 0.5)}", f"simulation.seed={seed}",
    )  # fmt: skip
    result = ended(tmp_path, "cylinder-sine", *options)
    log = load(result.path).data
    moves = log["phase"] == log["phase"].max()
    far = np.abs(log["reading.position"] - log["reference.position"])[moves].max()
    said = (result.path / "events.jsonl").read_text()
    assert result.status is not RunStatus.OK or far <= 6e-3 or "off its reference, beyond" in said
