"""One master per interface and host: a lock that a process holds as long as it lives."""

import fcntl
import os
import re
import tempfile
from pathlib import Path

from rig.hal import BusSettings, ConnectionFailed

_IN_PROCESS = ("virtual",)
"""Interfaces of python-can that never leave the process."""


class InterfaceLocks:
    """The interfaces that this process drives.

    Each is a file in the folder for temporary files, which holds the process's number and is
    locked (flock): the kernel gives it back when the process dies.
    """

    def __init__(self) -> None:
        self._held: list[int] = []

    def take(self, bus: str, settings: BusSettings) -> None:
        """Take an interface for a bus.

        Raises
        ------
        ConnectionFailed
            Another process has it; with its number.
        """
        end = settings.endpoint()
        if end.interface in _IN_PROCESS:
            return
        name = re.sub(r"[^A-Za-z0-9.-]", "_", f"rig-{end.interface}-{end.channel}.lock")
        path = Path(tempfile.gettempdir()) / name
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
        except PermissionError:  # another user made it
            descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            owner = os.pread(descriptor, 32, 0).decode(errors="replace").strip()
            os.close(descriptor)
            raise ConnectionFailed(
                bus,
                f"another master is on the bus: process {owner or 'unknown'} of this host drives "
                f"{end.channel} ({end.interface}); end it, or wait for its end",
            ) from error
        self._held.append(descriptor)
        if os.access(path, os.W_OK):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)

    def give_back(self) -> None:
        """Give every interface back. Idempotent."""
        while self._held:
            os.close(self._held.pop())
