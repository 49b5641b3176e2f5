"""A log is read while it grows: every row once, none torn, and the same in the end."""

import random
from pathlib import Path

import numpy as np
import pytest

from rig.hal.columns import Column
from rig.runtime.log import LogError, read_log
from rig.runtime.log_tail import LogTail
from rig.runtime.recorder import LogRecorder

COLUMNS = [Column(f"reading.x{k}", "m", "somewhere") for k in range(7)]


def recorded(path: Path, rows: int, seed: int) -> bytes:
    chance = np.random.default_rng(seed)
    with LogRecorder(path, COLUMNS, wall_clock_ns=10**18) as recorder:
        for k in range(rows):
            recorder.write(k, k * 1e-3, chance.normal(size=len(COLUMNS)).tolist())
    return path.read_bytes()


@pytest.mark.parametrize("seed", range(8))
def test_a_log_that_grows_by_random_pieces_is_read_whole(tmp_path, seed):
    chance = random.Random(seed)
    content = recorded(tmp_path / "whole.mcap", chance.randrange(1, 900), seed)
    growing = tmp_path / "log.mcap"
    pieces, written = [], 0
    with LogTail(growing) as tail:
        assert not len(tail.read())  # not even the file is there
        while written < len(content):
            step = chance.choice([1, 3, 40, 200, 5000, 60000])
            with growing.open("ab") as stream:
                stream.write(content[written : written + step])
            written += step
            assert tail.is_closed is False
            for _ in range(chance.randrange(3)):
                pieces.append(tail.read().copy())
        while not tail.is_closed:
            pieces.append(tail.read().copy())
        pieces = [piece for piece in pieces if len(piece)]
        log = read_log(growing)
        assert tail.columns == log.columns
        assert tail.count == len(log.t)
        for name, whole in (("t", log.t), ("cycle", log.cycle), ("row", log.values)):
            assert np.array_equal(np.concatenate([piece[name] for piece in pieces]), whole)
        first = chance.randrange(tail.count)
        assert np.array_equal(tail.rows(first, first + 50)["row"], log.values[first : first + 50])


def test_what_a_killed_process_left_is_read_up_to_its_last_whole_row(tmp_path):
    path = tmp_path / "log.mcap"
    recorder = LogRecorder(path, COLUMNS)
    for k in range(30):
        recorder.write(k, k * 1e-3, [float(k)] * len(COLUMNS))
    with path.open("ab") as stream:
        stream.write(path.read_bytes()[-90:-40])
    with LogTail(path) as tail:
        assert len(tail.read()) == 30
        assert not len(tail.read())
        assert not tail.is_closed
    recorder.close()


@pytest.mark.parametrize("seed", range(20))
def test_a_flipped_bit_is_never_shown(tmp_path, seed):
    """Whatever bit it is: it is said, or every row that comes is as it was written."""
    chance = random.Random(seed)
    path = tmp_path / "log.mcap"
    content = bytearray(recorded(path, 60, seed))
    good = read_log(path).values
    bit = chance.randrange(8 * len(content))
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)
    shown = []
    try:
        with LogTail(path) as tail:
            for _ in range(5):
                shown.append(tail.read().copy())
    except LogError as error:
        assert "log.mcap" in str(error)
    rows = [piece["row"] for piece in shown if len(piece)]
    for seen in rows:
        assert np.array_equal(seen, good[: len(seen)])


def test_a_file_that_is_no_log_is_refused(tmp_path):
    path = tmp_path / "log.mcap"
    path.write_bytes(b"no log at all, but long enough")
    with LogTail(path) as tail, pytest.raises(LogError, match="not an MCAP file"):
        tail.read()
