"""A sweep on a Dask cluster writes what one on this machine does, whatever dies of it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import sweep_stub

from rig.sweeping.dask_cluster import DaskCluster
from rig.sweeping.errors import SweepStopped

FOLDER = Path(__file__).parent
POINTS = 40


class Lost:
    """A result of a scheduler that goes while it is asked for it."""

    def __init__(self, status):
        self.status = status

    def result(self, timeout):
        raise ConnectionResetError(104, "Connection reset by peer")

    exception = result


@pytest.mark.parametrize("status", ["finished", "error", "lost"])
def test_a_scheduler_that_goes_while_it_is_asked_for_a_result_is_a_sentence(status):
    cluster = object.__new__(DaskCluster)
    cluster._address = "tcp://127.0.0.1:1"
    with pytest.raises(SweepStopped, match="the Dask scheduler has gone"):
        cluster._report("point", Lost(status))


def begin(*arguments):
    path = os.pathsep.join([str(FOLDER), *filter(None, sys.path)])
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]],
        env={**os.environ, "PYTHONPATH": path, "SWEEP_STUB_SECONDS": "0.05"},
        stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    """A scheduler, its file, and two workers of one thread."""
    monkeypatch.syspath_prepend(FOLDER)
    file = tmp_path / "scheduler.json"
    processes = [
        begin("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
              "--scheduler-file", str(file))
    ]  # fmt: skip
    while not file.exists():
        assert processes[0].poll() is None
        time.sleep(0.05)
    for number in range(2):
        processes.append(
            begin("worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard",
                  "--no-nanny", "--local-directory", str(tmp_path / str(number)))
        )  # fmt: skip
    yield str(file), processes
    for process in processes:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def files(out):
    return [(out / name).read_bytes() for name in ("sweep.csv", "sweep.parquet")]


def finished(out):
    return (out / "points.jsonl").read_bytes().count(b"\n")


def test_a_cluster_writes_the_same_though_a_worker_is_killed(tmp_path, cluster):
    file, processes = cluster
    sweep_stub.sweep(tmp_path / "pool", 1, POINTS)
    process = subprocess.Popen(
        [sys.executable, FOLDER / "sweep_stub.py", tmp_path / "dask", "1", str(POINTS), file]
    )
    journal = tmp_path / "dask" / "points.jsonl"
    while not journal.exists() or finished(tmp_path / "dask") < POINTS // 3:
        assert process.poll() is None
        time.sleep(0.005)
    processes[1].kill()
    assert process.wait() == 0
    assert files(tmp_path / "dask") == files(tmp_path / "pool")


def test_a_scheduler_that_goes_is_a_sentence_and_loses_nothing(tmp_path, cluster):
    file, processes = cluster
    sweep_stub.sweep(tmp_path / "pool", 1, POINTS)
    killer = subprocess.Popen(
        [sys.executable, "-c", f"""
import os, pathlib, time
journal = pathlib.Path({str(tmp_path / "dask" / "points.jsonl")!r})
while not journal.exists() or journal.read_bytes().count(b'\\n') < {POINTS // 4}:
    time.sleep(0.005)
os.kill({processes[0].pid}, 9)
"""]
    )  # fmt: skip
    with pytest.raises(SweepStopped, match="the Dask scheduler has gone"):
        sweep_stub.sweep(tmp_path / "dask", 1, POINTS, file)
    killer.wait()
    assert POINTS // 4 <= finished(tmp_path / "dask") < POINTS
    sweep_stub.sweep(tmp_path / "dask", 2, POINTS)
    assert files(tmp_path / "dask") == files(tmp_path / "pool")


def test_a_scheduler_of_another_version_is_refused(tmp_path, cluster, monkeypatch):
    import distributed

    monkeypatch.setattr(distributed, "__version__", "2020.1.0")
    with pytest.raises(SweepStopped, match="install the same"):
        sweep_stub.sweep(tmp_path / "dask", 1, 4, cluster[0])
