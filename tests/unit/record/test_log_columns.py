import errno
import os

import numpy as np
import pytest

from rig.hal.columns import Column
from rig.runtime import log_columns
from rig.runtime.log import Log, LogError, read_log
from rig.runtime.log_columns import FiledColumns, read_columns
from rig.runtime.recorder import LogRecorder

COLUMNS = tuple(Column(name, "m", "a number") for name in ("reading.a", "reading.b", "phase"))


@pytest.fixture
def path(tmp_path):
    """A log of more rows than are read in one go."""
    with LogRecorder(tmp_path / "log.mcap", COLUMNS) as recorder:
        for k in range(60_000):
            recorder.write(2 * k, 1e-3 * k, (0.1 * k, -k, k % 3))
    return tmp_path / "log.mcap"


@pytest.fixture
def _every_log_is_long(monkeypatch):
    monkeypatch.setattr(log_columns, "_SHORT", 0)


@pytest.mark.usefixtures("_every_log_is_long")
def test_columns_in_a_file_are_those_of_the_log(path):
    filed, whole = read_columns(path), read_log(path)
    assert isinstance(filed, FiledColumns)
    assert filed.columns == whole.columns
    assert filed.complete is whole.complete is True
    for name in ("cycle", "t", "stamp"):
        ours, theirs = getattr(filed, name), getattr(whole, name)
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)
    for column in COLUMNS:
        np.testing.assert_array_equal(filed.column(column.name), whole.column(column.name))
    assert filed.names("reading.") == whole.names("reading.") == ("reading.a", "reading.b")
    assert "phase" in filed
    assert "reading" not in filed
    with pytest.raises(LogError, match=r"no column 'x'; it has reading\.a, reading\.b, phase"):
        filed.column("x")


@pytest.mark.usefixtures("_every_log_is_long")
def test_pieces_of_a_column_are_the_column(path, monkeypatch):
    monkeypatch.setattr(log_columns, "_PIECE", 7_001)
    filed, whole = read_columns(path), read_log(path)
    assert filed.rows == whole.rows == 60_000
    for name in ("cycle", "t", "stamp", "reading.b"):
        pieces, (all_of_it,) = list(filed.pieces(name)), whole.pieces(name)
        assert max(map(len, pieces)) == 7_001
        assert all(piece.dtype == all_of_it.dtype for piece in pieces)
        np.testing.assert_array_equal(np.concatenate(pieces), all_of_it)
    with pytest.raises(LogError, match=r"no column 'x'"):
        next(filed.pieces("x"))


@pytest.mark.usefixtures("_every_log_is_long")
def test_nothing_is_left_beside_the_log(path):
    filed = read_columns(path)
    assert filed.column("phase")[-1] == 59_999 % 3
    assert [file.name for file in path.parent.iterdir()] == ["log.mcap"]


@pytest.mark.usefixtures("_every_log_is_long")
def test_a_log_without_a_row_has_empty_columns(tmp_path):
    with LogRecorder(tmp_path / "log.mcap", COLUMNS):
        pass
    filed = FiledColumns(log_columns.LogFile(tmp_path / "log.mcap"), tmp_path)
    assert filed.column("phase").shape == filed.t.shape == (0,)


def test_a_short_log_is_held_in_memory(path):
    assert isinstance(read_columns(path), Log)


@pytest.mark.usefixtures("_every_log_is_long")
def test_a_full_disk_makes_it_hold_the_log_in_memory(path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "pwrite", full)
    assert isinstance(read_columns(path), Log)


@pytest.mark.usefixtures("_every_log_is_long")
def test_a_damaged_row_is_found_here_too(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(LogError, match="does not fit its checksum"):
        read_columns(path)
