"""Before a real rig is opened, a simulated one is held: its loop finds everything compiled."""

import json

import numpy as np
import pytest
import warm_start

from rig.assembly import Backend
from rig.experiment import run as running
from rig.experiment.plan import load_plan
from rig.experiment.rehearsal import rehearse
from rig.hal import ConnectionFailed
from rig.runtime.log import read_log

SCRIPT = """
import json, sys
from pathlib import Path
from numba.core import event
from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.rehearsal import rehearse
from rig.experiment.run import run_experiment
from rig.runtime.loop import Loop

compiled, run = [], Loop.run

def watched(loop, *args, **options):
    with event.install_recorder("numba:compiler_lock") as seen:
        outcome = run(loop, *args, **options)
    compiled.append(len(seen.buffer))
    return outcome

Loop.run = watched
with event.install_recorder("numba:compiler_lock") as seen:
    plan = load_plan(sys.argv[1], sys.argv[3:])
compiled.append(len(seen.buffer))
rehearse(plan)
result = run_experiment(plan, Backend.SIM, Path(sys.argv[2]), report=False)
print(json.dumps([*compiled, result.exit_code]))
"""

SHORT = {
    "joint-poses": ("reference.dwell=0.2 s", "approach=0.5 s", "metrics={}"),
    "cylinder-step": (
        "reference.dwell=0.5 s",
        "reference.rise=0.1 s",
        "approach=0.5 s",
        "metrics={}",
    ),
}
"""The same ways with shorter stays."""


@pytest.mark.parametrize(
    "experiment",
    [
        "joint-poses",
        pytest.param("joint-circle-camera", marks=pytest.mark.slow),
        pytest.param("cylinder-step", marks=pytest.mark.slow),
    ],
)
def test_nothing_is_compiled_in_the_loop_after_a_rehearsal(experiment, tmp_path):
    done = warm_start.run([experiment, tmp_path, *SHORT.get(experiment, ())], SCRIPT)
    assert done.returncode == 0, done.stderr
    planned, _, ran, code = json.loads(done.stdout)
    assert planned > 0
    assert ran == 0
    assert code == 0
    assert "rehearsal" not in done.stderr


@pytest.mark.parametrize(
    "experiment",
    ["cylinder-step", pytest.param("joint-circle-camera", marks=pytest.mark.slow)],
)
def test_a_rehearsal_leaves_no_trace_in_the_log(experiment, tmp_path):
    logs = []
    for is_rehearsed in (False, True):
        plan = load_plan(experiment, SHORT.get(experiment, ()))
        if is_rehearsed:
            rehearse(plan)
        out = tmp_path / str(is_rehearsed)
        result = running.run_experiment(plan, Backend.SIM, out, report=False)
        logs.append(read_log(result.path / "log.mcap"))
    first, second = logs
    own = [not column.name.startswith("timing.") for column in first.columns]
    assert np.array_equal(first.values[:, own], second.values[:, own])


@pytest.mark.parametrize(("backend", "times"), [(Backend.SIM, 0), (Backend.HARDWARE, 1)])
def test_only_a_real_rig_is_rehearsed(backend, times, tmp_path, monkeypatch):
    rehearsed = []

    def refuse(*_):
        raise ConnectionFailed("can0", "there is none")

    monkeypatch.setattr(running, "rehearse", lambda plan, _: rehearsed.append(plan))
    monkeypatch.setattr(running, "build_rig", refuse)
    plan = load_plan("cylinder-sine")
    with pytest.raises(ConnectionFailed):
        running.run_experiment(plan, backend, tmp_path, heed_calibrations=False)
    assert rehearsed == [plan] * times
