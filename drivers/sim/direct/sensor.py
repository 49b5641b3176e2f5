"""A sensor of `--on sim` that no driver's simulation stands for: its readings go to the log."""

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from drivers.sim.direct.device import SimulatedDevice
from rig.hal import Clock, DeviceFault, device_column

_NO_LETTERS = re.compile("[^a-z0-9]+")
_SILENT_AFTER = 50e-3
"""Without a reading, s: as long as a node on a bus has for five cycles of 100 Hz."""


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

    Faults: ``silent`` (value: s), ``repair``.

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
        self._sampled_at = 0.0

    def connect(self) -> None:
        """Take the first readings."""
        self._sample()

    def arm(self) -> None:
        """Take readings from now on."""
        self._sample()

    def check(self, now: float) -> None:
        """Sample the next readings.

        Raises
        ------
        DeviceFault
            It has been silent for too long.
        """
        self._sample()
        silent = now - self._sampled_at
        if silent > _SILENT_AFTER:
            raise DeviceFault(
                self.name,
                "it sends no readings any more",
                value=f"{silent:.3f} s",
                bound=f"{_SILENT_AFTER:g} s",
            )

    def make_safe(self) -> None:
        """Do nothing: a sensor moves nothing."""

    def log_values(self) -> tuple[float, ...]:
        """Return the last readings."""
        return self._values

    def _sample(self) -> None:
        if not self._is_silent():
            self._values = tuple([item.value() for item in self._measured])
            self._sampled_at = self._clock.now()


def _field_name(name: str) -> str:
    return _NO_LETTERS.sub("_", name.lower()).strip("_")
