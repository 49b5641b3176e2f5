"""A log that is not as it was written is said to be damaged, and never plotted."""

import random

import numpy as np
import pytest

from rig.hal.columns import Column
from rig.runtime.log import LogError, LogFile, read_log
from rig.runtime.mcap_file import encode_ending, encode_preamble
from rig.runtime.recorder import LogRecorder

COLUMNS = [Column(f"reading.x{k}", "m", "somewhere") for k in range(6)]
ROWS = 120
FLIPS = 500


@pytest.fixture
def log(tmp_path):
    chance = random.Random(4)
    path = tmp_path / "log.mcap"
    with LogRecorder(path, COLUMNS, wall_clock_ns=10**18) as recorder:
        for k in range(ROWS):
            recorder.write(k, k * 1e-3, [chance.gauss(0.0, 1.0) for _ in COLUMNS])
    return path


def test_a_flipped_bit_is_said_or_changes_no_number(log):
    content, good = log.read_bytes(), read_log(log)
    chance = random.Random(5)
    said = 0
    for _ in range(FLIPS):
        bit = chance.randrange(8 * len(content))
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        log.write_bytes(flipped)
        try:
            found = read_log(log)
        except LogError as error:
            assert "log.mcap" in str(error)
            said += 1
            continue
        assert found.columns == good.columns
        for one, other in zip(found[1:5], good[1:5], strict=True):
            np.testing.assert_array_equal(one, other)
    # What follows the last row is an index of our making, which nothing is read from.
    rows_end = content.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    assert said >= 0.9 * FLIPS * rows_end / len(content)


@pytest.mark.parametrize("seed", range(5))
def test_a_log_that_is_cut_off_is_read_as_far_as_it_goes(log, seed):
    content, good = log.read_bytes(), read_log(log)
    size = LogFile(log).record.itemsize
    start = content.index(b"\x05" + (size - 9).to_bytes(8, "little"))
    whole = random.Random(seed).randrange(ROWS)
    log.write_bytes(content[: start + whole * size + random.Random(seed).randrange(size)])
    found = read_log(log)
    assert not found.complete
    np.testing.assert_array_equal(found.values, good.values[:whole])


def test_a_log_without_checksums_is_read_as_ever(log, monkeypatch, tmp_path):
    """As older versions wrote them: neither in the messages nor announced."""
    content, good = log.read_bytes(), read_log(log)
    size = LogFile(log).record.itemsize
    start = content.index(b"\x05" + (size - 9).to_bytes(8, "little"))
    monkeypatch.setattr("rig.runtime.mcap_file.CHECKSUM_KEY", "other")
    old = bytearray(encode_preamble(COLUMNS))
    for k in range(ROWS):
        row = bytearray(content[start + k * size : start + (k + 1) * size - 4])
        row[1:9] = (size - 13).to_bytes(8, "little")
        old += row
    old += encode_ending(COLUMNS, len(old), ROWS, 10**18, 10**18)
    path = tmp_path / "old.mcap"
    path.write_bytes(old)
    monkeypatch.undo()
    found = read_log(path)
    assert found.complete
    np.testing.assert_array_equal(found.values, good.values)
