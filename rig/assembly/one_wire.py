"""Buses of a profile that are one wire: what is asked on the one is heard on the other."""

from collections.abc import Mapping
from typing import Final

from rig.hal import DeviceFault, FastCanBus

_BATCH: Final = 256
"""Frames that are taken at a time …"""
_BATCHES: Final = 64
"""… and how many times: a bus that never falls silent must not be listened to for ever."""
_ENOUGH: Final = 0.5
"""Share of the questions that another bus hears if it is the same wire; some may be lost."""
_FEWEST: Final = 3
"""Of fewer questions somebody else may have asked the same ones."""


class AskingBus(FastCanBus):
    """A lent interface that keeps what is sent on it.

    Parameters
    ----------
    bus : FastCanBus
        Open.
    """

    def __init__(self, bus: FastCanBus) -> None:
        self._bus = bus
        self.sent: set[tuple[int, bytes]] = set()

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`."""
        return self._bus.drain(limit)

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send one frame."""
        self._bus.send_data(can_id, data)
        self.sent.add((can_id, bytes(data)))

    def fileno(self) -> int:
        """Return what to wait for, or -1."""
        return self._bus.fileno()

    def shutdown(self) -> None:
        """Release the interface."""
        self._bus.shutdown()


def forget_waiting(others: Mapping[str, FastCanBus]) -> None:
    """Take what waits on buses, so that only what comes from now on is heard."""
    for bus in others.values():
        _heard(bus)


def find_one_wire(name: str, asked: AskingBus, others: Mapping[str, FastCanBus]) -> None:
    """Raise if another bus has heard what was asked on this one.

    Parameters
    ----------
    name : str
        The bus that was asked, by the profile's name.
    asked : AskingBus
        Its interface.
    others : mapping of str to FastCanBus
        The open interfaces of other buses.

    Raises
    ------
    DeviceFault
        They are one wire.
    """
    for other, bus in others.items():
        both = asked.sent & _heard(bus)
        if len(both) >= max(_FEWEST, _ENOUGH * len(asked.sent)):
            raise DeviceFault(
                f"bus {other}",
                f"it is one wire with the bus {name}: it hears what is asked there "
                f"({len(both)} of {len(asked.sent)} frames); a plug or a full bus would take both "
                "away. Wire them apart, or give the profile one bus",
            )


def _heard(bus: FastCanBus) -> set[tuple[int, bytes]]:
    """Return the frames that wait on a bus."""
    heard: set[tuple[int, bytes]] = set()
    for _ in range(_BATCHES):
        frames = bus.drain(_BATCH)
        if not frames:
            break
        heard.update((can_id, bytes(data)) for can_id, data in frames)
    return heard
