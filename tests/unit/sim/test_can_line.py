"""The bus between a master and emulated nodes in one process, as python-can's interfaces behave."""

import can
import pytest

from drivers.can.fast_path import drain_of, send_of
from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from drivers.can.message import Message
from drivers.sim.can_line import CanLine


def python_can_ends():
    ends = [can.Bus(interface="virtual", channel="test_can_line") for _ in range(2)]
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
    send_of(master)(can_id, bytearray(data))
    send_of(nodes)(can_id, data)
    for end in ends:
        assert drain_of(end)(10) == [(can_id, data)]
        assert drain_of(end)(10) == []


def test_a_message_arrives_with_all_its_attributes(ends):
    master, nodes = ends
    master.send(Message(arbitration_id=0x1234, data=b"\x05\x06", is_extended_id=True))
    master.send(Message(arbitration_id=0x12, is_extended_id=False, is_remote_frame=True))
    first, second = nodes.recv(0.0), nodes.recv(0.0)
    assert (first.arbitration_id, bytes(first.data)) == (0x1234, b"\x05\x06")
    assert (first.is_extended_id, first.is_remote_frame, first.is_error_frame) == (
        True,
        False,
        False,
    )
    assert (second.arbitration_id, bytes(second.data)) == (0x12, b"")
    assert (second.is_extended_id, second.is_remote_frame) == (False, True)
    assert nodes.recv(0.0) is None


def test_an_error_frame_is_told_from_data():
    line = CanLine("can0")
    master = line.open()
    line.nodes_end.send_data(0x40 | ERROR_FLAG, bytes(8))
    frame = master.recv(0.0)
    assert frame.is_error_frame
    assert frame.arbitration_id == 0x40


def test_order_and_limit(ends):
    master, nodes = ends
    for number in range(5):
        send_of(nodes)(0x100 + number, b"")
    assert [can_id for can_id, _ in drain_of(master)(3)] == [0x100, 0x101, 0x102]
    assert [can_id for can_id, _ in drain_of(master)(3)] == [0x103, 0x104]


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
    send_of(master)(0x000, b"\x02\x00")
    master.shutdown()
    assert drain_of(nodes)(10) == [(0x000, b"\x02\x00")]


def test_a_closed_end_refuses(ends):
    master, _ = ends
    send, drain = send_of(master), drain_of(master)
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
