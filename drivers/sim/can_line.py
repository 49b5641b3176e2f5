"""A CAN bus between a master and its emulated nodes in one process.

What python-can's ``virtual`` interface does, for two ends and in virtual time: it copies every
frame attribute by attribute, for every receiver, under locks, which took a fifth of a run.
"""

import errno
from collections import deque

from rig.hal import FastCanBus


class CanLineEnd(FastCanBus):
    """One end of a `CanLine`."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._other: CanLineEnd | None = None
        self._open = True
        self._trouble: OSError | None = None

    def trouble_other(self, trouble: OSError | None) -> None:
        """Have whatever the other end does fail with this error from now on; None: with none."""
        if self._other is not None:
            self._other._trouble = trouble

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send a frame given by identifier (with flags of `drivers.can.frame`) and data.

        One that nobody receives, because the other end is not open, is gone.

        Raises
        ------
        OSError
            This end is closed.
        """
        if not self._open:
            raise OSError(f"{self._name}: the bus is closed")
        if self._trouble is not None:
            raise self._trouble
        other = self._other
        if other is not None:
            other._waiting.append((can_id, bytes(data)))

    def drain(self, limit: int = 256) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, as (identifier with flags, data).

        Raises
        ------
        OSError
            This end is closed.
        """
        if not self._open:
            raise OSError(f"{self._name}: the bus is closed")
        if self._trouble is not None and self._trouble.errno == errno.ENETDOWN:
            raise self._trouble
        waiting = self._waiting
        if len(waiting) > limit:
            return [waiting.popleft() for _ in range(limit)]
        frames = list(waiting)
        waiting.clear()
        return frames

    def shutdown(self) -> None:
        """Close this end: what it sent still arrives, what waits for it is lost. Idempotent."""
        self._open = False
        self._waiting.clear()
        other, self._other = self._other, None
        if other is not None:
            other._other = None

    def join(self, other: "CanLineEnd") -> None:
        """Pass frames between this end and another from now on."""
        self._other, other._other = other, self


class CanLine:
    """A bus whose nodes are emulated: their end is always there, the master's when it is opened.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.nodes_end = CanLineEnd(name)
        """For an `EmulatedBus`."""
        self._master: CanLineEnd | None = None

    def open(self) -> CanLineEnd:
        """Open the master's end, which there is one of: an earlier one is closed."""
        if self._master is not None:
            self._master.shutdown()
        self._master = end = CanLineEnd(self.name)
        end.join(self.nodes_end)
        return end
