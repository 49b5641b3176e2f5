"""What ends a program ends each command alike, from its first import to its last figure."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

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
TOLD_AT_ONCE = """
from rig import cli
inside = cli._run
def told(arguments):
    os.kill(os.getpid(), NUMBER)
    return inside(arguments)
cli._run = told
"""


def environment(number):
    return {**os.environ, "NUMBER": f"{int(number)}"}


def run_of(folder):
    (run,) = (folder / "runs").iterdir()
    manifest = json.loads((run / "manifest.json").read_text())
    return run, manifest["status"]


@pytest.mark.parametrize("number", ENDS)
@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["--help"], ""),
        (SHORT, "click"),
        (SHORT, "rig.experiment.run"),
        (["check", "cylinder"], "rig.cli.check"),
    ],
    ids=["help", "click", "run", "check"],
)
def test_while_it_imports(words, name, number, tmp_path):
    """Of what comes before the handlers, that is Python's own start, nothing can be asked."""
    program = f"""{EARS}
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r} and not hasattr(sys, "told"):
            sys.told = True
            os.kill(os.getpid(), NUMBER)
            time.sleep(0.02)
sys.meta_path.insert(0, Finder())
{"from rig import cli" if name else TOLD_AT_ONCE}
cli.main()
"""
    ended = subprocess.run(
        [sys.executable, "-c", program, *words],
        cwd=tmp_path, env=environment(number), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (ended.returncode, ended.stderr.split()) == (130, ["Interrupted."])
    assert not (tmp_path / "runs").exists()


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


@pytest.mark.parametrize("number", ENDS)
def test_before_its_first_cycle(number, tmp_path):
    program = f"""{EARS}
from rig.experiment import run
inside = run.create_folder
def told(*arguments):
    folder = inside(*arguments)
    os.kill(os.getpid(), NUMBER)
    return folder
run.create_folder = told
from rig.cli import main; main()
"""
    ended = warm_start.run(SHORT, program, folder=tmp_path, environment=environment(number))
    run, status = run_of(tmp_path)
    assert (ended.returncode, status) == (130, "aborted")
    left = f"ended before its first cycle: nothing was moved; it left runs/{run.name}"
    assert ended.stderr.splitlines() == [left, "", "Interrupted."]  # begun anew after ^C
    told = warm_start.run(["explain", run], folder=tmp_path)
    assert "Somebody stopped it before its first cycle: nothing was moved." in told.stdout
    assert "made safe" not in told.stdout and "rig report" not in told.stdout


@pytest.mark.parametrize("number", ENDS)
def test_while_it_draws(number, tmp_path):
    program = f"""{EARS}
os.sched_getaffinity = lambda _: {{0, 1}}
from rig.report import ready
def draws(path):
    (path / "figures").mkdir()
    (path / "figures" / "drawer").write_text(f"{{os.getpid()}}")
    os.kill(os.getppid(), NUMBER)
    time.sleep(300.0)
ready.written = draws
from rig.cli import main; main()
"""
    ended = warm_start.run(SHORT, program, folder=tmp_path, environment=environment(number))
    run, status = run_of(tmp_path)
    assert ended.returncode == 130 and status in ("ok", "failed")
    assert ended.stderr.splitlines()[-1] == "Interrupted." and "Traceback" not in ended.stderr
    assert f"the run is whole in runs/{run.name}, its figures are not" in ended.stderr
    assert f"draw them with: rig report runs/{run.name}" in ended.stderr
    drawer = (run / "figures" / "drawer").read_text()
    assert not Path("/proc", drawer).exists()


def test_what_is_ignored_ends_nothing(tmp_path):
    """`nohup rig run` outlives its terminal."""
    program = f"""{EARS}
signal.signal(NUMBER, signal.SIG_IGN)
{TOLD_AT_ONCE}
cli.main()
"""
    ended = warm_start.run(["--help"], program, environment=environment(signal.SIGHUP))
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("number", ENDS)
def test_a_second_one_while_python_ends_changes_nothing(number):
    program = f"""{EARS}
import atexit
atexit.register(lambda: os.kill(os.getpid(), NUMBER))
{TOLD_AT_ONCE}
cli.main()
"""
    ended = warm_start.run(["--help"], program, environment=environment(number))
    assert (ended.returncode, ended.stderr) == (130, "Interrupted.\n")
