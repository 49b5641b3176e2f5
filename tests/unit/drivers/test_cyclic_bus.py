"""A CAN bus as the cycle sees it: what it sends, hears, counts, and says of another master."""

import errno
from itertools import pairwise

import pytest

from drivers.can.bus_settings import CanInterfaceSettings
from drivers.can.cyclic import CyclicCanBus, CyclicFrame
from drivers.can.frame import ERROR_FLAG, REMOTE_FLAG
from rig.hal import ConnectionFailed, DeviceFault

LIMIT, MOST = 5, 2


class Interface:
    """An interface made by hand."""

    def __init__(self):
        self.waiting, self.sent, self.accepted = [], [], None
        self.queued = self.dropped = self.others = 0
        self.shut = 0
        self.fails = {}

    def drain(self, limit):
        self._fail("drain")
        taken, self.waiting = self.waiting[:limit], self.waiting[limit:]
        return taken

    def send_data(self, can_id, data):
        self._fail("send")
        self._fail(can_id)
        self.sent.append((can_id, data))

    def _fail(self, what):
        if what in self.fails:
            raise self.fails[what]

    def backlog(self):
        return self.queued

    def count_dropped(self):
        return self.dropped

    def accept(self, can_ids):
        self.accepted = list(can_ids)

    def count_others(self):
        others, self.others = self.others, 0
        return others

    def shutdown(self):
        self.shut += 1


class Clock:
    def __init__(self):
        self.time = 10.0
        self.happens = {}

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = t
        for when in sorted(self.happens):
            if when <= t:
                self.happens.pop(when)()


class Bus(CyclicCanBus):
    """Speaks no protocol in particular."""

    def __init__(self, farewell=None):
        self.interfaces, self.wall = [], Clock()
        super().__init__(
            "can0", CanInterfaceSettings(interface="virtual", channel="x", receive_limit=LIMIT,
            max_refused=MOST), self._make, self.wall, 0.01,
        )  # fmt: skip
        self._farewell = farewell

    def _make(self):
        self.interfaces.append(Interface())
        return self.interfaces[-1]

    def _owners(self, can_id):
        return f"devices have number {can_id & 0x7F}"

    transmit = CyclicCanBus._send_cyclic


def opened(farewell=None):
    bus = Bus(farewell)
    bus.open()
    return bus, bus.interfaces[0]


def frames(bus, *can_ids, active=True):
    made = [CyclicFrame(can_id, bytes([can_id & 0xFF])) for can_id in can_ids]
    for frame in made:
        bus.add(frame)
        frame.active = active
    return made


def test_a_frame_is_silent_and_safe_until_a_driver_says_otherwise():
    frame = CyclicFrame(0x21, b"\x05")
    assert (frame.can_id, frame.safe, frame.data, frame.active) == (0x21, b"\x05", b"\x05", False)


def test_a_bus_that_is_not_open_hears_nothing_and_refuses_to_send():
    bus = Bus()
    assert (bus.name, bus.clock, bus.period) == ("can0", bus.wall, 0.01)
    bus.receive(0.0)
    bus.expect_alone(0.0)
    assert bus.transmit() is True  # nothing is active
    bus.check(0.0)
    bus.close()
    assert not bus.has_spoken
    with pytest.raises(OSError, match="the bus is not open"):
        bus.send(0x21, b"")
    assert set(bus.statistics().values()) == {0}
    assert bus.interfaces == []


def test_opening_twice_opens_once_and_what_is_subscribed_is_accepted():
    bus = Bus()
    bus.subscribe(0x21, lambda data, now: None)
    bus.open()
    bus.open()
    (interface,) = bus.interfaces
    assert interface.accepted == [0x21]


def test_an_interface_for_somebody_else_leaves_the_bus_as_it_was():
    bus = Bus()
    bus.subscribe(0x21, lambda data, now: None)
    lent = bus.open_interface()
    assert (lent.accepted, lent.shut) == (None, 0)
    bus.open()
    assert bus.interfaces[0] is lent
    assert bus.interfaces[1].accepted == [0x21]
    bus.close()
    assert lent.shut == 0


def test_an_identifier_has_one_owner():
    bus = Bus()
    bus.subscribe(0x185, lambda data, now: None)
    with pytest.raises(ValueError, match="0x185 is used twice; two devices have number 5"):
        frames(bus, 0x185)


