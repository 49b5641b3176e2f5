"""A report of a log that is too long for the memory."""

import csv
import json
import math
import shutil
import tracemalloc

import numpy as np
import pytest

from rig.experiment.measure import PHASE_RUN
from rig.report import envelope
from rig.report.data import load_run
from rig.report.figures import known_figures
from rig.report.regenerate import measure_run, write_report
from rig.report.timing import summarise_timing
from rig.run_facts import EVALUATION
from rig.runtime import log, log_columns, long_array
from rig.runtime.log import Log, read_log
from rig.runtime.log_columns import FiledColumns
from rig.runtime.long_array import LongArray
from rig.runtime.recorder import LogRecorder

ALL = 64 << 20


@pytest.fixture
def _all_is_long(monkeypatch):
    """Let some thousand cycles be what an hour is."""
    monkeypatch.setattr(log_columns, "_SHORT", 0)
    monkeypatch.setattr(log_columns, "_PIECE", 1 << 10)
    monkeypatch.setattr(log, "_AT_ONCE", 1 << 16)
    monkeypatch.setattr(envelope, "_SHORT_PATH", 1 << 12)
    monkeypatch.setattr(long_array, "LONG", 1 << 10)
    monkeypatch.setattr(long_array, "_FEW", 1 << 7)
    monkeypatch.setattr(long_array, "_PIECE", 1 << 10)


def lengthened(source, folder, times, spike=None):
    """Make a run folder of a run that goes on, and is off by 1 m in one cycle."""
    shutil.copytree(source, folder)
    for name in ("log.mcap", "metrics.json", "timing.json"):
        (folder / name).unlink(missing_ok=True)
    its = read_log(source / "log.mcap")
    rows = its.values[its.column("phase") == PHASE_RUN]
    names = [column.name for column in its.columns]
    period = float(np.median(np.diff(its.t)))
    with LogRecorder(folder / "log.mcap", its.columns) as recorder:
        for k in range(times * len(rows)):
            row = rows[k % len(rows)].copy()
            row[names.index("reference.time")] = k * period
            if k == spike:
                row[names.index("reading.position")] += 1.0
            recorder.write(k, k * period, row.tolist())
    told = json.loads((folder / EVALUATION).read_text())
    for segment in told["segments"]:
        segment["start"], segment["end"] = times * segment["start"], times * segment["end"]
    (folder / EVALUATION).write_text(json.dumps(told))
    return folder


def derive(folder):
    """Measure and draw all there is of a run, and write none of it."""
    run = load_run(folder)
    measured, _ = measure_run(run.folder, run.log)
    drawn = [figure for kind in known_figures("cylinder").values() if (figure := kind.draw(run))]
    return len(measured), len(drawn), len(summarise_timing(run.log))


@pytest.mark.usefixtures("_all_is_long")
def test_memory_does_not_grow_with_the_run(make_run, tmp_path):
    source = make_run(duration=4.0)
    assert derive(source) == (4, 5, 8)  # imports what it needs
    most = {}
    for times in (8, 64):
        folder = lengthened(source, tmp_path / f"of-{times}", times)
        tracemalloc.start()
        derive(folder)
        most[times] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    column = 8 * (load_run(folder).log.rows * (64 - 8) // 64)
    assert most[64] - most[8] < 0.5 * column, "not one column of what the run has more"


@pytest.mark.usefixtures("_all_is_long")
def test_a_spike_of_one_cycle_is_drawn_and_measured(make_run, tmp_path):
    source = make_run(duration=4.0)
    folder = lengthened(source, tmp_path / "with-spike", 8, spike=9_777)
    assert isinstance(load_run(folder).trace("reading.position"), LongArray)
    assert write_report(folder).failures == []
    with (folder / "figures/tracking.csv").open(newline="") as stream:
        header, *rows = csv.reader(stream)
    assert len(rows) < 4_000
    place = next(k for k, name in enumerate(header) if "reading" in name and "mm" in name)
    highest = max(float(row[place]) for row in rows if row[place])
    whole = read_log(folder / "log.mcap").column("reading.position")
    assert highest == pytest.approx(1e3 * whole.max())
    assert highest > 1e3


@pytest.mark.usefixtures("_all_is_long")
def test_what_is_measured_is_what_numpy_says_of_whole_columns(make_run, tmp_path):
    folder = lengthened(make_run(duration=4.0), tmp_path / "of-8", 8)
    write_report(folder)
    whole, run = read_log(folder / "log.mcap"), load_run(folder)
    error = whole.column("reference.position") - whole.column("reading.position")
    t = whole.column("reference.time")
    told = {row["name"]: row["value"] for row in run.metrics}
    parts = {s.name: error[slice(*np.searchsorted(t, [s.start, s.end]))] for s in run.segments}
    assert len(parts["0.2 Hz"]) > 4_000
    assert told["tracking_max"] == max(float(np.abs(part).max()) for part in parts.values())
    assert told["tracking_rms"] == math.sqrt(float(np.mean(parts["0.2 Hz"] * parts["0.2 Hz"])))


@pytest.mark.parametrize("long", [1 << 10, ALL])
def test_it_has_the_same_bytes(make_run, monkeypatch, long):
    folder = make_run(duration=4.0)
    monkeypatch.setattr(long_array, "LONG", long)
    monkeypatch.setattr(long_array, "_FEW", 1 << 7)
    monkeypatch.setattr(long_array, "_PIECE", 1 << 10)
    found = []
    for short, expected in ((ALL, Log), (0, FiledColumns)):
        monkeypatch.setattr(log_columns, "_SHORT", short)
        assert isinstance(load_run(folder).log, expected)
        for name in ("metrics.json", "timing.json"):
            (folder / name).unlink()
        assert write_report(folder).failures == []
        files = [
            folder / "metrics.json",
            folder / "timing.json",
            *folder.glob("figures/*.[cps][sn]?"),
        ]
        found.append({path.name: path.read_bytes() for path in files})
    assert len(found[0]) > 4
    assert found[0] == found[1]
