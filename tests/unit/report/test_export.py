"""Exports give back the very numbers that were recorded."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from rig.export import FORMATS, ExportError, export_run, matlab_names
from rig.hal import ConfigurationError
from rig.runtime.log import Log, LogError, read_log

MakeRun = Callable[..., Path]


@pytest.fixture
def run(make_run: MakeRun) -> Path:
    return make_run(duration=1.0)


@pytest.fixture
def log(run: Path) -> Log:
    return read_log(run / "log.mcap")


def test_csv_round_trip(run: Path, log: Log) -> None:
    target = export_run(run, "csv").path
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
    target = export_run(run, "npz", tmp_path / "other.name").path
    with np.load(target, allow_pickle=False) as arrays:
        assert np.array_equal(arrays["t"], log.t)
        for column, unit in zip(log.columns, arrays["units"], strict=True):
            assert np.array_equal(arrays[column.name], log.column(column.name))
            assert unit == column.unit


def test_mat_round_trip(run: Path, log: Log) -> None:
    content = loadmat(export_run(run, "mat").path, simplify_cells=True)
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
    assert export_run(run, format).path.stat().st_size > 1000
    if format == "npz":
        with np.load(run / "log.npz") as arrays:
            assert len(arrays["t"]) == 999


def test_parquet_round_trip(run: Path, log: Log) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(export_run(run, "parquet").path)
    assert table.column_names == ["cycle", "t", *(column.name for column in log.columns)]
    assert np.array_equal(table["cycle"], log.cycle)
    assert np.array_equal(table["t"], log.t)
    for column in log.columns:
        assert np.array_equal(table[column.name], log.column(column.name))
        assert table.schema.field(column.name).metadata[b"unit"] == column.unit.encode()


def test_mcap_with_an_index_is_read_backwards(run: Path, log: Log) -> None:
    from mcap.reader import SeekingReader
    from mcap_ros2.decoder import DecoderFactory

    with export_run(run, "mcap").path.open("rb") as stream:
        reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert summary.statistics.message_count == len(log.t)
        assert summary.chunk_indexes
        assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
        found = [message for *_, message in reader.iter_decoded_messages(reverse=True)]
    found.reverse()
    assert len(found) == len(log.t)
    for k, message in enumerate(found[::50]):
        row = 50 * k
        assert (message.cycle, message.t) == (log.cycle[row], log.t[row])
        assert message.reading.position == log.column("reading.position")[row]


def test_a_damaged_log_is_not_exported(run: Path) -> None:
    content = bytearray((run / "log.mcap").read_bytes())
    content[len(content) // 2] ^= 4
    (run / "log.mcap").write_bytes(content)
    for format in FORMATS:
        with pytest.raises(LogError, match="checksum"):
            export_run(run, format)
    assert not list(run.glob("log?*.[!m]*")) and not list(run.glob(".*log*"))


def test_what_an_export_leaves_goes_to_its_own_place(run: Path, tmp_path: Path) -> None:
    """To no link's target, and never over the log."""
    elsewhere = tmp_path / "precious"
    elsewhere.write_text("mine")
    (run / "log.csv").symlink_to(elsewhere)
    with pytest.raises(ConfigurationError, match=r"log\.csv: it is a link to .*precious"):
        export_run(run, "csv")
    with pytest.raises(ExportError, match=r"it is a link to .*precious"):
        export_run(run, "csv", run / "log.csv")
    assert elsewhere.read_text() == "mine"
    with pytest.raises(ConfigurationError, match="log itself"):
        export_run(run, "mcap", run / "log.mcap")


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
