"""What is said of interfaces, ports and cameras while no profile names any."""

import os
import socket

import pytest

from rig.doctor.look import Fitness
from rig.doctor.ports import look_at_ports


@pytest.fixture
def computer(tmp_path, monkeypatch):
    """A computer with SocketCAN and nothing that is plugged in."""

    class Socket:
        def __init__(self, *_):
            pass

        def close(self):
            pass

    monkeypatch.setattr(socket, "socket", Socket)
    (tmp_path / "dev").mkdir()
    return tmp_path


def look(computer):
    return list(look_at_ports(computer / "sys", computer / "dev"))


def plug(computer, name, kind, flags):
    folder = computer / "sys/class/net" / name
    folder.mkdir(parents=True)
    (folder / "type").write_text(f"{kind}\n")
    (folder / "flags").write_text(f"{flags:#x}\n")


def test_a_kernel_without_socketcan_says_how_it_gets_it(computer, monkeypatch):
    def refuse(*_):
        raise OSError(97, "Address family not supported by protocol")

    monkeypatch.setattr(socket, "socket", refuse)
    found = look(computer)[0]
    assert found == (
        "SocketCAN", "this kernel has none (Address family not supported by protocol)",
        Fitness.POOR, "sudo modprobe can_raw",
    )  # fmt: skip


def test_a_computer_without_adapters_lacks_nothing_that_a_rig_was_said_to_need(computer):
    can, serial, cameras = look(computer)
    assert (can.verdict, can.found) == (
        Fitness.POOR,
        "the kernel has it, and there is no interface",
    )
    assert (serial.found, cameras.found) == ("none", "none")
    assert (serial.verdict, cameras.verdict) == (Fitness.OK, Fitness.OK)


def test_interfaces_are_told_from_other_networks_and_up_from_down(computer, monkeypatch):
    monkeypatch.setattr("drivers.can.bitrate.bitrate_of", {"can0": 500_000}.get)
    plug(computer, "can0", 280, 0x41)
    plug(computer, "can1", 280, 0x40)
    plug(computer, "eth0", 1, 0x1003)
    plug(computer, "vcan0", 280, 0x41)
    up, down, virtual, *_ = look(computer)
    assert up == ("CAN interface can0", "up, 500000 bit/s", Fitness.OK, "")
    assert (down.what, down.found, down.verdict) == ("CAN interface can1", "is down", Fitness.POOR)
    assert "ip link set can1 type can bitrate" in down.mend
    assert virtual == ("CAN interface vcan0", "up", Fitness.OK, "")


def test_a_port_that_may_not_be_opened_comes_with_what_opens_it(computer, monkeypatch):
    (computer / "dev/ttyUSB0").symlink_to("/dev/null")
    assert look(computer)[1] == (
        f"serial port {computer}/dev/ttyUSB0", "can be opened", Fitness.OK, "",
    )  # fmt: skip
    monkeypatch.setattr(os, "access", lambda *_: False)
    closed = look(computer)[1]
    assert (closed.verdict, closed.found) == (Fitness.POOR, "may not be opened")
    assert closed.mend == f"sudo chmod a+rw {computer}/dev/ttyUSB0"
