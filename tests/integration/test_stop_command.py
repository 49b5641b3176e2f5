"""A run is stopped from another terminal: in an orderly way, at once, and no other process is."""

import subprocess
import sys
import time

import numpy as np
import pytest

from rig.run_folder import RunFolder, RunStatus
from rig.runtime.log import read_log
from rig.stopping import CannotStop, request_stop


def start(out, experiment="cylinder-sine"):
    """Start a run in real time; return its process and its folder once its loop goes round."""
    command = [sys.executable, "-m", "rig", "run", experiment, "--on", "sim", "--pace", "1"]
    process = subprocess.Popen(
        [*command, "--no-report", "--out", str(out)], stderr=subprocess.DEVNULL
    )
    until = time.monotonic() + 120
    while time.monotonic() < until and process.poll() is None:
        for folder in out.glob("*/log.mcap"):
            if folder.stat().st_size > 100_000:
                return process, folder.parent
        time.sleep(0.02)
    raise AssertionError(f"no run: {process.poll()}")


def stop(runs, *arguments):
    command = [sys.executable, "-m", "rig", "stop", "--runs", str(runs), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [([], "stopped by the operator"), (["--at-once"], "stopped at once")],
)
def test_the_run_that_goes_on_is_stopped(tmp_path, arguments, message):
    process, path = start(tmp_path)
    said = stop(tmp_path, *arguments)
    assert process.wait(30) == 130
    assert said.returncode == 0, said.stderr
    assert str(process.pid) in said.stderr
    folder = RunFolder.open(path)
    assert folder.status is RunStatus.ABORTED
    assert message in str(folder.manifest["message"])
    log = read_log(path / "log.mcap")
    assert log.complete
    stopping = log.column("phase") == 2.0
    lasted = np.ptp(log.t[stopping]) if stopping.any() else 0.0
    # Braking, settling and release take their time; two signals only as long as both are heard.
    assert lasted < 0.4 if arguments else lasted > 0.4
    assert stop(tmp_path).returncode == 1
    with pytest.raises(CannotStop, match="not running"):
        request_stop(path, at_once=False)


def test_of_two_runs_one_is_named_or_all_are(tmp_path):
    first, _ = start(tmp_path / "a")
    second, path = start(tmp_path / "b")
    both = tmp_path / "both"
    both.mkdir()
    for folder in (*(tmp_path / "a").iterdir(), *(tmp_path / "b").iterdir()):
        (both / f"{folder.parent.name}-{folder.name}").symlink_to(folder)
    assert stop(both).returncode == 2
    assert stop(both, f"b-{path.name}").returncode == 0
    assert second.wait(30) == 130
    assert first.poll() is None
    assert stop(both, "--all").returncode == 0
    assert first.wait(30) == 130


def test_who_only_reads_the_folder_of_a_run_that_ended_is_left_alone(tmp_path):
    folder = RunFolder.create(tmp_path, "wait", "sim", inputs={})
    folder.finish(RunStatus.OK, 0)
    with (folder.path / "events.jsonl").open("rb"), pytest.raises(CannotStop, match="not running"):
        request_stop(folder.path, at_once=True)
