"""How much faster than real time the simulated backends are, with the log and the cascade."""

import time
from statistics import median

import numpy as np
import pytest
from bench_rig import armed_rig, run

from rig.assembly import Backend
from rig.runtime.log import read_log

SECONDS = 10.0
ROUNDS = 3
BOUNDS = {Backend.VIRTUAL: 4.0, Backend.SIM: 20.0}
STAGES = ("receive", "read", "control", "transmit", "record")

pytestmark = pytest.mark.benchmark


def test_real_time_factor(tmp_path, table):
    factors = {backend: [] for backend in BOUNDS}
    shares = {}
    for backend in BOUNDS:  # compiles the plant
        with armed_rig(backend) as rig:
            run(rig, tmp_path / f"warm-{backend}.mcap", SECONDS)
    for number in range(ROUNDS):
        for backend in BOUNDS:
            log = tmp_path / f"{backend}-{number}.mcap"
            with armed_rig(backend) as rig:
                began = time.process_time()
                done = run(rig, log, SECONDS)
                spent = time.process_time() - began
            factors[backend].append(done.duration / spent)
            shares[backend] = stage_costs(log), spent / done.outcome.cycles
    for backend, bound in BOUNDS.items():
        stages, cycle = shares[backend]
        table(
            what=f"--on {backend}, times real time",
            factor=median(factors[backend]),
            bound=bound,
            worst=min(factors[backend]),
            cycle_us=1e6 * cycle,
        )
        for stage, cost in stages.items():
            table(what=f"  {stage}", us=1e6 * cost, share=cost / cycle)
        table(what="  simulated world and the rest", share=1.0 - sum(stages.values()) / cycle)
    for backend, bound in BOUNDS.items():
        assert median(factors[backend]) >= bound


def stage_costs(path):
    """Return what each stage of a cycle took by the log, the median in seconds."""
    log = read_log(path)
    names = [column.name for column in log.columns]
    return {
        stage: float(np.median(log.values[:, names.index(f"timing.{stage}")])) for stage in STAGES
    }
