"""Arrays in files give the numbers of arrays in memory, and take none of it."""

import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from rig.experiment.measure import local_slope, stretch_of
from rig.runtime import long_array
from rig.runtime.long_array import LongArray, laid, mapped

ROWS = 300_001
LONG = 1 << 18
"""Truths of so many rows are a long array, too."""

OPERATIONS = {
    "difference": lambda a, b, _: a - b,
    "product with numbers": lambda a, b, _: 2 * a * 1e-3 + b / 7.0,
    "square": lambda a, b, _: a**2,
    "sine": lambda a, b, _: np.sin(a) * np.arctan2(b, a),
    "greatest": lambda a, b, _: np.maximum(a, 0.0).clip(max=b),
    "truths": lambda a, b, _: (a > b) & ~(a > 1.0) | np.isfinite(b),
    "negative": lambda a, b, _: -np.abs(a),
    "product by rows": lambda a, b, m: a[:, None] * m,
    "table less a row": lambda a, b, m: m - m[0],
    "turned": lambda a, b, m: m @ np.arange(9.0).reshape(3, 3),
    "projected": lambda a, b, m: m @ np.arange(3.0),
    "sum of rows": lambda a, b, m: m.sum(axis=1),
    "greatest of rows": lambda a, b, m: m.max(axis=-1),
    "column of a table": lambda a, b, m: m[:, 1] * 1.0,
    "lengths": lambda a, b, m: np.linalg.norm(m, axis=1),
    "lengths as a column": lambda a, b, m: np.linalg.norm(m, axis=1, keepdims=True),
    "columns beside each other": lambda a, b, _: np.column_stack([a, b, a]),
    "layers": lambda a, b, m: np.stack([m, m], axis=1),
    "one after the other": lambda a, b, _: np.concatenate([[0.0], a, b]),
    "steps": lambda a, b, _: np.sign(np.diff(a, prepend=a[:1])),
    "steps of rows": lambda a, b, m: np.diff(m, axis=0),
    "gradient": lambda a, b, m: np.gradient(m, axis=0),
    "sum up to each": lambda a, b, _: np.cumsum(a),
    "greatest up to each": lambda a, b, _: np.maximum.accumulate(a),
    "chosen by truths": lambda a, b, _: a[b > 0.0],
    "rows chosen by truths": lambda a, b, m: m[b > 0.0],
    "chosen by places": lambda a, b, _: a[np.flatnonzero(b > 0.5) + 1],
    "places": lambda a, b, _: np.flatnonzero(a > 0.0),
    "either": lambda a, b, _: np.where(a > b, a, 0.0),
    "interpolated": lambda a, b, _: np.interp(b, np.sort(a), a),
    "sorted": lambda a, b, _: np.sort(a),
    "whole numbers": lambda a, b, _: (1e3 * a).astype(np.int64),
    "division where it can be": lambda a, b, _: np.divide(
        a, b, out=np.zeros_like(a), where=b > 0.0
    ),
    "slope": lambda a, b, _: local_slope(np.cumsum(np.abs(b) * 1e-3), a),
    "in place": lambda a, b, _: _doubled(a),
}
NUMBERS = {
    "mean": lambda a, b, m: a.mean(),
    "mean square": lambda a, b, m: np.mean(a * a),
    "mean square of rows": lambda a, b, m: np.mean(m * m),
    "range": lambda a, b, m: np.ptp(m, axis=0),
    "median": lambda a, b, m: np.median(a),
    "percentiles": lambda a, b, m: np.percentile(a, [1.0, 50.0, 99.0]),
    "greatest of what is a number": lambda a, b, m: np.nanmax(np.abs(a), initial=0.0),
    "place of the least": lambda a, b, m: a.argmin(),
    "count": lambda a, b, m: np.count_nonzero(a > 0.0),
    "all": lambda a, b, m: (a < 9.0).all(),
    "place in order": lambda a, b, m: np.searchsorted(np.cumsum(np.abs(a)), [1.0, 99.0]),
    "stretch": lambda a, b, m: (stretch_of(np.arange(len(a)) + a * 0.0 > 12.0).start,),
    "sums of rows at the end": lambda a, b, m: m.sum(axis=0),
    "a few": lambda a, b, m: a[7:99] - b[7:99],
}


def _doubled(a):
    values = a.copy()
    values *= 2.0
    return values


@pytest.fixture(autouse=True)
def _shorter_is_long(monkeypatch):
    monkeypatch.setattr(long_array, "LONG", LONG)


@pytest.fixture
def arrays():
    """Columns and a table."""
    draw = np.random.default_rng(7)
    return draw.standard_normal(ROWS), draw.standard_normal(ROWS), draw.standard_normal((ROWS, 3))


@pytest.fixture
def filed(arrays, tmp_path, _shorter_is_long):
    """The same ones in files."""
    return [_filed(tmp_path, array) for array in arrays]


def _filed(folder, array):
    found = laid(folder, array.shape, array.dtype)
    found[...] = array
    return found


@pytest.mark.parametrize("name", OPERATIONS)
def test_numbers_are_the_same_and_stand_in_a_file(arrays, filed, name):
    expected = OPERATIONS[name](*arrays)
    OPERATIONS[name](*filed)  # whatever is imported or cached
    tracemalloc.start()
    found = OPERATIONS[name](*filed)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert isinstance(found, LongArray) is (expected.nbytes >= LONG)
    assert found.dtype == expected.dtype
    assert found.strides == expected.strides
    assert np.asarray(found).tobytes() == expected.tobytes()
    aside = "interpolated", "slope"  # a slope for each knot; windows of all samples of a piece
    assert most < (10e6 if name in aside else 4.5e6), "pieces of 65,536 rows"


@pytest.mark.parametrize("name", NUMBERS)
def test_what_is_short_is_the_same_and_stands_in_memory(arrays, filed, name):
    expected, found = NUMBERS[name](*arrays), NUMBERS[name](*filed)
    assert not isinstance(found, LongArray)
    assert np.asarray(found).tobytes() == np.asarray(expected).tobytes()


def test_truths_of_another_length_choose_nothing(filed):
    with pytest.raises(IndexError, match=r"5000 truths cannot choose among 300001 rows"):
        filed[0][np.ones(5000, bool)]


def test_a_folder_without_room_takes_memory(filed, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    found = filed[0] - filed[1]
    assert type(found) is np.ndarray
    assert np.array_equal(found, np.asarray(filed[0]) - np.asarray(filed[1]))


def test_no_file_is_left_and_none_stays_open(filed, tmp_path):
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(20):
        filed[0] - filed[1]
    assert len(list(Path("/proc/self/fd").iterdir())) == before
    assert list(tmp_path.iterdir()) == []


def test_changing_what_stands_in_a_file_does_not_change_the_file(tmp_path, arrays):
    path = tmp_path / "numbers"
    path.write_bytes(arrays[0].tobytes())
    with path.open("r+b") as file:
        first, second = (mapped(tmp_path, file.fileno(), 0, ROWS, np.float64) for _ in range(2))
    first[:] = 0.0
    assert np.array_equal(second, arrays[0])
    assert path.read_bytes() == arrays[0].tobytes()


def test_few_rows_are_computed_at_once_whatever_they_hold(arrays, filed, monkeypatch):
    monkeypatch.setattr(long_array, "_FEW", ROWS + 1)
    found = filed[0] - filed[1]
    assert type(found) is np.ndarray
    assert np.array_equal(found, arrays[0] - arrays[1])
