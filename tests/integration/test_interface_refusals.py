"""CAN interfaces that cannot be used, by every command that opens one: exit 3, and what to do.

What needs a kernel with CAN (no such interface, one that is down or at another bit rate) is among
the tests on SocketCAN, ``tests/vcan/test_faults.py``.
"""

import contextlib
import ctypes
import errno
import os
import pty
import struct
from pathlib import Path

import pytest

can = pytest.importorskip("can")
pytest.importorskip("serial")

from drivers.canopen.bus import CanopenBus  # noqa: E402
from drivers.canopen.settings import CanBusSettings  # noqa: E402
from rig.cli import invoke  # noqa: E402
from rig.hal import FastCanBus, MonotonicClock  # noqa: E402
from rig.run_folder import RunFolder  # noqa: E402

COMMANDS = {
    "check": ("check", "cylinder"),
    "simulate": ("simulate", "cylinder"),
    "monitor": ("monitor", "cylinder", "--frames"),
    "run": (
        "run",
        "cylinder-step",
        "--no-report",
        "--set",
        "cylinder.limits.stop_energy=1 J",
        "--set",
        "loop.small_margin=a test",
    ),
}
_CAPABILITIES_3 = 0x2008_0522  # linux/capability.h
_OVERRIDES = 1 << 1 | 1 << 2  # CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH


@pytest.fixture(params=COMMANDS)
def refused(request, tmp_path, capfd):
    """Return what a command says as it refuses an interface; nothing was energised."""

    def run(on):
        runs = tmp_path / "runs"
        options = ["--out", str(runs), "--yes", "cylinder"] if request.param == "run" else []
        code = invoke([*COMMANDS[request.param], "--on", on, *options])
        said = capfd.readouterr().err
        assert code == 3, said
        assert "Traceback" not in said
        if options:
            (folder,) = runs.iterdir()
            assert RunFolder.open(folder).status.value == "faulted"
            assert "armed" not in (folder / "events.jsonl").read_text()
            assert "rig check" not in said, "the bus cannot be asked either"
        return said

    return run


@contextlib.contextmanager
def an_ordinary_user():
    """Take away from root, in this thread, what lets it open files whatever their mode is."""
    system = ctypes.CDLL(None, use_errno=True)
    header = struct.pack("=Ii", _CAPABILITIES_3, 0)
    sets = (ctypes.c_uint32 * 6)()  # effective, permitted, inheritable; twice
    assert system.capget(header, sets) == 0
    before = sets[0]
    sets[0] &= ~_OVERRIDES
    assert system.capset(header, sets) == 0
    try:
        yield
    finally:
        sets[0] = before
        assert system.capset(header, sets) == 0


@pytest.fixture
def port():
    """The serial port of an adapter that answers nothing."""
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_a_port_that_belongs_to_another_group(refused, port):
    Path(port).chmod(0o000)
    with an_ordinary_user():
        said = refused(f"slcan:{port}")
    assert f"error: {port}" in said or f"faulted: {port}" in said
    assert "Permission denied" in said
    assert "sudo usermod -aG dialout $USER" in said


def test_an_adapter_that_is_not_plugged_in(refused):
    said = refused("slcan:/dev/ttyNone0")
    assert "No such file" in said
    assert "ls /dev/serial/by-id" in said


def test_an_interface_that_python_can_does_not_know(refused):
    said = refused("slcam:/dev/ttyACM0")
    assert "'slcam' not supported; there are " in said
    assert ", slcan, socketcan, " in said


@pytest.mark.parametrize(
    ("interface", "maker", "complaint", "advice"),
    [
        ("gs_usb:0", "can.Bus", "No module named 'usb'", "pip install 'python-can[gs-usb]'"),
        (
            "gs_usb:0",
            "can.Bus",
            "Access denied (insufficient permissions)",
            "ip -brief link show type can",
        ),
        (
            "udp_multicast:239.74.163.2",
            "drivers.can.interfaces.MulticastBus",
            "No such device",
            "ip route add 224.0.0.0/4 dev lo",
        ),
    ],
)
def test_what_else_an_interface_may_say(refused, monkeypatch, interface, maker, complaint, advice):
    def refuse(*_, **options):
        raise OSError(complaint)

    monkeypatch.setattr(maker, refuse)
    assert f"{complaint}; " in (said := refused(interface))
    assert advice in said


def test_a_group_that_is_none(refused):
    said = refused("udp_multicast:nowhere.invalid")
    assert "nowhere.invalid" in said
    assert "properly shut down" not in said, "python-can's own complaint helps nobody"


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOBUFS, "the interface's transmit queue is full: nobody acknowledges the frames"),
        (errno.ENETDOWN, "the interface went down while in use"),
        (errno.EIO, "the interface refused a frame"),
    ],
    ids=errno.errorcode.get,
)
def test_an_interface_that_refuses_the_questions_of_check(number, words, monkeypatch, capfd):
    class Refusing(FastCanBus):
        def drain(self, limit):
            return []

        def send_data(self, can_id, data):
            raise OSError(number, os.strerror(number))

        def shutdown(self):
            pass

    monkeypatch.setattr("drivers.can.open_bus", lambda settings: Refusing())
    assert invoke(["check", "cylinder", "--on", "can0"]) == 3
    assert f"error: can0: {words}" in capfd.readouterr().err


def test_an_adapter_that_is_pulled_may_complain_when_it_is_closed():
    class Pulled(FastCanBus):
        closed = False

        def drain(self, limit):
            return []

        def send_data(self, can_id, data):
            raise OSError(5, "Input/output error")

        def shutdown(self):
            self.closed = True
            raise OSError(5, "Input/output error")

    interface = Pulled()
    bus = CanopenBus("can0", CanBusSettings("slcan", "x"), lambda: interface, MonotonicClock())
    bus.open()
    bus.close()
    assert interface.closed
