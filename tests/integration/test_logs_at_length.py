"""Logs of runs that were killed, or whose disk was full, on both backends: whole to their end."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from killed_runs import is_the_beginning_of, is_whole, kill_in_mid_run
from small_disk import may_mount, on_a_small_disk

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = {
    "cylinder-sine": ["reference.tones=[{frequency: 1 Hz, periods: 3}]", "approach=0.5 s"],
    "joint-circle": ["reference.tones=[{frequency: 0.5 Hz, laps: 1}]"],
}
NOTHING = ["metrics={}", "figures=[]"]
KILLS, FULL_DISKS = 50, 10
"""Of each experiment on each backend."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.lengthy,
    pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL]),
    pytest.mark.parametrize("experiment", SHORT),
]


def planned(experiment):
    return load_plan(experiment, [*SHORT[experiment], *NOTHING], configs=CONFIGS)


def test_a_killed_run_has_every_cycle_that_was_recorded(tmp_path, experiment, backend):
    whole = run_experiment(planned(experiment), backend, tmp_path / "whole", report=False).path
    whole = read_log(whole / "log.mcap")
    generator = np.random.default_rng(17)
    lengths = []
    for trial in range(KILLS):
        folder = kill_in_mid_run(planned(experiment), backend, tmp_path / str(trial), generator)
        log = read_log(folder.log_path)
        assert is_the_beginning_of(log, whole)
        lengths.append(len(log.t))
    assert np.ptp(lengths) > 1000  # killed early and late
    print(f"{experiment} on {backend.value}: {KILLS} kills, whole to cycle {sorted(lengths)}")  # noqa: T201


def test_a_full_disk_leaves_a_log_that_is_whole_to_its_end(tmp_path, experiment, backend):
    if not may_mount(tmp_path):
        pytest.skip("this machine lets nobody mount a small disk")
    whole = run_experiment(planned(experiment), backend, tmp_path / "whole", report=False).path
    size = (whole / "log.mcap").stat().st_size
    whole = read_log(whole / "log.mcap")
    generator = np.random.default_rng(28)
    ends = []
    for trial in range(FULL_DISKS):
        kept, disk = tmp_path / f"kept{trial}", tmp_path / f"disk{trial}"
        kept.mkdir()
        disk.mkdir()
        room = int(size * generator.uniform(0.2, 0.9))
        options = [o for line in (*SHORT[experiment], *NOTHING) for o in ("--set", line)]
        words = ["run", experiment, "--on", backend.value, "--no-report", "--configs", str(CONFIGS)]
        program = [sys.executable, "-m", "rig", *words, "--out", str(disk), *options]
        done = on_a_small_disk(room // os.sysconf("SC_PAGESIZE") * 4 * 1024, disk, kept, program)
        assert "Traceback" not in done.stderr
        assert done.returncode == 4, done.stderr
        (path,) = kept.iterdir()
        folder = RunFolder.open(path)
        assert folder.status.value == "faulted"
        cut = read_log(folder.log_path)
        assert is_whole(cut)
        assert len(cut.t) < len(whole.t)
        assert is_the_beginning_of(cut, whole)
        ends.append(len(cut.t))
    print(f"{experiment} on {backend.value}: {FULL_DISKS} full disks, whole to {sorted(ends)}")  # noqa: T201
