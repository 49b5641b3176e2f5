"""What ends a program ends each command alike, from its first import to its last figure."""

import json
import os
import signal

import pytest
import warm_start

SHORT = [
    "run", "cylinder-step", "--on", "sim", "--set", "reference.repeats=1",
    "--set", "reference.dwell=1 s", "--set", "reference.rise=0.2 s",
    "--set", "reference.size=3 mm", "--set", "approach=0.3 s", "--set", "figures=[timing]",
]  # fmt: skip
ENDS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
EARS = """
import os, signal, sys, time
from pathlib import Path
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job may ignore it
NUMBER = int(os.environ["NUMBER"])
"""


def environment(number):
    return {**os.environ, "NUMBER": f"{int(number)}"}


def run_of(folder):
    (run,) = (folder / "runs").iterdir()
    manifest = json.loads((run / "manifest.json").read_text())
    return run, manifest["status"]


BOOKS = f"""{EARS}
from rig.experiment import run
inside = run.write_results
def told(*arguments):
    os.kill(os.getpid(), NUMBER)
    return inside(*arguments)
run.write_results = told
"""
"""Somebody ends it when the loop has ended, and its books are not yet closed."""


@pytest.mark.parametrize("number", ENDS)
def test_when_the_motion_is_over(number, tmp_path):
    program = BOOKS + "from rig.cli import main; main()"
    ended = warm_start.run(SHORT, program, folder=tmp_path, environment=environment(number))
    run, status = run_of(tmp_path)
    assert ended.returncode == 130 and status in ("ok", "failed")
    *_, before, _, last = ended.stderr.splitlines()  # a line is begun anew after ^C
    assert before.endswith(f"rig report runs/{run.name}") and last == "Interrupted."
    assert json.loads((run / "metrics.json").read_text())
    assert not (run / "report.html").exists()


def test_a_fault_is_told_whoever_ends_it_meanwhile(tmp_path):
    fault = "simulation.faults=[{at: 0.5 s, device: regulators, fault: emergency_stop}]"
    program = BOOKS + "from rig.cli import main; main()"
    ended = warm_start.run(
        [*SHORT, "--set", fault], program, folder=tmp_path, environment=environment(signal.SIGTERM)
    )
    run, status = run_of(tmp_path)
    assert (ended.returncode, status) == (4, "faulted"), ended.stderr
    assert "faulted: " in ended.stderr and "Interrupted." not in ended.stderr
    assert not (run / "report.html").exists()


def test_a_program_that_asks_when_the_motion_is_over_has_its_run(tmp_path):
    program = """
import rig
from rig.experiment import run
stop = rig.StopRequests()
inside = run.write_results
def told(*arguments):
    stop.request()
    return inside(*arguments)
run.write_results = told
short = {"reference.repeats": 1, "reference.dwell": 1.0, "approach": 0.3}
short |= {"reference.size": 0.003, "reference.rise": 0.2, "figures": ["timing"]}
print(rig.run("cylinder-step", on="sim", set=short, stop=stop).status)
"""
    ended = warm_start.run([], program, folder=tmp_path)
    assert ended.stdout.strip() in ("ok", "failed"), ended.stderr
