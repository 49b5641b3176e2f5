"""Frames that a bus loses, and frames that nobody expects: told when their count begins to rise."""

from collections.abc import Sequence
from typing import Final

from rig.hal import CyclicBus
from rig.runtime.phases import Events

_TOLD: Final = {
    "lost": "error frames say that the controller has lost frames",
    "dropped": "frames were lost, since nobody took them in time",
    "unknown": "frames have come that the profile knows nothing of",
    "late_samples": "samples answer an older SYNC than the last one: they come late",
    "strange_answers": "nodes answer questions that somebody else asks",
}


class BusWatch:
    """Compares the counters of buses from look to look.

    Parameters
    ----------
    buses : sequence of CyclicBus
        Looked at.
    events : callable
        Is told once per rise; every look would be too much.
    """

    def __init__(self, buses: Sequence[CyclicBus], events: Events) -> None:
        self._buses = buses
        self._events = events
        self._seen: dict[tuple[str, str], float] = {}
        self._rising: set[tuple[str, str]] = set()

    def look(self, t: float) -> None:
        """Tell what rises since the last look, and did not before."""
        for bus in self._buses:
            counts = bus.statistics()
            for kind, what in _TOLD.items():
                key, count = (bus.name, kind), counts.get(kind, 0)
                if count <= self._seen.get(key, 0):
                    self._rising.discard(key)
                elif key not in self._rising:
                    self._rising.add(key)
                    self._events(t, "bus", f"{bus.name}: {what}", {kind: count})
                self._seen[key] = count
