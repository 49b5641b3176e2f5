"""The log: readable by others, complete after any death, fast, honest about a full disk."""

import math
import os
import resource
import signal
import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from rig.hal.columns import Column, schema_text
from rig.runtime.file_lock import is_locked
from rig.runtime.log import LogError, read_log
from rig.runtime.recorder import LogRecorder, RecorderError

COLUMNS = (
    Column("phase", "", "0 approach, 1 run, 2 stop"),
    Column("reading.position", "m", "position of the pair"),
    Column("reading.pressure_agonist", "Pa", "monitored pressure"),
    Column("reference.position", "m", "where it should be"),
)
WALL_CLOCK = 1_795_000_000_123_456_789


def row(k: int) -> tuple[float, ...]:
    return (1.0, 1e-3 * math.sin(k), 1.2e5 + k, -0.25 * k)


def record(path: Path, n: int, close: bool = True) -> LogRecorder:
    recorder = LogRecorder(path, COLUMNS, WALL_CLOCK)
    for k in range(n):
        recorder.write(k, 10.0 + k * 0.002, row(k))
    if close:
        recorder.close()
    return recorder


def test_log_holds_what_was_written(tmp_path: Path) -> None:
    record(tmp_path / "log.mcap", 5)
    log = read_log(tmp_path / "log.mcap")
    assert log.columns == COLUMNS
    assert log.complete
    assert log.cycle.tolist() == [0, 1, 2, 3, 4]
    assert log.t.tolist() == [10.0 + k * 0.002 for k in range(5)]
    assert [tuple(values) for values in log.values.tolist()] == [row(k) for k in range(5)]
    assert log.stamp.tolist() == [WALL_CLOCK + 2_000_000 * k for k in range(5)]
    assert log.column("reference.position").tolist() == [row(k)[3] for k in range(5)]
    assert "reading.position" in log and "reading.speed" not in log
    with pytest.raises(LogError, match="no column"):
        log.column("reading.speed")


