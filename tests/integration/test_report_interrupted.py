"""A report that is ended, or whose processes are, leaves no process, no file, and no traceback."""

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import warm_start

from rig.whole_file import clear_left_over

DRAW = """
import os, sys, time
import rig.report.figures as figures
drawn = figures._draw
def slow(run, folder, name):
    Path = type(folder)
    begun = folder / f".{os.getpid()}.{name}.png"
    folder.mkdir(exist_ok=True)
    try:
        begun.touch()
        (run.folder.path.parent / f"draws-{os.getpid()}").touch()
        time.sleep(SLEEP)
        return drawn(run, folder, name)
    finally:
        begun.unlink(missing_ok=True)
figures._draw = slow
os.sched_getaffinity = lambda _: {0, 1}
from rig.cli import main
main()
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    words = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", folder / "runs"]
    ended = warm_start.run(words, folder=folder)
    assert ended.returncode == 0, ended.stderr
    return next((folder / "runs").iterdir())


@pytest.fixture
def run(recorded, tmp_path):
    copy = tmp_path / "run"
    subprocess.run(["cp", "-r", recorded, copy], check=True)
    return copy


def wait_until(holds, patience=60.0):
    until = time.monotonic() + patience
    while time.monotonic() < until:
        if found := holds():
            return found
        time.sleep(0.02)
    pytest.fail(f"in vain: {holds.__name__}")


def drawing(run):
    """Return the processes that draw, of which there are two."""
    return [int(path.name[6:]) for path in run.parent.glob("draws-*")]


def begun_files(run):
    return [path for path in (run / "figures").iterdir() if path.name.startswith(".")]


def is_there(process):
    with contextlib.suppress(FileNotFoundError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def report(run, sleep):
    with (run.parent / "err").open("w") as err:
        return warm_start.WarmProcess(
            ["report", run], DRAW.replace("SLEEP", str(sleep)), stdout=err, stderr=err
        )


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_what_draws_ends_with_what_waits_for_it(number, run):
    process = report(run, 300.0)
    drawers = wait_until(lambda: len(found := drawing(run)) == 2 and found)
    os.kill(process.pid, number)
    code = process.wait()
    wait_until(lambda: not any(map(is_there, drawers)))
    assert not begun_files(run)  # they heard it, and took away what they had begun
    said = (run.parent / "err").read_text()
    if number == signal.SIGKILL:
        assert not said
    else:
        assert (code, said.split()) == (130, ["Interrupted."])


@pytest.mark.parametrize("seed", [1, 2])
def test_what_a_killed_process_was_drawing_is_drawn_again(seed, run):
    process = report(run, 2.0)
    drawers = wait_until(lambda: len(found := drawing(run)) == 2 and found)
    drawn = random.Random(seed)
    for one in drawn.sample(drawers, seed):
        os.kill(one, signal.SIGKILL)
    assert process.wait() == 0, (run.parent / "err").read_text()
    assert "cannot be drawn" not in (run.parent / "err").read_text()
    pictures = {path.stem for path in (run / "figures").glob("*.png")}
    page = (run / "report.html").read_text()
    assert {"timing", "tracking"} <= pictures and all(name in page for name in pictures)
    assert not begun_files(run)


LOST = """
import os, signal
import rig.report.figures as figures
drawn, bad = figures._draw, BAD
def killed(run, folder, name):
    if bad in ("all", name):
        os.kill(os.getpid(), signal.SIGKILL)
    return drawn(run, folder, name)
figures._draw = killed
os.sched_getaffinity = lambda _: {0, 1}
from rig.cli import main
main()
"""


@pytest.mark.parametrize(("bad", "code"), [("all", 1), ("tracking", 0)])
def test_a_report_without_any_of_its_figures_has_not_gone_well(bad, code, run):
    with (run.parent / "err").open("w") as err:
        words = ["report", run]
        process = warm_start.WarmProcess(
            words, LOST.replace("BAD", repr(bad)), stdout=err, stderr=err
        )
        assert process.wait() == code
    said = (run.parent / "err").read_text()
    assert "the figure tracking cannot be drawn: the process that drew it was ended by" in said
    assert str(run / "report.html") in said and (run / "report.html").exists()


def of_the_dead():
    """Return the number of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_report_takes_away_what_the_dead_have_left_and_nothing_else(run):
    folder = run / "figures"
    folder.mkdir()
    dead = of_the_dead()
    left = [folder / f".{dead}.timing.png", run / f".{dead}.report.html"]
    kept = [
        folder / f".{os.getpid()}.x.png",
        folder / ".gitignore",
        folder / f".{dead}",
        run / "7.a",
    ]
    for path in (*left, *kept):
        path.write_text("content")
    ended = warm_start.run(["report", run])
    assert ended.returncode == 0, ended.stderr
    assert not any(path.exists() for path in left)
    assert all(path.read_text() == "content" for path in kept)


def test_a_folder_that_is_a_link_is_nobodys_to_clear(tmp_path):
    (tmp_path / "theirs").mkdir()
    kept = tmp_path / "theirs" / f".{of_the_dead()}.a"
    kept.touch()
    (tmp_path / "figures").symlink_to("theirs")
    clear_left_over(tmp_path / "figures")
    assert kept.exists()


EXPORT = """
import time
import rig.export
def slow(file, path):
    path.write_bytes(b"begun")
    path.with_name("begins").touch()
    time.sleep(300.0)
rig.export.FORMATS["npz"] = slow
from rig.cli import main
main()
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP])
def test_an_export_that_is_ended_leaves_nothing_to_the_next(number, run):
    with (run.parent / "err").open("w") as err:
        words = ["export", run, "--format", "npz"]
        process = warm_start.WarmProcess(words, EXPORT, stdout=err, stderr=err)
        wait_until((run / "begins").exists)
        os.kill(process.pid, number)
        code = process.wait()
    left = [path.name for path in run.iterdir() if path.name.startswith(".")]
    said = (run.parent / "err").read_text()
    if number == signal.SIGKILL:
        assert len(left) == 1
    else:
        assert (code, said.split(), left) == (130, ["Interrupted."], [])
    ended = warm_start.run(["export", run, "--format", "npz"])
    assert ended.returncode == 0, ended.stderr
    assert not [path.name for path in run.iterdir() if path.name.startswith(".")]