def test_frames_go_to_their_handlers_and_the_others_are_counted():
    bus, interface = opened()
    heard = []
    bus.subscribe(0x21, lambda data, now: heard.append((data, now)))
    interface.waiting = [
        (0x21, b"a"), (0x22, b"b"), (0x21 | REMOTE_FLAG, b""), (0x21 | ERROR_FLAG, b"\0" * 8),
        (0x23, b"c"), (0x21, b"d"),
    ]  # fmt: skip
    bus.receive(3.0)
    assert heard == [(b"a", 3.0)]
    bus.receive(4.0)
    assert heard == [(b"a", 3.0), (b"d", 4.0)]
    counted = bus.statistics()
    assert [counted[k] for k in ("frames_in", "unknown", "remote", "error_frames")] == [6, 2, 1, 1]
    bus.check(4.0)


def test_an_error_frame_says_what_it_says():
    bus, interface = opened()
    interface.waiting = [(ERROR_FLAG | 0x040, b"\0" * 8)]
    bus.receive(0.0)
    with pytest.raises(DeviceFault, match="the controller went bus-off"):
        bus.check(0.0)
    bus, interface = opened()
    interface.waiting = [(ERROR_FLAG | 0x004, b"\0\x01" + b"\0" * 6)]
    bus.receive(0.0)
    assert bus.statistics()["lost"] == 1


def test_an_interface_that_cannot_be_read_is_a_fault():
    bus, interface = opened()
    interface.fails["drain"] = OSError("broken")
    bus.receive(0.0)
    with pytest.raises(DeviceFault, match="the interface failed while receiving: broken"):
        bus.check(0.0)


def test_a_cycle_sends_the_active_frames_as_they_are_now_and_then_the_others():
    bus, interface = opened()
    one, other, _ = *frames(bus, 0x21, 0x22), *frames(bus, 0x23, active=False)
    assert bus.transmit((0x80, b""), (0x701, b"\x05")) is True
    assert interface.sent == [(0x21, b"\x21"), (0x22, b"\x22"), (0x80, b""), (0x701, b"\x05")]
    one.data, other.active = b"\x7f", False
    assert bus.transmit() is True
    assert interface.sent[4:] == [(0x21, b"\x7f")]
    assert bus.statistics()["frames_out"] == 5


@pytest.mark.parametrize("refused", [0x22, 0x80])
def test_after_a_frame_that_is_refused_nothing_follows_in_that_cycle(refused):
    bus, interface = opened()
    frames(bus, 0x21, 0x22, 0x23)
    interface.fails[refused] = OSError(errno.ENOBUFS, "full")
    assert bus.transmit((0x80, b""), (0x701, b"")) is False
    sent = [can_id for can_id, _ in interface.sent]
    assert sent == ([0x21] if refused == 0x22 else [0x21, 0x22, 0x23])
    counted = bus.statistics()
    assert (counted["frames_out"], counted["refused"]) == (len(sent), 1)


def test_setpoints_do_not_pile_up_behind_frames_that_wait():
    bus, interface = opened()
    frames(bus, 0x21)
    interface.queued = 1
    for _ in range(MOST):
        assert bus.transmit() is False
    bus.check(0.0)
    interface.queued = 0
    assert bus.transmit() is True  # a row of refusals has ended
    interface.queued = 1
    for _ in range(MOST):
        assert bus.transmit() is False
    bus.check(0.0)
    assert len(interface.sent) == 1
    assert bus.transmit() is False
    with pytest.raises(DeviceFault, match="the interface's transmit queue is full"):
        bus.check(0.0)
    assert bus.transmit() is True  # what is safe is sent whatever waits
    assert len(interface.sent) == 2


def test_from_outside_a_setpoint_is_another_masters():
    bus, interface = opened()
    frames(bus, 0x21)
    bus.claim(0x80, "SYNC")
    interface.waiting = [(0x80, b"")]
    bus.receive(0.0)
    bus.check(0.0)  # nothing was sent yet: somebody else was there first
    assert not bus.has_spoken
    bus.transmit()
    assert bus.has_spoken
    interface.waiting = [(0x21, b"")]
    bus.receive(0.0)
    with pytest.raises(DeviceFault, match=r"master is on .* sends setpoints \(identifier 0x021"):
        bus.check(0.0)


