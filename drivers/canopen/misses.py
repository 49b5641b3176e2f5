"""Samples that a bus's devices have not sent of late: one device is silent, or frames are lost."""

from collections import deque
from typing import Final

from drivers.canopen.answers import SyncTrain

_WINDOW: Final = 50
"""Cycles that are looked back at: no device is waited for as long."""
_SEVERAL: Final = 2
"""Fewer in so many cycles is what any bus loses now and then."""


class RecentMisses:
    """The samples that were missing in the last cycles, by device.

    Parameters
    ----------
    syncs : SyncTrain
        By which cycles are counted.
    """

    def __init__(self, syncs: SyncTrain) -> None:
        self._syncs = syncs
        self._cycles: dict[str, deque[int]] = {}

    def note(self, device: str) -> None:
        """Take note that a device's last sample is held in this cycle for want of a new one."""
        cycles = self._cycles.setdefault(device, deque(maxlen=_WINDOW))
        if not cycles or cycles[-1] != self._syncs.count:
            cycles.append(self._syncs.count)

    def of_others(self, device: str) -> str:
        """Say of which other devices samples are missing, too, as a part of a sentence.

        Parameters
        ----------
        device : str
            The one that is about to be blamed; empty: no other's are.
        """
        since = self._syncs.count - _WINDOW
        counts = {
            name: sum(cycle > since for cycle in cycles)
            for name, cycles in self._cycles.items()
            if name != device
        }
        several = [f"{count} of {name}" for name, count in counts.items() if count >= _SEVERAL]
        if not several:
            return ""
        return (
            f", and frames of others are lost on this bus as well: in the last {_WINDOW} cycles "
            f"{', '.join(several)}"
        )
