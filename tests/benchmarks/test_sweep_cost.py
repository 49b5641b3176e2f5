"""What a sweep costs beside its points, as ratios of things measured in one run.

Points that wait for a second show all that stands around them, however busy the machine is; points
that work for one show what two processors are worth, on a machine that has nothing else to do.
`pytest -m benchmark -s -n 0 tests/benchmarks/test_sweep_cost.py`
"""

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rig.sweeping.axis import parse_seeds
from rig.sweeping.best import Best
from rig.sweeping.coordinator import Coordinator, Limits
from rig.sweeping.design import make_design
from rig.sweeping.engine import WorkerSetup
from rig.sweeping.journal import Journal
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.sweeping.result import SweepEnd, SweepRows, write_sweep
from rig.sweeping.run import _tasks
from rig.sweeping.source import PointSource, freeze_configs

CONFIGS = Path(__file__).parents[2] / "configs"


def work():
    """Keep one processor busy."""
    total = 0
    for number in range(LOOPS):
        total += number * number % 7
    return total


def wait():
    """Take a second, and no processor."""
    time.sleep(1.0)


def perform_waiting(job):
    wait()
    return perform_at_once(job)


def perform_working(job):
    work()
    return perform_at_once(job)


def perform_at_once(job):
    return {"point": job.name, "status": "ok", "reason": "", "metrics": [
        {"name": f"metric_{k}", "value": 0.1 * k, "unit": "m", "bound": None, "kind": None}
        for k in range(8)
    ]}  # fmt: skip


LOOPS = 8_000_000
"""About a second."""


def by_hand(point):
    """Return what a second process is worth here, with no sweep around it."""
    with multiprocessing.get_context("fork").Pool(2) as processes:
        spent = []
        for together in (1, 2):
            began = time.perf_counter()
            for _ in range(12 // together):
                processes.map(at_once, [point] * together, chunksize=1)
            spent.append(time.perf_counter() - began)
    return spent[0] / spent[1]


def at_once(point):
    """Run a point in a process of its own."""
    point()


@pytest.fixture
def engine_of(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parent)

    def make(workers, what):
        return Pool(workers, WorkerSetup(f"test_sweep_cost:{what}"))

    return make


def sweep_through(engine, folder, count):
    """Run points as `rig sweep` does, from loading their settings to the table; return the time."""
    configs = folder / "configs"
    experiment = freeze_configs("cylinder-sine", CONFIGS, configs)
    source = PointSource(experiment, (), None, "sim", "code")
    design = make_design([], parse_seeds(f"0:{count}"))
    journal = Journal(folder)
    try:
        best = Best(None, 3, folder / "runs")
        progress = SweepProgress(count, quiet=True)
        coordinator = Coordinator(journal, engine, progress, Limits(), best)
        began = time.perf_counter()
        coordinator.run(_tasks(source, design, configs, folder / "runs"))
        spent = time.perf_counter() - began
        found = write_sweep(
            folder, SweepRows(design, coordinator, journal), SweepEnd.DONE, sys.stdout.write
        )
        assert len(found.data.points) == count
    finally:
        journal.close()
    return spent


@pytest.mark.benchmark
@pytest.mark.parametrize("what", ["waiting", "working"])
def test_workers_and_what_a_point_costs_besides(engine_of, tmp_path, table, what):
    if what == "working" and os.getloadavg()[0] > 0.5:
        pytest.skip("the processors have other work: this would measure their neighbours")
    point = {"waiting": wait, "working": work}[what]
    began = time.perf_counter()
    for _ in range(4):
        point()
    alone = (time.perf_counter() - began) / 4
    spent = {}
    for workers in (1, 2):
        engine = engine_of(workers, f"perform_{what}")
        sweep_through(engine, tmp_path / f"warm{workers}", 2 * workers)
        spent[workers] = sweep_through(engine, tmp_path / str(workers), 12)
        engine.close()
    besides = spent[1] / 12 / alone - 1.0
    table(what=f"a point that is {what}", seconds=alone)
    table(what="besides, of it", ratio=besides)
    table(what="two workers over one", ratio=spent[1] / spent[2])
    table(what="two processes by hand over one", ratio=by_hand(point))
    assert besides <= 0.05
    assert spent[1] / spent[2] >= 1.85


@pytest.mark.benchmark
def test_dask_beside_the_pool(engine_of, tmp_path, table, monkeypatch):
    from distributed import LocalCluster

    from rig.sweeping.dask_cluster import DaskCluster

    monkeypatch.syspath_prepend(Path(__file__).parent)
    engine = engine_of(2, "perform_waiting")
    sweep_through(engine, tmp_path / "warm", 4)
    pool = sweep_through(engine, tmp_path / "pool", 12)
    engine.close()
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        setup = WorkerSetup("test_sweep_cost:perform_waiting")
        engine = DaskCluster(cluster.scheduler_address, setup, CONFIGS)
        sweep_through(engine, tmp_path / "warm-dask", 4)
        dask = sweep_through(engine, tmp_path / "dask", 12)
        engine.close()
    table(what="Dask over the pool", ratio=dask / pool)
    assert dask / pool <= 1.1


COUNTS = (10, 100, 1000, 10_000)


def cost_of(folder, count):
    """Run points that cost nothing; write the processor time and the greatest memory."""
    engine = Pool(1, WorkerSetup("test_sweep_cost:perform_at_once"))
    sweep_through(engine, folder, 5)
    (folder / "points.jsonl").unlink()
    began = time.process_time()
    sweep_through(engine, folder, count)
    spent = time.process_time() - began
    engine.close()
    # Since it was begun: `ru_maxrss` has that of who forked it, too.
    told = Path("/proc/self/status").read_text(encoding="utf-8")
    sys.stdout.write(f"{spent} {told.partition('VmHWM:')[2].split()[0]}\n")


@pytest.mark.benchmark
def test_time_is_linear_and_memory_flat(tmp_path, table):
    found = {}
    for count in COUNTS:
        shown = subprocess.run(
            [sys.executable, __file__, tmp_path / str(count), str(count)],
            capture_output=True, text=True, check=True,
        ).stdout.split()  # fmt: skip
        found[count] = float(shown[0]), float(shown[1])
        spent, memory = found[count]
        table(what=f"{count} points", ms_each=1e3 * spent / count, MB=memory / 1024)
    each = {count: found[count][0] / count for count in COUNTS}
    assert each[10_000] <= 1.2 * max(each[100], each[1000])
    assert found[10_000][1] <= 1.1 * found[10][1]


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    cost_of(Path(sys.argv[1]), int(sys.argv[2]))
