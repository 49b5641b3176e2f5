"""Regulators of a plant as something sees them whose pressures lie on other straight lines."""

from collections.abc import Mapping

from drivers.cia401.channel_settings import PressureSignal
from drivers.cia401.settings import Cia401Settings
from drivers.sim.perturbation import Draws, Line
from drivers.sim.regulator_port import RegulatorPort
from drivers.sim.wiring import Installed


class RegulatorLines(RegulatorPort):
    """Regulators whose setpoints and monitors lie on straight lines; their valves do not.

    Parameters
    ----------
    plant : RegulatorPort
        The physics.
    setpoints, monitors : mapping of int to tuple of float
        Gain and offset by the plant's channel, 1 and Pa: from a wanted pressure to the one that
        the regulator is given, and from a measured one to the one that is seen.
    """

    def __init__(
        self, plant: RegulatorPort, setpoints: Mapping[int, Line], monitors: Mapping[int, Line]
    ) -> None:
        self._plant = plant
        self._setpoints = setpoints
        self._monitors = monitors

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator the pressure that a wanted one is on its line, Pa gauge."""
        gain, offset = self._setpoints[channel]
        self._plant.set_pressure_setpoint(channel, gain * pressure + offset)

    def pressure(self, channel: int) -> float:
        """Return the pressure that is seen, Pa gauge."""
        gain, offset = self._monitors[channel]
        return gain * float(self._plant.pressure(channel)) + offset

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
        self._plant.set_supply(open)

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
        self._plant.set_lock(channel, locked)


def correct_regulators(of: Installed[Cia401Settings, RegulatorPort]) -> RegulatorLines:
    """Return the regulators as calibrated settings have them; see `drivers.sim.wiring.Wiring`."""
    setpoints: dict[int, Line] = {}
    monitors: dict[int, Line] = {}
    for channel, (name, new) in zip(of.channels, of.settings.channels.items(), strict=True):
        old = of.built.channels[name]
        setpoints[channel] = _between(new.setpoint, old.setpoint)
        monitors[channel] = _between(old.monitor, new.monitor)
    return RegulatorLines(of.plant, setpoints, monitors)


def perturb_regulators(plant: RegulatorPort, draws: Draws) -> RegulatorLines:
    """Return regulators that err in setpoint and monitor, as a seed draws it."""
    setpoints = draws.lines("setpoint_gain", "setpoint_offset")
    return RegulatorLines(plant, setpoints, draws.lines("monitor_gain", "monitor_offset"))


def _between(one: PressureSignal, other: PressureSignal) -> Line:
    """Return the line from a pressure of one signal to the pressure of the other's same counts."""
    a, b = _line(one), _line(other)
    gain = b[0] / a[0]
    return gain, b[1] - gain * a[1]


def _line(signal: PressureSignal) -> Line:
    """Return pressure over counts."""
    gain = (signal.pressure[1] - signal.pressure[0]) / (signal.raw[1] - signal.raw[0])
    return gain, signal.pressure[0] - gain * signal.raw[0]
