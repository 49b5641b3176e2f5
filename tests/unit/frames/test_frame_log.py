"""Recording frames: what is on file at any moment, and what happens when it cannot be."""

import os

import pytest

from drivers.can import frame_log
from drivers.can.candump import parse_lines
from drivers.can.frame import EXTENDED_FLAG
from drivers.can.frame_log import FrameLog
from rig.hal import ConfigurationError, FastCanBus


class Clock:
    time = 0.0

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = t


class Interface(FastCanBus):
    """Waiting frames, and those that were sent."""

    def __init__(self):
        self.waiting = []
        self.sent = []
        self.accepted = self.refuses = self.closed = False

    def drain(self, limit):
        frames, self.waiting[:] = self.waiting[:limit], self.waiting[limit:]
        return frames

    def send_data(self, can_id, data):
        if self.refuses:
            raise OSError("full")
        self.sent.append((can_id, data))

    def accept(self, can_ids):
        self.accepted = True

    def shutdown(self):
        self.closed = True


@pytest.fixture
def path(tmp_path):
    return tmp_path / "frames.log"


def tapped(log, *names):
    clock = Clock()
    ends = [Interface() for _ in names]
    return clock, [(end, log.tap(name, clock, end)) for name, end in zip(names, ends, strict=True)]


def read(path):
    with path.open() as lines:
        return list(parse_lines(lines, str(path)))


def test_every_frame_is_on_file_before_the_program_goes_on(path):
    log = FrameLog()
    log.start(path)
    clock, [(end, bus)] = tapped(log, "can0")
    drain, send = bus.drain, bus.send_data
    end.waiting = [(0x181, b"\x01"), (0x12345 | EXTENDED_FLAG, b"\x02")]
    assert drain(256) == [(0x181, b"\x01"), (0x12345 | EXTENDED_FLAG, b"\x02")]
    assert [frame.can_id for frame in read(path)] == [0x181, 0x12345 | EXTENDED_FLAG]
    clock.time = 0.25
    send(0x201, b"\x03")
    assert end.sent == [(0x201, b"\x03")]
    frames = read(path)
    assert frames[-1].can_id == 0x201
    assert frames[-1].time - frames[0].time == pytest.approx(0.25, abs=2e-6)
    assert (log.count, log.lost) == (3, 0)


def test_buses_share_one_file_and_one_time(path):
    log = FrameLog()
    log.start(path)
    _, [(_, left), (_, right)] = tapped(log, "left", "right leg")
    left.send_data(1, b"")
    right.send_data(2, b"")
    frames = read(path)
    assert [frame.channel for frame in frames] == ["left", "right_leg"]
    assert frames[0].time == frames[1].time


def test_a_refused_frame_was_never_on_the_bus(path):
    log = FrameLog()
    log.start(path)
    _, [(end, bus)] = tapped(log, "can0")
    end.refuses = True
    with pytest.raises(OSError, match="full"):
        bus.send_data(0x201, b"")
    assert read(path) == []


def test_no_filter_keeps_foreign_frames_off_the_file(path):
    _, [(end, bus)] = tapped(FrameLog(), "can0")
    bus.accept([0x181])
    assert not end.accepted
    bus.shutdown()
    assert end.closed


def test_frames_pass_by_the_recorder_or_not_at_all(path):
    """What an interface tells of itself is passed on, and no frame has another way than this."""
    _, [(end, bus)] = tapped(FrameLog(), "can0")
    end.backlog = lambda: 3
    end.count_dropped = lambda: 2
    end.fileno = lambda: 7
    end.send_all = lambda frames: None
    assert (bus.backlog(), bus.count_dropped(), bus.fileno()) == (3, 2, 7)
    assert not hasattr(bus, "send_all")


def test_a_full_disk_stops_the_recording_and_not_the_rig(path, monkeypatch):
    log = FrameLog()
    log.start(path)
    _, [(end, bus)] = tapped(log, "can0")
    send = bus.send_data
    send(0x201, b"\x01")
    whole = path.read_bytes()
    write = os.write

    room = [5]  # bytes that still fit

    def full(fd, data):
        if not room:
            raise OSError(28, "No space left on device")
        return write(fd, data[: room.pop()])

    monkeypatch.setattr(frame_log.os, "write", full)
    send(0x202, b"\x02")
    send(0x203, b"\x03")
    assert len(end.sent) == 3
    assert path.read_bytes() == whole, "no torn line is left"
    assert (log.count, log.lost) == (1, 2)
    assert log.close() == "2 frames of the buses could not be written: No space left on device"


def test_a_log_that_cannot_be_made_is_a_plain_error(tmp_path):
    with pytest.raises(ConfigurationError, match=r"cannot record frames in .*No such file"):
        FrameLog().start(tmp_path / "nowhere" / "frames.log")