@pytest.mark.parametrize("late", [False, True])
def test_who_is_to_be_alone_listens_first(late):
    bus, interface = opened()
    bus.claim(0x80, "SYNC")
    bus.wall.happens[10.0 + (0.3 if late else 0.15)] = lambda: interface.waiting.append((0x80, b""))
    if late:
        bus.expect_alone(0.2)
        assert bus.wall.time == pytest.approx(10.2, abs=0.6e-3)
    else:
        with pytest.raises(ConnectionFailed) as caught:
            bus.expect_alone(0.2)
        assert (
            "another master is on the bus: somebody sends SYNC (identifier 0x080); end it"
            in str(caught.value)
        )
    assert interface.sent == []


def test_an_answer_is_waited_for_until_the_clock_says_so():
    bus, interface = opened()
    heard, times = [], []
    bus.subscribe(0x21, lambda data, now: heard.append(now))
    bus.wall.happens[10.004] = lambda: interface.waiting.append((0x21, b""))
    assert bus.wait_until(lambda: bool(heard), 0.01) is True
    assert heard == [bus.wall.time] and heard[0] == pytest.approx(10.004, abs=0.6e-3)

    def looked():
        times.append(bus.wall.time)
        return False

    start = bus.wall.time
    assert bus.wait_until(looked, 0.004) is False
    assert times[0] == start and times[-1] >= start + 0.004 > times[-2]
    assert [b - a for a, b in pairwise(times)] == pytest.approx([0.5e-3] * (len(times) - 1))
    assert bus.wait_until(lambda: True, 0.0) is True
    times.clear()
    assert bus.wait_until(looked, 0.0) is False
    assert len(times) == 1


def test_a_bus_that_fails_meanwhile_ends_the_waiting():
    bus, interface = opened()
    interface.fails["drain"] = OSError(errno.ENETDOWN, "down")
    with pytest.raises(DeviceFault, match="the interface went down while in use"):
        bus.wait_until(lambda: False, 1.0)


def test_frames_that_filters_hold_back_are_counted_without_the_masters_own():
    bus, interface = opened()
    bus.claim(0x80, "SYNC")
    interface.others = 3
    assert bus.statistics()["unknown"] == 3
    for can_id in (0x601, 0x602, 0x80):  # the last one is claimed, and would be heard
        bus.send(can_id, b"")
    interface.others = 1
    assert bus.statistics()["unknown"] == 3  # one of two came back
    interface.others = 3
    assert bus.statistics()["unknown"] == 5
    assert bus.statistics()["frames_out"] == 3
    interface.others = 4
    bus.send(0x601, b"")
    bus.close()
    assert bus.statistics()["unknown"] == 8


def test_closing_says_farewell_once_if_anything_was_said():
    bus, interface = opened((0x0, b"\x02\x00"))
    (frame,) = frames(bus, 0x21)
    interface.dropped = 7
    bus.transmit()
    bus.close()
    bus.close()
    assert interface.sent[1:] == [(0x0, b"\x02\x00")]
    assert interface.shut == 1
    assert not frame.active
    assert bus.statistics()["dropped"] == 7
    bus.receive(0.0)
    with pytest.raises(OSError, match="the bus is not open"):
        bus.send(0x21, b"")

    silent, interface = opened((0x0, b"\x02\x00"))
    silent.close()
    assert interface.sent == [] and interface.shut == 1
    polite, interface = opened()
    polite.send(0x21, b"")
    polite.close()
    assert interface.sent == [(0x21, b"")]


def test_an_interface_that_fails_at_the_farewell_is_closed_nevertheless():
    bus, interface = opened((0x0, b""))
    bus.send(0x21, b"")
    interface.fails["send"] = OSError("broken")
    bus.close()
    assert interface.shut == 1
    assert bus.statistics()["refused"] == 1


def test_a_bus_that_is_opened_again_begins_anew():
    bus, interface = opened()
    bus.claim(0x80, "SYNC")
    bus.send(0x601, b"")
    interface.waiting = [(0x80, b"")]
    bus.receive(0.0)
    interface.queued = 1
    bus.close()
    bus.open()
    bus.check(0.0)
    assert not bus.has_spoken
    assert bus.statistics()["unknown"] == 0
    bus.interfaces[1].others = 1  # the frame of before was heard by the interface of before
    assert bus.statistics()["unknown"] == 1
    bus.expect_alone(0.0)
    assert bus.transmit() is True
