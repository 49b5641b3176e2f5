"""Runs in processes of their own that are killed in mid-run, and what their logs must hold."""

import multiprocessing
import signal
import time

import numpy as np

from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log
from rig.runtime.recorder import LogRecorder

PATIENCE = 120.0
"""In which a run records as many cycles as it is killed after, s."""


def record_until_killed(plan, backend, out, acknowledged):
    """Run in a child, counting every cycle whose recording was acknowledged."""
    write = LogRecorder.write

    def counting(self, cycle, t, row):
        write(self, cycle, t, row)
        acknowledged.value += 1

    LogRecorder.write = counting
    run_experiment(plan, backend, out, report=False)


def is_whole(log):
    """Whether a log has every cycle from the first to its last, and every number of them."""
    counted = np.array_equal(log.cycle, np.arange(len(log.cycle)))
    return counted and len(log.values) == len(log.t) == len(log.cycle) and len(log.t) > 0


def is_the_beginning_of(log, whole):
    """Whether every number of a log is that of the run that was let end, but for clocks'."""
    assert [c.name for c in log.columns] == [c.name for c in whole.columns]
    simulated = [k for k, c in enumerate(log.columns) if not c.name.startswith("timing.")]
    assert len(simulated) > 20
    first = whole.values[: len(log.values), simulated]
    return log.values[:, simulated].tobytes() == first.tobytes()


def kill_in_mid_run(plan, backend, out, generator):
    """Kill a run after a drawn cycle; return its folder, whose log has been checked."""
    context = multiprocessing.get_context("fork")
    acknowledged = context.Value("q", 0, lock=False)
    child = context.Process(target=record_until_killed, args=(plan, backend, out, acknowledged))
    child.start()
    target = generator.integers(1, 3000)
    deadline = time.monotonic() + PATIENCE
    while acknowledged.value < target and child.is_alive() and time.monotonic() < deadline:
        time.sleep(generator.uniform(0.0, 2e-3))
    child.kill()
    child.join()
    assert child.exitcode == -signal.SIGKILL
    (path,) = out.iterdir()
    folder = RunFolder.open(path)
    assert folder.status.value == "crashed"
    log = read_log(folder.log_path)
    assert len(log.cycle) >= acknowledged.value >= target
    assert is_whole(log)
    return folder
