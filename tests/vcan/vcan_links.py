"""The virtual CAN interfaces of the tests."""

import socket
import subprocess
from pathlib import Path

LINKS = tuple(f"vcan{number}" for number in range(7))
"""Enough for every rig on links of its own."""


def missing() -> list[str]:
    """Return the interfaces that are not there or not up."""
    return [link for link in LINKS if not _is_up(link)]


def make_links() -> str | None:
    """Set up what is missing; return why it cannot be done, or None."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        return f"this kernel has no SocketCAN ({error.strerror})"
    for link in missing():
        ip("link", "add", "dev", link, "type", "vcan")
        ip("link", "set", link, "up")
    left = missing()
    return f"{', '.join(left)} cannot be set up without root or the module vcan" if left else None


def ip(*arguments: str) -> None:
    """Call ip; what came of it is seen at the interface."""
    subprocess.run(["ip", *arguments], capture_output=True, check=False)


def _is_up(link: str) -> bool:
    try:
        return bool(int(Path("/sys/class/net", link, "flags").read_text(), 16) & 1)
    except OSError:
        return False
