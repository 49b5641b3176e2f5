"""The table of a sweep is the same bytes, wherever it ran and however often it was killed."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import sweep_stub

from rig.sweeping.errors import SweepStopped
from rig.sweeping.result import SweepEnd

pytestmark = pytest.mark.usefixtures("warm_workers")
STUB = Path(__file__).with_name("sweep_stub.py")
POINTS = 60
FILES = ("sweep.csv", "sweep.parquet")


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    monkeypatch.syspath_prepend(STUB.parent)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The files of a sweep that nothing disturbed, of one worker."""
    out = tmp_path_factory.mktemp("whole")
    sys.path.insert(0, str(STUB.parent))
    assert sweep_stub.sweep(out, 1, POINTS).end is SweepEnd.DONE
    sys.path.remove(str(STUB.parent))
    return [(out / name).read_bytes() for name in FILES]


def files(out):
    return [(out / name).read_bytes() for name in FILES]


def start(out, workers, *more):
    return subprocess.Popen(
        [sys.executable, STUB, out, str(workers), str(POINTS), *more], start_new_session=True
    )


def finished(out):
    try:
        return (out / "points.jsonl").read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def children(pid):
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.append(int(folder.name))
    return found


def kill_one(process, whom):
    """Kill the coordinator, its server of workers, or one worker."""
    servers = children(process.pid)
    victims = {
        "coordinator": [process.pid],
        "server": servers,
        "worker": [worker for server in servers for worker in children(server)],
    }[whom]
    if victims:
        os.kill(random.Random(time.monotonic_ns()).choice(victims), signal.SIGKILL)


def sweep_with_kills(out, workers, seed, kills):
    """Kill something as often as it takes, at points drawn from the seed, and go on each time."""
    chance = random.Random(seed)
    moments = sorted(chance.sample(range(POINTS), kills))
    process = start(out, workers)
    for moment in moments:
        while process.poll() is None and finished(out) < moment:
            time.sleep(0.002)
        time.sleep(chance.uniform(0.0, 0.02))
        whom = chance.choice(("coordinator", "server", "worker", "worker"))
        kill_one(process, whom)
        if whom == "coordinator":
            process.wait()
        if process.poll() is not None:
            process = start(out, workers)
    assert process.wait() == 0


@pytest.mark.parametrize("workers", [2, 8])
def test_more_workers_write_the_same(tmp_path, whole, workers):
    sweep_stub.sweep(tmp_path, workers, POINTS)
    assert files(tmp_path) == whole


def test_killed_at_drawn_moments_it_writes_the_same(tmp_path, whole):
    sweep_with_kills(tmp_path, 2, seed=1, kills=4)
    assert files(tmp_path) == whole


@pytest.mark.slow
@pytest.mark.lengthy
@pytest.mark.parametrize("seed", range(10))
def test_killed_fifty_times_it_writes_the_same(tmp_path, whole, seed):
    sweep_with_kills(tmp_path, 1 + seed % 3, seed, kills=5)
    assert files(tmp_path) == whole


def test_interrupted_it_leaves_what_is_finished_and_goes_on(tmp_path, whole):
    sweep_stub.sweep(tmp_path, 2, 2)
    drawn = [tmp_path / name for name in ("sweep.html", "sweep.png", "sweep.pdf", "sweep.svg")]
    assert all(path.is_file() for path in drawn)
    process = start(tmp_path, 2)
    while finished(tmp_path) < POINTS // 3 + 2:  # the two of before run again where they fell
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGINT)
    assert process.wait() == 0
    lines = (tmp_path / "sweep.csv").read_text().splitlines()
    assert POINTS // 3 <= len(lines) - 1 < POINTS
    # Who interrupts does not wait for a figure, and finds none that is older than the table.
    assert not any(path.exists() for path in drawn)
    sweep_stub.sweep(tmp_path, 2, POINTS)
    assert files(tmp_path) == whole


def test_no_point_runs_twice_and_a_new_value_runs_only_what_is_new(tmp_path):
    sweep_stub.sweep(tmp_path, 2, 10)
    journal = (tmp_path / "points.jsonl").read_bytes()
    assert journal.count(b"\n") == 10
    sweep_stub.sweep(tmp_path, 2, 10)
    assert (tmp_path / "points.jsonl").read_bytes() == journal
    found = sweep_stub.sweep(tmp_path, 2, 14)
    assert finished(tmp_path) == 14
    assert len(found.table) == 14


def test_a_point_that_kills_its_workers_is_a_row_and_tried_again(tmp_path):
    # Which points kill is up to their names, and these to the code: of 60 some do.
    found = sweep_stub.sweep(tmp_path, 2, POINTS, what="dies")
    fallen = [row for row in found.table if row["status"] == "lost"]
    assert len(found.table) == POINTS and fallen
    assert all("workers died" in row["reason"] for row in fallen)
    again = sweep_stub.sweep(tmp_path, 2, POINTS)
    assert [row["status"] for row in again.table].count("lost") == 0


def test_a_full_disk_is_a_sentence(tmp_path):
    sweep_stub.sweep(tmp_path, 2, 10)
    with pytest.raises(SweepStopped) as stopped:
        sweep_stub.sweep(tmp_path, 2, 20, what="fills_the_disk")
    assert str(stopped.value) == (
        f"sweep: {tmp_path / 'runs'}: No space left on device; what is finished is kept, and the "
        "same command goes on from there"
    )
    assert finished(tmp_path) == 10


def test_it_ends_with_the_first_point_that_is_good_enough(tmp_path):
    from rig.sweeping.stop_rule import parse_stop_rule

    every = sweep_stub.sweep(tmp_path / "all", 1, POINTS).table
    bound = sorted(row["rise_time"] for row in every if row["rise_time"] is not None)[1]
    rule = parse_stop_rule(f"rise_time <= {bound!r} m")
    first = next(k for k, row in enumerate(every) if (row["rise_time"] or 1.0) <= bound)
    for workers in (1, 3):
        found = sweep_stub.sweep(tmp_path / str(workers), workers, POINTS, stop_when=rule)
        assert found.table == every[: first + 1]


def test_a_budget_is_kept_and_the_rest_comes_later(tmp_path, whole):
    found = sweep_stub.sweep(tmp_path, 2, POINTS, points=7)
    assert found.end is SweepEnd.BUDGET and len(found.table) == 7
    sweep_stub.sweep(tmp_path, 2, POINTS)
    assert files(tmp_path) == whole


def test_a_source_that_is_edited_meanwhile_changes_nothing_and_is_said(tmp_path):
    root = STUB.parents[2]
    copy = tmp_path / "program"
    for package in ("rig", "drivers", "controllers"):
        shutil.copytree(root / package, copy / package)
    shutil.copy(STUB, copy)
    environment = {
        **os.environ,
        "PYTHONPATH": str(copy),
        "SWEEP_STUB_CONFIGS": str(root / "configs"),
    }

    def begin(out):
        return subprocess.Popen(
            [sys.executable, copy / STUB.name, out, "2", str(POINTS), "loud"], env=environment,
            stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        )  # fmt: skip

    whole = begin(tmp_path / "whole")
    assert "source changed" not in whole.communicate()[1]
    process = begin(tmp_path / "edited")
    while finished(tmp_path / "edited") < POINTS // 3:
        time.sleep(0.002)
    (copy / "rig" / "spare_room.py").write_text("raise RuntimeError('edited')\n")
    kill_one(process, "worker")
    told = process.communicate()[1]
    assert process.returncode == 0
    assert "the source changed meanwhile (rig/spare_room.py)" in told
    assert files(tmp_path / "edited") == files(tmp_path / "whole")
