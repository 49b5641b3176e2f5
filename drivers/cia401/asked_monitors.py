"""The monitors of a module that sends no samples any more, asked for one by one."""

import struct
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from math import inf

from drivers.canopen.asked import AskedObjects
from drivers.canopen.mapping import SIZES, STRUCT_CODES, Entry
from rig.hal import ConnectionFailed, Reading, Vector

MonitorLine = tuple[int, Callable[[float], float], float, float]
"""Which channel, what makes a pressure of its counts, and between which its wire is whole."""


class AskedMonitors:
    """Pressures by SDO, one object each time it is asked: a bus of 1 kHz bears no more.

    Parameters
    ----------
    asked : AskedObjects
        Of the module's node.
    entries : sequence of Entry
        Each monitor's object.
    lines : sequence of MonitorLine
        Of the same channels.
    wake : callable
        Has the node answer, which a stopped one does not; it follows no setpoint even so.

    Attributes
    ----------
    asking : bool
        Whether it was woken: to stop it again would have it answer nothing.
    """

    def __init__(
        self,
        asked: AskedObjects,
        entries: Sequence[Entry],
        lines: Sequence[MonitorLine],
        wake: Callable[[], None],
    ) -> None:
        self.asking = False
        self._wake = wake
        self._asked = asked
        self._entries = tuple(entries)
        self._lines = tuple(lines)
        self._pressures = [0.0] * len(self._entries)
        self._told_at = [-inf] * len(self._entries)
        self._next = 0

    def ask(self) -> None:
        """Ask for the next monitor. Never raises: a bus that is gone tells nothing."""
        k = self._next
        self._next = (k + 1) % len(self._entries)
        entry = self._entries[k]
        with suppress(ConnectionFailed, OSError):
            if not self.asking:
                self._wake()
            self.asking = True
            self._asked.ask(entry.object, entry.sub, partial(self._take, k))

    def forget(self) -> None:
        """Expect no answer any more: whoever reads these objects gets his own."""
        self.asking = False
        for entry in self._entries:
            self._asked.forget(entry.object, entry.sub)

    def reading(self) -> Reading[Vector]:
        """Return the pressures, Pa gauge, and when the oldest was told, s."""
        return Reading(tuple(self._pressures), min(self._told_at))

    def _take(self, k: int, data: bytes, now: float) -> None:
        kind = self._entries[k].type
        (raw,) = struct.unpack("<" + STRUCT_CODES[kind], data[: SIZES[kind]])
        _, decode, low, high = self._lines[k]
        if low <= raw <= high:  # else its wire is broken, and nothing is known
            self._pressures[k] = decode(raw)
            self._told_at[k] = now
