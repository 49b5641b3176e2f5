"""What a calibrated driver makes of regulators, for devices that have no driver (`--on sim`).

The device is wired as its maker says; the calibration is what the driver knows beyond that. On
a bus the two meet in counts; here they meet in straight lines between pressures.
"""

from drivers.cia401.channel_settings import AnalogueSignal
from drivers.cia401.settings import Cia401Settings
from drivers.sim.regulator_port import RegulatorPort
from drivers.sim.wiring import Installed

Line = tuple[float, float]
"""Gain and offset."""


class CorrectedRegulators(RegulatorPort):
    """Pressure ports of a plant, as calibrated settings have them.

    Parameters
    ----------
    plant : RegulatorPort
        The physics.
    setpoints, monitors : mapping of int to tuple of float
        By the plant's channel: from a wanted pressure to the one that the counts of it mean on
        the wire, and from a measured one to the one that its counts mean to the driver.
    """

    def __init__(
        self, plant: RegulatorPort, setpoints: dict[int, Line], monitors: dict[int, Line]
    ) -> None:
        self._plant = plant
        self._setpoints = setpoints
        self._monitors = monitors

    @classmethod
    def of(cls, of: Installed[Cia401Settings, RegulatorPort]) -> "CorrectedRegulators":
        """Return the ports of a module's channels."""
        setpoints: dict[int, Line] = {}
        monitors: dict[int, Line] = {}
        for channel, (name, new) in zip(of.channels, of.settings.channels.items(), strict=True):
            old = of.built.channels[name]
            setpoints[channel] = _between(new.setpoint, old.setpoint)
            monitors[channel] = _between(old.monitor, new.monitor)
        return cls(of.plant, setpoints, monitors)

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator the pressure that the driver's counts mean to it, Pa gauge."""
        gain, offset = self._setpoints[channel]
        self._plant.set_pressure_setpoint(channel, gain * pressure + offset)

    def pressure(self, channel: int) -> float:
        """Return the pressure that the monitor's counts mean to the driver, Pa gauge."""
        gain, offset = self._monitors[channel]
        return gain * self._plant.pressure(channel) + offset

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
        self._plant.set_supply(open)

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
        self._plant.set_lock(channel, locked)


def _between(one: AnalogueSignal, other: AnalogueSignal) -> Line:
    """Return the line from a pressure of one signal to the pressure of the other's same counts."""
    a, b = _line(one), _line(other)
    gain = b[0] / a[0]
    return gain, b[1] - gain * a[1]


def _line(signal: AnalogueSignal) -> Line:
    """Return pressure over counts."""
    gain = (signal.pressure[1] - signal.pressure[0]) / (signal.raw[1] - signal.raw[0])
    return gain, signal.pressure[0] - gain * signal.raw[0]
