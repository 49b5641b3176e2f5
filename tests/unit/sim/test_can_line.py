"""The bus between a master and emulated nodes in one process, as python-can's interfaces behave."""

import can
import pytest

from drivers.can.fast_path import AdaptedBus
from drivers.can.frame import EXTENDED_FLAG, REMOTE_FLAG
from drivers.sim.can_line import CanLine


def python_can_ends():
    ends = [AdaptedBus(can.Bus(interface="virtual", channel="test_can_line")) for _ in range(2)]
    yield ends
    for end in ends:
        end.shutdown()


def can_line_ends():
    line = CanLine("can0")
    yield [line.open(), line.nodes_end]


@pytest.fixture(params=[python_can_ends, can_line_ends])
def ends(request):
    yield from request.param()


@pytest.mark.parametrize(
    ("can_id", "data"),
    [
        (0x123, b""),
        (0x7FF, bytes(range(8))),
        (0x1ABCDEF0 | EXTENDED_FLAG, b"\x01"),
        (0x181 | REMOTE_FLAG, b""),
    ],
)
def test_frames_arrive_as_they_were_sent(ends, can_id, data):
    master, nodes = ends
    master.send_data(can_id, bytearray(data))
    nodes.send_data(can_id, data)
    for end in ends:
        assert end.drain(10) == [(can_id, data)]
        assert end.drain(10) == []


def test_order_and_limit(ends):
    master, nodes = ends
    for number in range(5):
        nodes.send_data(0x100 + number, b"")
    assert [can_id for can_id, _ in master.drain(3)] == [0x100, 0x101, 0x102]
    assert [can_id for can_id, _ in master.drain(3)] == [0x103, 0x104]


def test_what_nobody_receives_is_gone():
    line = CanLine("can0")
    line.nodes_end.send_data(0x701, b"\x00")  # nobody has opened the bus yet
    master = line.open()
    assert master.drain() == []
    line.nodes_end.send_data(0x701, b"\x7f")
    master.shutdown()
    line.nodes_end.send_data(0x701, b"\x7f")
    assert line.open().drain() == []


def test_what_was_sent_before_closing_arrives(ends):
    master, nodes = ends
    master.send_data(0x000, b"\x02\x00")
    master.shutdown()
    assert nodes.drain(10) == [(0x000, b"\x02\x00")]


def test_a_closed_end_refuses(ends):
    master, _ = ends
    send, drain = master.send_data, master.drain
    master.shutdown()
    for call in (lambda: send(0x123, b""), lambda: drain(1)):
        with pytest.raises((OSError, can.CanError)):
            call()


def test_the_data_is_not_shared_with_the_sender():
    line = CanLine("can0")
    master, data = line.open(), bytearray(b"\x01\x02")
    master.send_data(0x123, data)
    data[0] = 9
    assert line.nodes_end.drain() == [(0x123, b"\x01\x02")]


def test_a_second_master_takes_the_place_of_the_first():
    line = CanLine("can0")
    first, second = line.open(), line.open()
    line.nodes_end.send_data(0x123, b"")
    assert second.drain() == [(0x123, b"")]
    with pytest.raises(OSError, match="closed"):
        first.drain()
