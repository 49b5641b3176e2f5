"""What a simulated run costs over its own floor: the compiled plant alone, for the same time.

A round has the plant advance alone, in steps of a second, and then the experiment run on `sim` and
on `virtual`, with log and metrics and without a report.
"""

import time

import pytest
from intervals import ratio_of

from rig.assembly import Backend
from rig.assembly.simulated import make_plant
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.runtime.log import read_log

ROUNDS = 5
WANTED = {Backend.SIM: 3.0, Backend.VIRTUAL: 15.0}
EXPERIMENTS = {
    "cylinder-step": ("metrics={}",),
    "joint-circle-camera": ("reference.tones=[{frequency: 0.5 Hz, laps: 3}]", "metrics={}"),
}

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_simulation_floor(tmp_path, table, experiment):
    plan = load_plan(experiment, EXPERIMENTS[experiment])
    floors, costs = [], {backend: [] for backend in WANTED}
    for number in range(ROUNDS + 1):  # the first compiles
        for backend in WANTED:
            out = tmp_path / f"{backend}-{number}"
            began = time.process_time()
            done = run_experiment(plan, backend, out, report=False)
            costs[backend].append(time.process_time() - began)
            assert done.message is None
            seconds = len(read_log(done.path / "log.mcap").t) * plan.profile.loop.period
        floors.append(alone(plan.profile, seconds))
    table(what="the plant alone", ms_per_s=1e3 * min(floors[1:]) / seconds)
    for backend, wanted in WANTED.items():
        ratio, low, high = ratio_of(costs[backend][1:], floors[1:])
        cycle = 1e6 * min(costs[backend][1:]) / seconds * plan.profile.loop.period
        table(
            what=f"--on {backend}", over_it=ratio, low=low, high=high, wanted=wanted,
            reached=high <= wanted, cycle_us=cycle,
        )  # fmt: skip
    assert min(floors) > 0.0


def alone(profile, seconds):
    """Return the processor time in which the plant gets so far, s."""
    plant = make_plant(profile)
    plant.set_supply(True)
    began = time.process_time()
    for second in range(1, int(seconds) + 1):
        plant.advance(float(second))
    plant.advance(seconds)
    return time.process_time() - began
