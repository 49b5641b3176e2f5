"""Frames by multicast never leave the host, whatever the profile asks for."""

import socket
import time

import pytest

from drivers.can import open_bus
from drivers.canopen.settings import CanBusSettings
from rig.hal import ConnectionFailed

GROUPS = {
    "239.74.163.7": (socket.IPPROTO_IP, socket.IP_MULTICAST_TTL),
    "ff15:7079:7468:6f6e:6465:6d6f:6d63:6173": (socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS),
}


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("options", [{}, {"hop_limit": 8}], ids=["default", "asked"])
def test_multicast_has_no_hops(group, options):
    pytest.importorskip("msgpack")
    try:
        bus = open_bus(CanBusSettings("udp_multicast", group, options={**options, "port": 43199}))
    except ConnectionFailed as error:
        pytest.skip(f"this machine has no such network: {error}")
    try:
        with socket.socket(fileno=socket.dup(bus.fileno())) as same:
            assert same.getsockopt(*GROUPS[group]) == 0
    finally:
        bus.shutdown()


def test_own_frames_do_not_come_back_and_the_same_ones_of_another_do():
    pytest.importorskip("msgpack")
    settings = CanBusSettings("udp_multicast", "239.74.163.8", options={"port": 43198})
    try:
        own, other = open_bus(settings), open_bus(settings)
    except ConnectionFailed as error:
        pytest.skip(f"this machine has no such network: {error}")
    try:
        frames = [(0x080, b""), (0x210, b"\x01\x02"), (0x77F, b"\x05"), (0x080, b"")]
        for frame in frames:
            own.send_data(*frame)
        assert drained(other, len(frames)) == frames
        for frame in frames[:2]:
            other.send_data(*frame)
        assert drained(own, 2) == frames[:2]
    finally:
        own.shutdown()
        other.shutdown()


def drained(bus, count):
    """Return frames, for which a kernel may take a moment."""
    frames = []
    for _ in range(1000):
        frames += bus.drain(256)
        if len(frames) >= count:
            break
        time.sleep(1e-3)
    time.sleep(5e-3)  # what comes too much comes now
    return frames + bus.drain(256)


def test_without_msgpack_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("can.interfaces.udp_multicast.utils.msgpack", None)
    with pytest.raises(ConnectionFailed, match=r"pip install 'python-can\[multicast\]'"):
        open_bus(CanBusSettings("udp_multicast", "239.74.163.7"))
