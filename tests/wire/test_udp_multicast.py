"""Frames by multicast never leave the host, whatever the profile asks for."""

import random
import socket
import sys
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
        for end in (bus._socket, bus._sender):
            assert end.getsockopt(*GROUPS[group]) == 0
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


@pytest.mark.parametrize("sent", [1, 256, 270])
def test_however_many_own_frames_wait_none_is_taken_for_anothers(ends, sent):
    """They are looked for late where the host is busy; beyond some 270 the kernel drops them."""
    near, far, _ = ends
    for _ in range(3):
        for k in range(sent):
            near.send_data(0x201 + k % 12, bytes(4))
        assert drained(near, 1) == []
    far.send_data(0x201, bytes(4))
    assert drained(near, 1) == [(0x201, bytes(4))]


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
    monkeypatch.setitem(sys.modules, "msgpack", None)
    with pytest.raises(ConnectionFailed, match=r"pip install 'python-can\[multicast\]'"):
        open_bus(CanBusSettings("udp_multicast", "239.74.163.7"))


@pytest.fixture
def ends():
    """Return two ends of a group, and what sends datagrams to it."""
    pytest.importorskip("msgpack")
    settings = CanBusSettings("udp_multicast", "239.74.163.9", options={"port": 43197})
    try:
        near, far = open_bus(settings), open_bus(settings)
    except ConnectionFailed as error:
        pytest.skip(f"this machine has no such network: {error}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        yield near, far, lambda datagram, to="239.74.163.9": sender.sendto(datagram, (to, 43197))
    near.shutdown()
    far.shutdown()


def content(**changes):
    return {
        "timestamp": 0.0, "arbitration_id": 0x181, "is_extended_id": False,
        "is_remote_frame": False, "is_error_frame": False, "channel": None, "dlc": 2,
        "data": b"\1\2", "is_fd": False, "bitrate_switch": False, "error_state_indicator": False,
        **changes,
    }  # fmt: skip


def test_what_is_no_frame_is_counted_and_ends_nothing(ends):
    import msgpack

    near, far, send = ends
    chance = random.Random(7)
    strange = [
        b"", b"\xc1", chance.randbytes(20), chance.randbytes(2000), msgpack.packb([1, 2]),
        msgpack.packb({}), b"\x91" * 4000,
        *(msgpack.packb(content(**change)) for change in (
            {"arbitration_id": "one"}, {"arbitration_id": 2**40}, {"arbitration_id": -1},
            {"arbitration_id": 0x800}, {"arbitration_id": True}, {"data": None}, {"data": bytes(9)},
            {"data": "text"}, {"is_fd": True, "data": bytes(64)}, {"is_error_frame": True},
            {"is_extended_id": 3}, {"is_remote_frame": None},
        )),
    ]  # fmt: skip
    for datagram in strange:
        send(datagram)
    far.send_data(0x182, b"ok")
    assert drained(near, 1) == [(0x182, b"ok")]
    assert near.count_dropped() == len(strange)


@pytest.mark.parametrize("seed", range(3))
def test_frames_of_python_can_are_understood_and_understand(ends, seed):
    can = pytest.importorskip("can")
    near, _, _ = ends
    chance = random.Random(seed)
    is_long = chance.random() < 0.5
    number = chance.randrange(1 << (29 if is_long else 11))
    data = chance.randbytes(chance.randrange(9))
    flagged = number | (0x8000_0000 if is_long else 0)
    with can.Bus("239.74.163.9", interface="udp_multicast", port=43197, hop_limit=0) as other:
        other.send(can.Message(arbitration_id=number, data=data, is_extended_id=is_long))
        assert drained(near, 1) == [(flagged, data)]
        near.send_data(flagged, data[::-1])
        heard = [other.recv(1.0) for _ in range(2)]  # its own, and ours
    assert (heard[1].arbitration_id, bytes(heard[1].data)) == (number, data[::-1])
    assert heard[1].is_extended_id is is_long


def test_a_datagram_to_the_host_and_not_to_the_group_is_not_heard(ends):
    import msgpack

    near, far, send = ends
    for host in {"127.0.0.1", *own_addresses()}:
        send(msgpack.packb(content()), host)
    far.send_data(0x182, b"ok")
    assert drained(near, 1) == [(0x182, b"ok")]


def own_addresses():
    """Return the addresses of this host that others reach it by."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing
            return [probe.getsockname()[0]]
        except OSError:
            return []


def test_what_another_host_sends_is_counted_and_dropped(ends, monkeypatch):
    near, far, _ = ends
    monkeypatch.setattr(near, "_is_local", dict.fromkeys(["127.0.0.1", *own_addresses()], False))
    far.send_data(0x182, b"no")
    assert drained(near, 1) == [] and near.count_dropped() == 1


def test_only_an_address_of_this_host_is_taken_for_its_own(ends):
    near, _, _ = ends
    assert near._comes_from_here(("127.0.0.1", 5))
    assert not near._comes_from_here(("192.0.2.7", 5))
    assert not any(near._comes_from_here((f"198.51.{k}.1", 5)) for k in range(200))
    assert len(near._is_local) <= 64
