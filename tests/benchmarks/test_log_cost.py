"""The log beside mcap's own writer: the same rows, each with the kernel before the next."""

import struct
import time
from statistics import median

import pytest

from rig.hal.columns import Column, schema_text
from rig.runtime.recorder import LogRecorder

WIDTH = 35
ROWS = 2000
ROUNDS = 7
BOUND = 8e-6
BOUND_RATIO = 0.6
PERIOD = 2e-3

pytestmark = pytest.mark.benchmark


def test_log_cost(tmp_path, table):
    columns = [Column(f"group{n // 5}.value{n}", "m", "a number") for n in range(WIDTH)]
    rows = [tuple(0.1 * k + n for n in range(WIDTH)) for k in range(ROWS)]
    ours, theirs = [], []
    for number in range(ROUNDS + 1):
        spent = record(tmp_path / f"ours-{number}.mcap", columns, rows)
        stock = record_with_mcap(tmp_path / f"theirs-{number}.mcap", columns, rows)
        if number:  # the first warms up
            ours.append(spent)
            theirs.append(stock)
    table(what="LogRecorder.write", us=1e6 * median(ours), bound_us=1e6 * BOUND)
    table(what="mcap Writer.add_message and flush", us=1e6 * median(theirs))
    table(what="ratio", ratio=median(ours) / median(theirs), bound=BOUND_RATIO)
    assert median(ours) <= BOUND_RATIO * median(theirs)
    # A machine on which mcap's writer is slow is slow at this as well.
    assert median(ours) <= BOUND or median(theirs) > BOUND / BOUND_RATIO


def record(path, columns, rows):
    """Return the CPU time of a row, s."""
    with LogRecorder(path, columns, wall_clock_ns=0) as recorder:
        began = time.process_time()
        for cycle, row in enumerate(rows):
            recorder.write(cycle, cycle * PERIOD, row)
        return (time.process_time() - began) / len(rows)


def record_with_mcap(path, columns, rows):
    """Return the CPU time of a row, s."""
    from mcap.writer import Writer

    pack = struct.Struct(f"<4siIQd{len(columns)}d").pack
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start("ros2", "benchmark")
        schema = writer.register_schema(
            "rig_msgs/msg/Cycle", "ros2msg", schema_text(columns).encode()
        )
        channel = writer.register_channel("/rig/cycle", "cdr", schema)
        began = time.process_time()
        for cycle, row in enumerate(rows):
            t = cycle * PERIOD
            stamp = int(t * 1e9 + 0.5)
            seconds, nanoseconds = divmod(stamp, 1_000_000_000)
            data = pack(b"\x00\x01\x00\x00", seconds, nanoseconds, cycle, t, *row)
            writer.add_message(channel, stamp, data, stamp, cycle)
            file.flush()
        spent = time.process_time() - began
        writer.finish()
    return spent / len(rows)
