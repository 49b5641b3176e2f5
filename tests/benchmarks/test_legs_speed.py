"""How much faster than real time the walk of 48 s is in MuJoCo, from the plan to the metrics.

The processor's time counts, as other work on the machine does not make the simulation slower.
"""

import time
from statistics import median

import pytest

from rig.assembly import Backend
from rig.config import find_configs
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment

WALK = 48.0
ROUNDS = 3
BOUND = 10.0

pytestmark = pytest.mark.benchmark


def test_legs_speed(tmp_path, table):
    (configs,) = find_configs()
    rounds = []
    for number in range(ROUNDS + 1):
        began = time.process_time()
        plan = load_plan("legs-walk", configs=configs)
        planned = time.process_time()
        result = run_experiment(plan, Backend.SIM, tmp_path, report=False)
        done = time.process_time()
        assert result.exit_code == 0
        if number:  # the first one compiles and imports
            rounds.append((planned - began, done - planned))
    planning, running = (median(each) for each in zip(*rounds, strict=True))
    factor = WALK / running
    table(what="planning", seconds=planning)
    table(
        what="walk with log and metrics",
        seconds=running,
        times_real_time=factor,
        bound=BOUND,
        with_planning=WALK / (planning + running),
    )
    assert factor >= BOUND
