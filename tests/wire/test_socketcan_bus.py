"""The raw-socket bus over a socket pair: `struct can_frame` both ways."""

import errno
import socket
import struct

import pytest
from scripted_bus import TestClock

from drivers.can import open_bus
from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from drivers.can.socketcan import SocketCanBus, link_command
from drivers.canopen.bus import CanopenBus
from drivers.canopen.settings import CanBusSettings
from rig.hal import ConnectionFailed, DeviceFault


@pytest.fixture
def pair():
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    bus = SocketCanBus(near, "can0")
    far.setblocking(False)
    yield bus, far
    bus.shutdown()
    far.close()


def test_a_frame_is_sixteen_bytes_as_the_kernel_has_them(pair):
    bus, far = pair
    bus.send_data(0x201, bytes.fromhex("FF7F00"))
    assert far.recv(64) == struct.pack("=IB3x8s", 0x201, 3, b"\xff\x7f\0")
    bus.send_data(0x12345 | EXTENDED_FLAG, b"\1")
    assert far.recv(64)[:4] == struct.pack("=I", 0x80012345)
    bus.send_data(0x701 | REMOTE_FLAG, b"")
    assert far.recv(64)[:5] == struct.pack("=IB", 0x40000701, 0)


def test_draining_takes_what_waits_and_no_more_than_asked(pair):
    bus, far = pair
    for n in range(5):
        far.send(struct.pack("=IB3x8s", 0x180 + n, n, bytes(range(n))))
    assert bus.drain(3) == [(0x180, b""), (0x181, b"\0"), (0x182, b"\0\1")]
    assert bus.drain() == [(0x183, b"\0\1\2"), (0x184, b"\0\1\2\3")]
    assert bus.drain() == []


def test_draining_knows_every_kind_of_frame(pair):
    bus, far = pair
    for can_id in (0x181, 0x80012345, 0x40000701, 0x20000040):
        far.send(struct.pack("=IB3x8s", can_id, 8, bytes(8)))
    assert [can_id for can_id, _ in bus.drain()] == [
        0x181, 0x12345 | EXTENDED_FLAG, 0x701 | REMOTE_FLAG, 0x40 | ERROR_FLAG,
    ]  # fmt: skip


def test_a_full_queue_raises_and_is_not_tried_again(pair):
    bus, _ = pair
    with pytest.raises(OSError) as caught:
        for _ in range(100_000):
            bus.send_data(0x201, bytes(8))
    assert caught.value.errno in (errno.EAGAIN, errno.ENOBUFS)


def test_a_missing_interface_says_what_mends_it():
    with pytest.raises(ConnectionFailed, match=r"can77.*(sudo ip link set can77|modprobe)"):
        open_bus(CanBusSettings("socketcan", "can77", 500_000))


def test_an_unknown_interface_is_named():
    with pytest.raises(ConnectionFailed, match="nothing-like-it"):
        open_bus(CanBusSettings("nothing-like-it", "can0"))


def test_the_command_sets_the_bit_rate():
    assert "type can bitrate 500000 restart-ms 100" in link_command("can0", 500_000)
    assert "add dev vcan0 type vcan" in link_command("vcan0", 1, add=True)


def test_an_interface_of_python_can_is_made_to_fit_when_it_is_opened():
    settings = CanBusSettings("virtual", "test_socketcan_bus")
    near, far = open_bus(settings), open_bus(settings)
    try:
        far.send_data(0x181, b"\1")
        assert near.drain(10) == [(0x181, b"\1")]
        assert (near.backlog(), near.count_dropped(), near.count_others()) == (0, 0, 0)
        assert near.fileno() == -1
    finally:
        near.shutdown()
        far.shutdown()


def test_the_canopen_bus_speaks_through_python_can_as_well():
    import can

    settings = CanBusSettings("virtual", "test_canopen_over_python_can")
    far = can.Bus("test_canopen_over_python_can", interface="virtual")
    bus = CanopenBus("can0", settings, lambda: open_bus(settings), TestClock())
    taken = []
    bus.subscribe(0x181, lambda data, now: taken.append((data, now)))
    bus.open()
    try:
        for message in (
            can.Message(arbitration_id=0x181, data=b"\1\2", is_extended_id=False),
            can.Message(arbitration_id=0x181, data=b"\3", is_extended_id=True),
            can.Message(arbitration_id=0x181, is_remote_frame=True, is_extended_id=False),
            can.Message(arbitration_id=0x40, data=bytes(8), is_error_frame=True),
        ):
            far.send(message)
        bus.receive(1.5)
        assert taken == [(b"\1\2", 1.5)]
        assert bus.statistics()["unknown"] == 1
        assert bus.statistics()["remote"] == 1
        with pytest.raises(DeviceFault, match="bus-off"):
            bus.check(1.5)
        bus.transmit(1.5)
        assert [far.recv(1.0).arbitration_id for _ in range(2)] == [0x080, 0x77F]
    finally:
        bus.close()
        far.shutdown()
