"""Devices that are files, as ``/dev/ttyUSB0``: what keeps one from being opened, and what helps."""

import grp
import os
import stat
from pathlib import Path


def device_trouble(path: Path) -> str:
    """Return why a device's file cannot be opened, and what mends that; empty: nobody knows."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        near = sorted(path.parent.glob(path.name.rstrip("0123456789") + "*"))
        there = f", or name another one: {', '.join(map(str, near[:4]))}" if near else ""
        return f"it is not there; plug it in{there}"
    except OSError as error:
        return str(error.strerror or error)
    if not stat.S_ISCHR(mode):
        return "it is no device"
    return "" if may_open(path) else f"permission denied; {permitting(path)}"


def may_open(path: Path) -> bool:
    """Return whether this user may read from and write to a device."""
    return os.access(path, os.R_OK | os.W_OK)


def permitting(path: Path) -> str:
    """Return the command after which this user may open a device: its group's, if it has one."""
    found = path.stat()
    if found.st_gid == 0 or found.st_mode & 0o060 != 0o060:
        return f"sudo chmod a+rw {path}"
    try:
        group = grp.getgrgid(found.st_gid).gr_name
    except KeyError:
        group = str(found.st_gid)
    return f"sudo usermod -aG {group} $USER, then log in again"
