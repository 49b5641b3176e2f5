"""What a sweep costs beside its points, as ratios of things measured in one run.

Points are a known amount of work, as processor time of one function: what is measured is all that
stands around them. `pytest -m benchmark -s -n 0 tests/benchmarks/test_sweep_cost.py`
"""

import resource
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


def work(loops):
    """Keep one processor busy for a while that depends on the machine alone."""
    total = 0
    for number in range(loops):
        total += number * number % 7
    return total


def perform(job):
    work(LOOPS)
    return {"point": job.name, "status": "ok", "reason": "", "metrics": [
        {"name": f"metric_{k}", "value": 0.1 * k, "unit": "m", "bound": None, "kind": None}
        for k in range(8)
    ]}  # fmt: skip


def perform_at_once(job):
    return {"point": job.name, "status": "ok", "reason": "", "metrics": [
        {"name": "rms", "value": 0.1, "unit": "m", "bound": None, "kind": None}
    ]}  # fmt: skip


LOOPS = 8_000_000
"""About a second."""


@pytest.fixture
def engine_of(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parent)

    def make(workers, what="perform"):
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
def test_workers_and_what_a_point_costs_besides(engine_of, tmp_path, table):
    began = time.perf_counter()
    for _ in range(4):
        work(LOOPS)
    alone = (time.perf_counter() - began) / 4
    spent = {}
    for workers in (1, 2):
        engine = engine_of(workers)
        sweep_through(engine, tmp_path / f"warm{workers}", 2 * workers)
        spent[workers] = sweep_through(engine, tmp_path / str(workers), 12)
        engine.close()
    besides = spent[1] / 12 / alone - 1.0
    table(what="a point of work", seconds=alone)
    table(what="besides, of it", ratio=besides)
    table(what="two workers over one", ratio=spent[1] / spent[2])
    assert besides <= 0.05
    assert spent[1] / spent[2] >= 1.85


@pytest.mark.benchmark
def test_dask_beside_the_pool(engine_of, tmp_path, table, monkeypatch):
    from distributed import LocalCluster

    from rig.sweeping.dask_cluster import DaskCluster

    monkeypatch.syspath_prepend(Path(__file__).parent)
    engine = engine_of(2)
    sweep_through(engine, tmp_path / "warm", 4)
    pool = sweep_through(engine, tmp_path / "pool", 12)
    engine.close()
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        setup = WorkerSetup("test_sweep_cost:perform")
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
    sys.stdout.write(f"{spent} {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}\n")


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
    assert found[10_000][0] / found[1000][0] <= 11.0
    assert found[10_000][1] <= 1.1 * found[10][1]


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    cost_of(Path(sys.argv[1]), int(sys.argv[2]))
