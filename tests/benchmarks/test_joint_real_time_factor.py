"""How much faster than real time the simulated joint is: four channels, camera, log, cascade."""

import time
from pathlib import Path
from statistics import median

import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
OPTIONS = ("reference.tones=[{frequency: 0.5 Hz, laps: 3}]", "metrics={}")
ROUNDS = 3
BOUNDS = {Backend.VIRTUAL: 2.0, Backend.SIM: 10.0}

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("backend", BOUNDS)
def test_joint_real_time_factor(tmp_path, table, backend):
    factors = []
    for number in range(ROUNDS + 1):
        plan = load_plan("joint-ideal-circle", OPTIONS, configs=CONFIGS)
        assert plan.profile.devices["camera"].settings.frame_rate == 60.0
        began = time.process_time()
        result = run_experiment(plan, backend, tmp_path / str(number), report=False)
        spent = time.process_time() - began
        assert result.message is None
        # Energising and releasing are simulated like everything else.
        simulated = len(read_log(result.path / "log.mcap").t) * plan.profile.loop.period
        assert simulated > plan.motion.duration + plan.experiment.approach
        factors.append(simulated / spent)
    factors = factors[1:]  # the first one compiles the plant
    table(
        what=f"joint --on {backend}, times real time",
        factor=median(factors),
        bound=BOUNDS[backend],
        worst=min(factors),
        cycle_us=1e6 / (median(factors) * 1000.0),
    )
    assert median(factors) >= BOUNDS[backend]
