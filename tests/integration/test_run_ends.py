"""Every way out of a run: same seed same bytes, Ctrl-C once and twice, SIGTERM, SIGKILL."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import warm_start
from killed_runs import kill_in_mid_run

from rig.assembly import Backend
from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.report.regenerate import write_report
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = [
    "reference.tones=[{frequency: 1 Hz, periods: 3}]",
    "metrics={tracking_rms: {}, pressure_max: {}}",
]
WALL_CLOCK = "timing."
"""Columns that measure this machine, not the rig."""


def plan(*options):
    return load_plan("cylinder-sine", [*SHORT, *options], configs=CONFIGS)


def rig_run(out):
    """Return the words after `rig` of a short run."""
    shorter = ("reference.tones=[{frequency: 2 Hz, periods: 2}]", "approach=0.5 s", SHORT[1])
    options = [word for option in shorter for word in ("--set", option)]
    where = ["--configs", str(CONFIGS), "--out", str(out)]
    return ["run", "cylinder-sine", "--no-report", *where, *options]


def run_folder(out):
    (folder,) = out.iterdir()
    return folder


def test_same_seed_gives_the_same_bytes_whatever_the_machine_does(tmp_path):
    assert invoke(rig_run(tmp_path / "first")) == 0
    burner = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        second = warm_start.run(rig_run(tmp_path / "second"))
    finally:
        burner.kill()
        burner.wait()
    assert second.returncode == 0, second.stderr
    folders = [run_folder(tmp_path / name) for name in ("first", "second")]
    metrics = [(folder / "metrics.json").read_bytes() for folder in folders]
    assert metrics[0] == metrics[1]
    logs = [read_log(folder / "log.mcap") for folder in folders]
    names = [c.name for c in logs[0].columns if not c.name.startswith(WALL_CLOCK)]
    assert any(name.startswith("truth.") for name in names)
    for name in names:
        assert logs[0].column(name).tobytes() == logs[1].column(name).tobytes(), name


def test_another_seed_gives_other_readings(tmp_path):
    logs = [
        read_log(
            run_experiment(
                plan(f"simulation.seed={seed}"), Backend.SIM, tmp_path, report=False
            ).path
            / "log.mcap"
        )
        for seed in (0, 1)
    ]
    assert not np.array_equal(*(log.column("reading.position") for log in logs))


@pytest.mark.parametrize(
    ("signals", "message"),
    [
        ([signal.SIGINT], "stopped by the operator"),
        ([signal.SIGTERM], "stopped by the operator"),
        ([signal.SIGINT, signal.SIGINT], "at once"),
    ],
    ids=["once", "term", "twice"],
)
def test_stop_request_leaves_a_safe_rig_and_a_whole_log(tmp_path, signals, message):
    class Operator(Watcher):
        """Presses Ctrl-C in mid-run."""

        asked, told = False, ()

        def progressed(self, progress):
            if progress.t > 1.0 and not self.asked:
                self.asked = True
                for number in signals:
                    os.kill(os.getpid(), number)

        def said(self, sentence):
            self.told += (sentence,)

    operator = Operator()
    result = run_experiment(plan(), Backend.VIRTUAL, tmp_path, watcher=operator)
    assert (result.exit_code, result.status.value) == (130, "aborted")
    assert not (result.path / "report.html").exists(), "whoever ends it does not wait for figures"
    assert operator.told[-1].endswith(f"rig report {result.path}")
    assert message in result.message
    log = read_log(result.path / "log.mcap")
    assert log.column("phase")[-1] == 2.0
    released = log.t[-1] - log.t[log.column("phase") == 1.0][-1]
    if len(signals) == 1:  # braked and held for half a second, then lowered in as much to vented
        assert released == pytest.approx(1.0, abs=0.01)
        assert log.column("applied.agonist")[-1] == 0.0
        assert np.abs(np.diff(log.column("applied.agonist")[-400:])).max() < 5e3
    else:
        assert released < 0.01


def kill_runs(tmp_path, trials, seed):
    """Kill so many runs at drawn moments; the report of the last one says what it was."""
    run_experiment(plan(), Backend.SIM, tmp_path / "warm", report=False)  # kernels compiled
    generator = np.random.default_rng(seed)
    for trial in range(trials):
        folder = kill_in_mid_run(plan(), Backend.VIRTUAL, tmp_path / str(trial), generator)
    assert write_report(folder.path).page.exists()
    manifest = json.loads((folder.path / "manifest.json").read_text())
    assert manifest["status"] == "crashed"


def test_killed_run_loses_no_recorded_cycle(tmp_path):
    kill_runs(tmp_path, 5, seed=7)


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("block", range(10))
def test_two_hundred_killed_runs_lose_no_recorded_cycle(tmp_path, block):
    kill_runs(tmp_path, 20, seed=[7, block])
