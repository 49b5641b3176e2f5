"""Which paths are taken for serial lines before anything is opened."""

import os
import pty
from pathlib import Path

import pytest

from drivers.terminal import check_terminal

LINES = ["/dev/ttyUSB0", "/dev/ttyACM3", "/dev/ttymxc2", "/dev/ttyp0", "/dev/rfcomm0"]


@pytest.mark.parametrize("path", LINES)
def test_serial_lines_of_every_kind_of_port_are_let_through(path, monkeypatch):
    monkeypatch.setattr(Path, "exists", lambda _: True)
    check_terminal(path)
    check_terminal(f"{path}@115200")


@pytest.mark.parametrize(
    "path", ["/dev/watchdog", "/dev/null", "/dev/tty", "/dev/tty0", "/dev/sda"]
)
def test_what_does_something_when_it_is_opened_is_refused(path, monkeypatch):
    monkeypatch.setattr(Path, "exists", lambda _: True)
    with pytest.raises(OSError, match="is no serial line"):
        check_terminal(path)


def test_a_link_is_followed(tmp_path):
    master, slave = pty.openpty()
    good, bad = tmp_path / "adapter", tmp_path / "other"
    good.symlink_to(os.ttyname(slave))
    bad.symlink_to("/dev/null")
    check_terminal(str(good))
    with pytest.raises(OSError, match="other is no serial line"):
        check_terminal(str(bad))
    os.close(master)
    os.close(slave)
