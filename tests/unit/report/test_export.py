"""Exports give back the very numbers that were recorded."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from rig.export import FORMATS, ExportError, export_run, matlab_names
from rig.hal import ConfigurationError
from rig.runtime.log import Log, read_log

MakeRun = Callable[..., Path]


@pytest.fixture
def run(make_run: MakeRun) -> Path:
    return make_run(duration=1.0)


@pytest.fixture
def log(run: Path) -> Log:
    return read_log(run / "log.mcap")


def test_csv_round_trip(run: Path, log: Log) -> None:
    target = export_run(run, "csv")
    assert target == run / "log.csv"
    with target.open(newline="") as stream:
        head, *rows = list(csv.reader(stream))
    assert head[:3] == ["cycle", "t [s]", "phase"]
    assert [name.split(" ")[0] for name in head[2:]] == [c.name for c in log.columns]
    assert "reading.pressure_agonist [Pa]" in head
    values = np.array(rows, dtype=float)
    assert np.array_equal(values[:, 0], log.cycle)
    assert np.array_equal(values[:, 1], log.t)
    assert np.array_equal(values[:, 2:], log.values)


def test_npz_round_trip(run: Path, log: Log, tmp_path: Path) -> None:
    target = export_run(run, "npz", tmp_path / "other.name")
    with np.load(target, allow_pickle=False) as arrays:
        assert np.array_equal(arrays["t"], log.t)
        for column, unit in zip(log.columns, arrays["units"], strict=True):
            assert np.array_equal(arrays[column.name], log.column(column.name))
            assert unit == column.unit


def test_mat_round_trip(run: Path, log: Log) -> None:
    content = loadmat(export_run(run, "mat"), simplify_cells=True)
    raw = loadmat(run / "log.mat")
    assert raw["t"].shape == (len(log.t), 1)
    assert np.array_equal(content["t"], log.t)
    assert np.array_equal(content["cycle"], log.cycle)
    columns = content["columns"]
    assert list(columns["name"]) == [c.name for c in log.columns]
    assert columns["unit"][list(columns["name"]).index("reading.position")] == "m"
    for name, variable in zip(columns["name"], columns["variable"], strict=True):
        assert np.array_equal(content[variable], log.column(name))
        assert variable == name.replace(".", "_")


@pytest.mark.parametrize("format", list(FORMATS))
def test_killed_run_is_exported(make_run: MakeRun, format: str) -> None:
    run = make_run(duration=1.0, status=None)
    content = (run / "log.mcap").read_bytes()
    (run / "log.mcap").write_bytes(content[:-3])
    assert export_run(run, format).stat().st_size > 1000
    if format == "npz":
        with np.load(run / "log.npz") as arrays:
            assert len(arrays["t"]) == 999


def test_matlab_names_are_legal_and_different() -> None:
    long = "timing.a_very_long_name_of_a_quantity"
    names = matlab_names(["reading.position", "reading_position", "1st", "columns", long, long])
    assert names[:4] == ["reading_position", "reading_position_2", "x1st", "columns_2"]
    assert len(set(names)) == 6
    assert all(len(name) <= 31 and name.isidentifier() for name in names)


def test_errors_are_named(run: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"'xlsx'.*csv, npz, mat"):
        export_run(run, "xlsx")
    with pytest.raises(ConfigurationError, match="not a run folder"):
        export_run(tmp_path, "csv")
    with pytest.raises(ExportError, match=r"absent/log\.csv"):
        export_run(run, "csv", tmp_path / "absent" / "log.csv")
