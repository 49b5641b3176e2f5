"""Ctrl-C ends a comparison: what was measured is kept, and what was interrupted is called so."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

OWN = [
    "--set", "reference.tones=[{frequency: 1 Hz, periods: 2}]",
    "--set", "metrics={tracking_rms: {}}", "--set", "figures=[timing]", "--on", "sim", "--json",
]  # fmt: skip
ONE_IS_LONG = ["--vary", "approach=1 s,600 s"]
"""The first is done at once, the other takes minutes."""


def begun(folder, *more):
    """Start a comparison as a terminal does: with a process group of its own."""
    words = [sys.executable, "-m", "rig", "compare", "cylinder-sine", *OWN, *more]
    with (folder / "err").open("w") as err, (folder / "out").open("w") as out:
        return subprocess.Popen(words, cwd=folder, stdout=out, stderr=err, start_new_session=True)


def wait_for(folder, process, *, said="", running=0):
    """Wait until something is said, and so many runs are recorded and go on."""
    until = time.monotonic() + 120.0
    while time.monotonic() < until and process.poll() is None:
        going = [
            path
            for path in folder.glob("runs/*/manifest.json")
            if json.loads(path.read_text())["status"] == "running"
        ]
        recorded = sum((path.parent / "log.mcap").exists() for path in going)
        if said in (folder / "err").read_text() and recorded >= running:
            return
        time.sleep(0.02)
    pytest.fail((folder / "err").read_text())


def processes_in(folder):
    """Return the processes that work in a folder after some time for them to end."""
    until, found = time.monotonic() + 30.0, [""]
    while found and time.monotonic() < until:
        found = []
        for process in Path("/proc").iterdir():
            with contextlib.suppress(OSError):
                if process.name.isdigit() and (process / "cwd").readlink() == folder:
                    found.append(process.name)
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_was_done_is_kept_and_what_was_not_is_no_fault(number, tmp_path):
    process = begun(tmp_path, *ONE_IS_LONG)
    wait_for(tmp_path, process, said="1 of 2 done")
    os.killpg(process.pid, number)  # as Ctrl-C does, of the whole group
    assert process.wait(30) == 130
    err, content = (tmp_path / "err").read_text(), json.loads((tmp_path / "out").read_text())
    assert "interrupted: 1 of 2 runs were done" in err and "Traceback" not in err
    assert content["labels"] == ["approach 1 s"] and content["metrics"]
    assert "faulted" not in err and not content["faulted"]
    (kept,) = tmp_path.glob("runs/*-compare/compare.json")
    assert json.loads(kept.read_text())["labels"] == ["approach 1 s"]
    ended = [json.loads(path.read_text()) for path in tmp_path.glob("runs/*/manifest.json")]
    assert {manifest["status"] for manifest in ended} <= {"ok", "failed", "aborted"}
    assert processes_in(tmp_path) == []


def test_no_run_begins_after_it_and_those_that_go_on_are_stopped(tmp_path):
    process = begun(tmp_path, "--vary", "approach=598 s,599 s,600 s")
    wait_for(tmp_path, process, running=1)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(30) == 130
    assert "interrupted: 0 of 3 runs were done" in (tmp_path / "err").read_text()
    ended = [json.loads(path.read_text()) for path in tmp_path.glob("runs/*/manifest.json")]
    assert 1 <= len(ended) <= 2
    assert {manifest["status"] for manifest in ended} == {"aborted"}


def test_workers_end_with_a_comparison_that_is_killed(tmp_path):
    process = begun(tmp_path, "--vary", "approach=598 s,599 s")
    wait_for(tmp_path, process, running=1)
    process.kill()
    process.wait(30)
    assert processes_in(tmp_path) == []
