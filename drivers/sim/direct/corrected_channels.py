"""What a calibrated driver makes of a device, for devices that have no driver (`--on sim`).

The device is wired as its maker says; the calibration is what the driver knows beyond that. On
a bus the two meet in counts; here they meet in straight lines between pressures or lengths.
"""

from typing import Any

from drivers.cia401.channels import AnalogueSignal
from drivers.cia401.settings import Cia401Settings
from drivers.cia406.settings import Cia406Settings

Line = tuple[float, float]
"""Gain and offset."""


class CorrectedRegulators:
    """Pressure ports of a plant, as calibrated settings have them.

    Parameters
    ----------
    plant : object
        The physics.
    setpoints, monitors : mapping of int to tuple of float
        By the plant's channel: from a wanted pressure to the one that the counts of it mean on
        the wire, and from a measured one to the one that its counts mean to the driver.
    """

    def __init__(self, plant: Any, setpoints: dict[int, Line], monitors: dict[int, Line]) -> None:
        self._plant = plant
        self._setpoints = setpoints
        self._monitors = monitors

    @classmethod
    def of(
        cls,
        nominal: Cia401Settings,
        settings: Cia401Settings,
        plant: Any,
        channels: tuple[int, ...],
    ) -> "CorrectedRegulators":
        """Return the ports of a module's channels."""
        names = list(settings.channels)
        pairs = [(nominal.channels[name], settings.channels[name]) for name in names]
        return cls(
            plant,
            {
                k: _between(new.setpoint, old.setpoint)
                for k, (old, new) in zip(channels, pairs, strict=True)
            },
            {
                k: _between(old.monitor, new.monitor)
                for k, (old, new) in zip(channels, pairs, strict=True)
            },
        )

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator the pressure that the driver's counts mean to it, Pa gauge."""
        gain, offset = self._setpoints[channel]
        self._plant.set_pressure_setpoint(channel, gain * pressure + offset)

    def pressure(self, channel: int) -> float:
        """Return the pressure that the monitor's counts mean to the driver, Pa gauge."""
        gain, offset = self._monitors[channel]
        return gain * float(self._plant.pressure(channel)) + offset


class CorrectedRods:
    """The rod of a plant, as calibrated settings have it.

    Parameters
    ----------
    plant : object
        The physics.
    scale, offset : float
        Of what the driver reads over what it would read uncalibrated, 1 and m.
    """

    def __init__(self, plant: Any, scale: float, offset: float) -> None:
        self._plant = plant
        self._scale = scale
        self._offset = offset

    @classmethod
    def of(
        cls,
        nominal: Cia406Settings,
        settings: Cia406Settings,
        plant: Any,
        channels: tuple[int, ...],
    ) -> "CorrectedRods":
        """Return the port of an encoder."""
        sign = -1.0 if nominal.reversed != settings.reversed else 1.0
        # The emulated device counts from the nominal offset on, see `drivers.sim.wiring`.
        scale = sign * settings.scale / nominal.scale
        return cls(plant, scale, settings.offset - scale * nominal.offset)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def position(self, channel: int) -> float:
        """Return the extension that the driver reads, m."""
        return self._scale * float(self._plant.position(channel)) + self._offset

    def speed(self, channel: int) -> float:
        """Return the speed that the driver reads, m/s."""
        return self._scale * float(self._plant.speed(channel))


def _between(one: AnalogueSignal, other: AnalogueSignal) -> Line:
    """Return the line from a pressure of one signal to the pressure of the other's same counts."""
    a, b = _line(one), _line(other)
    gain = b[0] / a[0]
    return gain, b[1] - gain * a[1]


def _line(signal: AnalogueSignal) -> Line:
    """Return pressure over counts."""
    gain = (signal.pressure[1] - signal.pressure[0]) / (signal.raw[1] - signal.raw[0])
    return gain, signal.pressure[0] - gain * signal.raw[0]
