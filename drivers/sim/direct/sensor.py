"""A sensor of `--on sim` that no driver's simulation stands for: its readings go to the log."""

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from drivers.sim.direct.regulators import SimulatedDevice
from rig.hal import Clock, device_column

_NO_LETTERS = re.compile("[^a-z0-9]+")


class Measured(NamedTuple):
    """One quantity of a sensor.

    Attributes
    ----------
    name, unit : str
        What it is, and its unit of SI.
    value : callable
        Returns what stands there, SI.
    """

    name: str
    unit: str
    value: Callable[[], float]


class SimulatedSensor(SimulatedDevice):
    """A sensor that is read once a cycle.

    Faults: ``silent`` (value: s), in which the last readings stay, ``repair``.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    measured : sequence of Measured
        What it measures.
    clock : Clock
        The rig's.
    """

    def __init__(self, name: str, measured: Sequence[Measured], clock: Clock) -> None:
        super().__init__(name, clock)
        self.log_columns = tuple(
            device_column(
                name, _field_name(item.name), item.unit, f"{item.name.strip()}, simulated"
            )
            for item in measured
        )
        self._measured = tuple(measured)
        self._values = (0.0,) * len(self._measured)

    def connect(self) -> None:
        """Take the first readings."""
        self._sample()

    def arm(self) -> None:
        """Take readings from now on."""
        self._sample()

    def check(self, now: float) -> None:
        """Sample the next readings; a sensor that nobody waits for has no faults to report."""
        self._sample()

    def make_safe(self) -> None:
        """Do nothing: a sensor moves nothing."""

    def log_values(self) -> tuple[float, ...]:
        """Return the last readings."""
        return self._values

    def _sample(self) -> None:
        if not self._is_silent():
            self._values = tuple([item.value() for item in self._measured])


def _field_name(name: str) -> str:
    return _NO_LETTERS.sub("_", name.lower()).strip("_")
