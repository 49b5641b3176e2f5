"""The one choke point between what a controller wants and what a device is sent."""

import math

from rig.hal import LimitExceeded, Vector


class VectorLimiter:
    """Keeps a command vector inside its range and below its rate.

    It saturates, counts and returns what was applied; it does not raise, except for a number
    that is not finite, because no nearest permitted value exists for one.

    Parameters
    ----------
    name : str
        What is commanded, for messages.
    lower, upper : float
        Permitted range, SI.
    rate : float
        Greatest change per second, SI/s.
    period : float
        The loop's period, s.
    unit : str
        SI unit.
    """

    def __init__(
        self, name: str, lower: float, upper: float, rate: float, period: float, unit: str
    ) -> None:
        self.name = name
        self.lower = lower
        self.upper = upper
        self.unit = unit
        self._step = rate * period
        self._last: Vector | None = None
        self.range_hits = 0
        self.rate_hits = 0

    def reset(self, applied: Vector) -> None:
        """Start from what the devices have now, so that the first step is limited too."""
        self._last = tuple(min(max(value, self.lower), self.upper) for value in applied)

    def limit(self, command: Vector) -> Vector:
        """Return the nearest permitted command.

        Raises
        ------
        LimitExceeded
            An element is not finite.
        ValueError
            It has another length than the last one.
        """
        lower, upper, most = self.lower, self.upper, self._step
        last = self._last if self._last is not None else command
        if len(command) != len(last):
            raise ValueError(f"{self.name}: {len(command)} commands after {len(last)}")
        applied = []
        for k, value in enumerate(command):  # a zip() that is strict takes twice as long
            inside = value if lower <= value <= upper else self._saturate(value)
            before = last[k]
            step = inside - before
            if not -most <= step <= most:
                inside = before + math.copysign(most, step)
                self.rate_hits += 1
            applied.append(inside)
        self._last = tuple(applied)
        return self._last

    def _saturate(self, value: float) -> float:
        """Return the bound that a value is beyond, and count it."""
        if not math.isfinite(value):
            raise LimitExceeded(f"commanded {self.name}", value, self.lower, self.upper, self.unit)
        self.range_hits += 1
        return min(max(value, self.lower), self.upper)
