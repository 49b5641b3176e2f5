"""What can be broken on a simulated camera."""

from functools import partial
from math import inf
from typing import Final

from drivers.sim.breakable import Breakable

_LASTING: Final = ("covered", "frozen", "lost", "mirrored", "stalled", "swapped", "unplugged")
_LATE: Final = 0.2
"""Delay of late frames unless a fault says otherwise, s."""


class CameraFaults(Breakable):
    """The faults of one camera, by name.

    ``covered``, ``frozen`` (one image again and again), ``lost`` (the marker is out of sight),
    ``mirrored``, ``stalled`` (no frames), ``swapped`` (another marker is mounted) and
    ``unplugged`` take how long they last, s, and last for good without a value; ``late`` takes
    the delay of the frames, s; ``repair`` ends them all.

    Parameters
    ----------
    name : str
        The camera's name in the profile.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name
        self.now = 0.0
        """The time that the camera was last told, s."""
        self.delay = 0.0
        """By how much frames are late, s."""
        self._until: dict[str, float] = {}
        for fault in _LASTING:
            self.add_fault(fault, partial(self._begin, fault))
        self.add_fault("late", self._be_late)

    def has(self, fault: str) -> bool:
        """Return whether a lasting fault is there now."""
        return self._until.get(fault, -inf) > self.now

    def repair(self) -> None:
        """End all faults that last."""
        self._until.clear()
        self.delay = 0.0

    def _begin(self, fault: str, value: float | None) -> None:
        self._until[fault] = self.now + self._seconds(fault, value, inf)

    def _be_late(self, value: float | None) -> None:
        self.delay = self._seconds("late", value, _LATE)

    def _seconds(self, fault: str, value: float | None, usual: float) -> float:
        if value is not None and not value > 0.0:
            raise ValueError(f"{self.name}: {fault} takes more than {value:g} s")
        return usual if value is None else value
