"""Devices that are files: what is said of one that cannot be opened."""

import os
import stat
import sys
from pathlib import Path

import pytest

from controllers.motion import InfeasibleMotion
from rig.hal.device_files import device_trouble, may_open
from rig.mechanisms.arm import gamepad


@pytest.fixture
def closed(monkeypatch):
    """Let every device be one that this user may not open, with a mode and a group."""

    def close(mode, group):
        found = os.stat_result((stat.S_IFCHR | mode, 0, 0, 1, 0, group, 0, 0, 0, 0))
        monkeypatch.setattr(Path, "stat", lambda *_, **__: found)
        monkeypatch.setattr(os, "access", lambda *_: False)

    return close


def test_a_device_that_can_be_opened_has_no_trouble():
    assert device_trouble(Path("/dev/null")) == "" and may_open(Path("/dev/null"))


@pytest.mark.parametrize(
    ("mode", "group", "mend"),
    [
        (0o660, 5, "sudo usermod -aG tty $USER, then log in again"),
        (0o660, 4_000_000, "sudo usermod -aG 4000000 $USER, then log in again"),
        (0o600, 5, "sudo chmod a+rw /dev/ttyUSB0"),  # its group may not, either
        (0o660, 0, "sudo chmod a+rw /dev/ttyUSB0"),  # nobody joins root's
    ],
)
def test_a_device_without_permission_comes_with_the_command(closed, mode, group, mend):
    closed(mode, group)
    assert device_trouble(Path("/dev/ttyUSB0")) == f"permission denied; {mend}"


def test_a_device_that_is_not_there_names_those_that_are(tmp_path):
    said = "it is not there; plug it in"
    assert device_trouble(tmp_path / "video0") == said
    (tmp_path / "video2").symlink_to("/dev/null")
    assert device_trouble(tmp_path / "video0") == f"{said}, or name another one: {tmp_path}/video2"
    assert device_trouble(tmp_path) == "it is no device"


def test_a_gamepad_that_may_not_be_read_is_named_with_the_command(closed, monkeypatch):
    class Evdev:
        @staticmethod
        def list_devices():
            return []

        @staticmethod
        def InputDevice(path):
            raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "glob", lambda *_: [Path("/dev/input/event4")])
    monkeypatch.setitem(sys.modules, "evdev", Evdev)
    closed(0o660, 5)
    mend = r"sudo usermod -aG tty \$USER, then log in again\.$"
    with pytest.raises(InfeasibleMotion, match=f"no gamepad .*event4 may not be read: {mend}"):
        gamepad._open("")
    with pytest.raises(InfeasibleMotion, match=f"event5 cannot be read: permission denied; {mend}"):
        gamepad._open("/dev/input/event5")
