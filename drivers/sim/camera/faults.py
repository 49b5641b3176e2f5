"""What can be broken on a simulated camera."""

from math import inf
from typing import Final

from drivers.marker_camera.link import Failure

_LASTING: Final = ("covered", "frozen", "lost", "mirrored", "stalled", "swapped", "unplugged")
_LATE: Final = 0.2
"""Delay of late frames unless a fault says otherwise, s."""


UNPLUGGED = Failure("the camera stopped sending frames; it was unplugged or lost its power")
"""What an unplugged camera's link says last."""


class CameraFaults:
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
        self.name = name
        self.now = 0.0
        self.delay = 0.0
        """By how much frames are late, s."""
        self._until: dict[str, float] = {}

    @property
    def known(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return (*_LASTING, "late", "repair")

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault not in self.known:
            raise ValueError(f"{self.name}: no fault {fault!r}; known are {', '.join(self.known)}")
        if value is not None and not value > 0.0:
            raise ValueError(f"{self.name}: {fault} takes more than {value:g} s")
        if fault == "repair":
            self._until.clear()
            self.delay = 0.0
        elif fault == "late":
            self.delay = _LATE if value is None else value
        else:
            self._until[fault] = inf if value is None else self.now + value

    def has(self, fault: str) -> bool:
        """Return whether a lasting fault is there now."""
        return self._until.get(fault, -inf) > self.now
