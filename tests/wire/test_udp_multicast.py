"""Frames by multicast never leave the host, whatever the profile asks for."""

import socket

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


def test_without_msgpack_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("can.interfaces.udp_multicast.utils.msgpack", None)
    with pytest.raises(ConnectionFailed, match=r"pip install 'python-can\[multicast\]'"):
        open_bus(CanBusSettings("udp_multicast", "239.74.163.7"))
