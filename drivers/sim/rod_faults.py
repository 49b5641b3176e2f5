"""Rod encoders that measure wrongly, whether they stand on a bus or on the plant itself."""

import zlib

import numpy as np

_DRIFT = 2e-3
_SCALE = 1.2
_NOISE = 50e-6

ROD_FAULTS = ("drift", "scale", "mirrored", "noisy")
"""What `RodFaults.inject` understands."""


class RodFaults:
    """The errors of an encoder's measurement: none at first.

    ``drift`` (value: m/s, default 2 mm/s)
        Its zero wanders.
    ``scale`` (value: factor, default 1.2)
        From where the rod is, it counts so many times the way.
    ``mirrored``
        From where the rod is, it counts backwards.
    ``noisy`` (value: m, default 50 µm)
        Each sample is off by normal noise of this standard deviation.

    Parameters
    ----------
    name : str
        The encoder's: each has a noise of its own.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self.clear()

    def clear(self) -> None:
        """Measure rightly again."""
        self._gain, self._offset = 1.0, 0.0
        self._rate = self._since = 0.0
        self._noise = 0.0
        self._is_wrong = False
        self._random = np.random.default_rng(zlib.crc32(self._name.encode()))

    def inject(self, fault: str, value: float | None, extension: float, now: float) -> None:
        """Go wrong now.

        Parameters
        ----------
        fault : str
            One of `ROD_FAULTS`.
        value : float or None
            As the class says.
        extension : float
            Where the rod is, m.
        now : float
            s.
        """
        if fault == "noisy":
            self._noise = _NOISE if value is None else value
            return
        shown = self._shown(extension, now)
        self._is_wrong = True
        self._offset += self._rate * (now - self._since)
        self._since = now
        if fault == "drift":
            self._rate = _DRIFT if value is None else value
        else:
            self._gain *= -1.0 if fault == "mirrored" else _SCALE if value is None else value
            self._offset = shown - self._gain * extension

    def measured(self, extension: float, now: float) -> float:
        """Return what the encoder makes of a rod's extension, m."""
        shown = self._shown(extension, now) if self._is_wrong else extension
        return shown + self._noise * self._random.standard_normal() if self._noise else shown

    def _shown(self, extension: float, now: float) -> float:
        return self._gain * extension + self._offset + self._rate * (now - self._since)
