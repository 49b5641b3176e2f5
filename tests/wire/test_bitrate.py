"""An interface at another bit rate than the profile's is refused before anything is sent."""

import json

import pytest

from drivers.can import socketcan
from drivers.can.bitrate import bitrate_of

CAN = {"info_kind": "can", "info_data": {"state": "ERROR-ACTIVE", "bittiming": {"bitrate": 500000}}}


@pytest.mark.parametrize(
    ("told", "bitrate"),
    [
        (json.dumps([{"ifname": "can0", "linkinfo": CAN}]), 500_000),
        (json.dumps([{"ifname": "can0", "linkinfo": {"info_kind": "vcan"}}]), None),
        ("[]", None),
        ("an ip that knows no JSON", None),
    ],
)
def test_what_ip_tells(tmp_path, monkeypatch, told, bitrate):
    ip = tmp_path / "ip"
    ip.write_text(f"#!/bin/sh\ncat <<'END'\n{told}\nEND\n")
    ip.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    assert bitrate_of("can0") == bitrate


def test_without_ip_nobody_tells(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    assert bitrate_of("can0") is None


@pytest.mark.parametrize("found", [1_000_000, None])
def test_the_same_or_unknown_is_no_error(monkeypatch, found):
    monkeypatch.setattr(socketcan, "bitrate_of", lambda channel: found)
    assert socketcan.wrong_bitrate("can0", 1_000_000) is None


def test_another_one_is_told_with_what_mends_it(monkeypatch):
    monkeypatch.setattr(socketcan, "bitrate_of", lambda channel: 500_000)
    assert socketcan.wrong_bitrate("can0", 1_000_000) == (
        "the interface runs at 500000 bit/s and the profile asks for 1000000; set it with: "
        "sudo ip link set can0 down && sudo ip link set can0 type can bitrate 1000000 "
        "restart-ms 100 && sudo ip link set can0 txqueuelen 100 up"
    )