@pytest.mark.parametrize("n", [0, 1, 7])
def test_other_software_reads_the_log(tmp_path: Path, n: int) -> None:
    record(tmp_path / "log.mcap", n)
    with (tmp_path / "log.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert summary.statistics.message_count == n
        assert summary.statistics.channel_message_counts == ({1: n} if n else {})
        decoded = list(reader.iter_decoded_messages())
        assert len(decoded) == n
        if n:
            assert summary.statistics.message_start_time == WALL_CLOCK
            assert summary.statistics.message_end_time == decoded[-1].message.log_time
        for k, (schema, channel, message, body) in enumerate(decoded):
            assert schema is not None and schema.name == "rig_msgs/msg/Cycle"
            assert channel.topic == "/cycle"
            assert message.sequence == k
            assert message.log_time == WALL_CLOCK + 2_000_000 * k
            assert body.stamp.sec * 1_000_000_000 + body.stamp.nanosec == message.log_time
            assert (body.cycle, body.t, body.phase) == (k, 10.0 + k * 0.002, 1.0)
            assert body.reading.position == row(k)[1]
            assert body.reading.pressure_agonist == row(k)[2]
            assert body.reference.position == row(k)[3]


def test_index_checks_out(tmp_path: Path) -> None:
    """The summary's checksum and its offsets are verified by mcap itself."""
    from mcap.records import Footer, Schema, Statistics, SummaryOffset
    from mcap.stream_reader import StreamReader

    record(tmp_path / "log.mcap", 3)
    with (tmp_path / "log.mcap").open("rb") as stream:
        records = list(StreamReader(stream, validate_crcs=True).records)
        footer = records[-1]
        assert isinstance(footer, Footer) and footer.summary_crc
        offsets = [r for r in records if isinstance(r, SummaryOffset)]
        assert len(offsets) == 3
        stream.seek(footer.summary_start)
        for offset in offsets:
            assert stream.tell() == offset.group_start
            assert stream.read(1)[0] == offset.group_opcode
            stream.seek(offset.group_start + offset.group_length)
        assert stream.tell() == footer.summary_offset_start
        assert sum(isinstance(r, Schema) for r in records) == 2
        assert sum(isinstance(r, Statistics) for r in records) == 1


def test_log_torn_at_any_byte_of_the_last_record(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    recorder = record(path, 3, close=False)
    two = path.stat().st_size
    recorder.write(3, 10.006, row(3))
    content = path.read_bytes()
    assert len(content) > two
    for size in range(two, len(content) + 1):
        torn = tmp_path / "torn.mcap"
        torn.write_bytes(content[:size])
        log = read_log(torn)
        assert len(log.t) == (4 if size == len(content) else 3)
        assert not log.complete
        assert [tuple(values) for values in log.values.tolist()] == [
            row(k) for k in range(len(log.t))
        ]
    recorder.close()


def test_log_torn_in_its_ending(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    recorder = record(path, 2, close=False)
    before = path.stat().st_size
    recorder.close()
    content = path.read_bytes()
    for size in range(before, len(content)):
        path.write_bytes(content[:size])
        log = read_log(path)
        assert len(log.t) == 2 and not log.complete


def test_log_torn_before_its_columns(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    recorder = LogRecorder(path, COLUMNS)
    content = path.read_bytes()
    recorder.close()
    for size in range(len(content)):
        path.write_bytes(content[:size])
        with pytest.raises(LogError, match=r"log\.mcap"):
            read_log(path)
    path.write_bytes(content)
    assert len(read_log(path).t) == 0


def test_foreign_files_are_named(tmp_path: Path) -> None:
    from mcap.writer import Writer

    with pytest.raises(LogError, match=r"absent\.mcap"):
        read_log(tmp_path / "absent.mcap")
    with (tmp_path / "foreign.mcap").open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start()
        writer.register_channel("/other", "json", 0)
        writer.finish()
    with pytest.raises(LogError, match="not recorded by this program"):
        read_log(tmp_path / "foreign.mcap")


def test_kill_loses_no_acknowledged_cycle(tmp_path: Path) -> None:
    """A child tells how many cycles it has recorded and is killed at a random moment."""
    for trial in range(10):
        path = tmp_path / f"{trial}.mcap"
        told, tell = os.pipe()
        child = os.fork()
        if child == 0:  # pragma: no cover
            try:
                recorder = LogRecorder(path, COLUMNS)
                for k in range(10_000_000):
                    recorder.write(k, k * 1e-3, row(k))
                    os.write(tell, struct.pack("<I", k + 1))
            finally:
                os._exit(1)
        os.close(tell)
        acknowledged = 0
        while acknowledged < 100 * (trial + 1):
            acknowledged = struct.unpack("<I", os.read(told, 4))[0]
        assert is_locked(path)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        while rest := os.read(told, 4):
            acknowledged = struct.unpack("<I", rest)[0]
        os.close(told)
        assert not is_locked(path)
        log = read_log(path)
        assert acknowledged <= len(log.t) <= acknowledged + 1
        assert not log.complete
        assert log.cycle.tolist() == list(range(len(log.t)))
        with path.open("rb") as stream:
            messages = NonSeekingReader(stream).iter_messages(log_time_order=False)
            assert next(messages)[2].sequence == 0


def test_file_is_locked_while_open(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    assert not is_locked(path)
    recorder = LogRecorder(path, COLUMNS)
    assert is_locked(path)
    recorder.close()
    recorder.close()
    assert not is_locked(path)


def test_log_of_a_living_run_can_be_read(tmp_path: Path) -> None:
    recorder = record(tmp_path / "log.mcap", 4, close=False)
    assert len(read_log(tmp_path / "log.mcap").t) == 4
    recorder.close()


def test_full_disk_is_named_and_leaves_a_good_log(tmp_path: Path) -> None:
    """A file-size limit in a child stands for the full disk; the write that hits it is short."""
    path = tmp_path / "log.mcap"
    child = os.fork()
    if child == 0:  # pragma: no cover
        code = 1
        try:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            recorder = LogRecorder(path, COLUMNS)
            limit = path.stat().st_size + 20 * recorder._size + 17
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            try:
                for k in range(100):
                    recorder.write(k, k * 1e-3, row(k))
            except RecorderError as error:
                again = False
                try:
                    recorder.write(100, 0.1, row(100))
                except RecorderError:
                    again = True
                recorder.close()
                code = 0 if str(path) in str(error) and k == 20 and again else 2
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0
    log = read_log(path)
    assert log.cycle.tolist() == list(range(20))
    assert not log.complete
    with path.open("rb") as stream:
        messages = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert [next(messages)[2].sequence for _ in range(20)] == list(range(20))
        with pytest.raises(EndOfFile):
            next(messages)


def test_full_device_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    recorder = record(path, 3, close=False)
    full = os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, recorder._fd)
    os.close(full)
    with pytest.raises(RecorderError, match=r"log\.mcap: No space left on device"):
        recorder.write(3, 10.006, row(3))
    recorder.close()
    assert len(read_log(path).t) == 3


def test_short_writes_are_completed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    recorder = LogRecorder(path, COLUMNS, WALL_CLOCK)
    write = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: write(fd, bytes(data)[:11]))
    for k in range(4):
        recorder.write(k, k * 1e-3, row(k))
    recorder.close()
    monkeypatch.undo()
    log = read_log(path)
    assert log.complete and len(log.t) == 4
    assert tuple(log.values[3].tolist()) == row(3)


def test_existing_or_unwritable_path_is_refused(tmp_path: Path) -> None:
    record(tmp_path / "log.mcap", 1)
    with pytest.raises(RecorderError, match=r"log\.mcap: File exists"):
        LogRecorder(tmp_path / "log.mcap", COLUMNS)
    with pytest.raises(RecorderError, match=r"absent/log\.mcap: No such file"):
        LogRecorder(tmp_path / "absent" / "log.mcap", COLUMNS)


def test_row_of_another_length_is_refused(tmp_path: Path) -> None:
    with LogRecorder(tmp_path / "log.mcap", COLUMNS) as recorder:
        with pytest.raises(ValueError, match="2 numbers for 4"):
            recorder.write(0, 0.0, (1.0, 2.0))
        recorder.write(0, 0.0, row(0))
    assert len(read_log(tmp_path / "log.mcap").t) == 1


def test_columns_of_a_group_are_brought_together(tmp_path: Path) -> None:
    names = ["reference.time", "phase", "reading.x", "reference.x", "reading.y"]
    path = tmp_path / "log.mcap"
    with LogRecorder(path, [Column(name, "m", "") for name in names]) as recorder:
        recorder.write(0, 0.0, (0.0, 1.0, 2.0, 3.0, 4.0))
        recorder.write(1, 0.1, [10.0, 11.0, 12.0, 13.0, 14.0])
    log = read_log(path)
    assert [c.name for c in log.columns] == [
        "reference.time", "reference.x", "phase", "reading.x", "reading.y",
    ]  # fmt: skip
    for number, name in enumerate(names):
        assert log.column(name).tolist() == [number, 10.0 + number]
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        body = next(reader.iter_decoded_messages())[3]
        assert (body.reference.x, body.reading.y, body.phase) == (3.0, 4.0, 1.0)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["a.b.c"], "one or two parts"),
        (["Reading.position"], "lower-case"),
        (["reading.position_"], "lower-case"),
        (["t"], "part of every message"),
        (["a.x", "a.x"], "twice"),
        (["a.x", "b.x", "a.y"], "stands apart"),
        (["a", "a.x"], "both a column and a group"),
        (["a.x", "a"], "both a column and a group"),
        (["a_b.x", "ab.x"], None),
        (["a_1.x", "a1.x"], "too alike"),
    ],
)
def test_illegal_columns_are_refused(names: list[str], message: str | None) -> None:
    columns = [Column(name, "m", "") for name in names]
    if message is None:
        assert "AB a_b" in schema_text(columns)
        return
    with pytest.raises(ValueError, match=message):
        schema_text(columns)


def test_schema_carries_units_and_descriptions() -> None:
    text = schema_text([Column("reading.position", "m", "position\nof the pair")])
    assert "float64 position  # position of the pair [m]" in text


def test_long_log_is_read_at_once(tmp_path: Path) -> None:
    """A log without an index is found by arithmetic, not by walking: 50 000 rows."""
    record(tmp_path / "long.mcap", 50_000)
    log = read_log(tmp_path / "long.mcap")
    assert np.array_equal(log.cycle, np.arange(50_000))
