"""A log that is too long for the memory is exported as one that is held in it, in as little."""

import tracemalloc

import numpy as np
import pytest

from rig.export import export_run
from rig.hal.columns import Column
from rig.runtime import log, log_columns
from rig.runtime.recorder import LogRecorder

COLUMNS = [Column(f"device.value{k}", "m", "a number") for k in range(12)]


@pytest.fixture
def run_of(make_run):
    """Make a run of so many rows."""

    def of(rows):
        run = make_run(f"of-{rows}", duration=0.1)
        (run / "log.mcap").unlink()
        with LogRecorder(run / "log.mcap", COLUMNS) as recorder:
            for k in range(rows):
                recorder.write(k, 1e-3 * k, [0.1 * k + n for n in range(len(COLUMNS))])
        return run

    return of


@pytest.mark.parametrize("format", ["npz", "mat"])
def test_a_long_log_is_exported_as_a_short_one(run_of, tmp_path, monkeypatch, format):
    run = run_of(8_000)
    short = export_run(run, format, tmp_path / "short").path.read_bytes()
    monkeypatch.setattr(log_columns, "_SHORT", 0)
    monkeypatch.setattr(log_columns, "_PIECE", 999)
    long = export_run(run, format, tmp_path / "long").path
    if format == "npz":
        with np.load(tmp_path / "short") as ours, np.load(long) as theirs:
            assert ours.files == theirs.files
            for name in ours.files:
                assert ours[name].dtype == theirs[name].dtype
                np.testing.assert_array_equal(ours[name], theirs[name])
    else:  # beyond its head, which has the date
        assert long.read_bytes()[128:] == short[128:]


@pytest.mark.parametrize("format", ["csv", "npz"])
def test_memory_does_not_grow_with_the_log(run_of, tmp_path, monkeypatch, format):
    monkeypatch.setattr(log_columns, "_SHORT", 0)
    monkeypatch.setattr(log_columns, "_PIECE", 1_000)
    monkeypatch.setattr(log, "_AT_ONCE", 1 << 16)
    export_run(run_of(9), format, tmp_path / "first")  # imports what it needs
    most = {}
    for rows in (8_000, 32_000):
        run = run_of(rows)
        tracemalloc.start()
        export_run(run, format, tmp_path / f"of-{rows}")
        most[rows] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert most[32_000] < 1.2 * most[8_000]
