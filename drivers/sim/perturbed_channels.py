"""Regulators and encoders of a simulated rig that err, as a seed draws it."""

from drivers.sim.direct.encoders import RodPort
from drivers.sim.perturbation import Draws
from drivers.sim.regulator_port import RegulatorPort


class PerturbedRegulators(RegulatorPort):
    """Regulators whose setpoints and monitors err; their valves do not.

    Parameters
    ----------
    plant : RegulatorPort
        The physics.
    draws : Draws
        By how much each channel errs.
    """

    def __init__(self, plant: RegulatorPort, draws: Draws) -> None:
        of = draws.channels
        self._plant = plant
        self._setpoint = tuple(zip(of["setpoint_gain"], of["setpoint_offset"], strict=True))
        self._monitor = tuple(zip(of["monitor_gain"], of["monitor_offset"], strict=True))

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator what it makes of a setpoint, Pa gauge."""
        gain, offset = self._setpoint[channel]
        self._plant.set_pressure_setpoint(channel, (1.0 + gain) * pressure + offset)

    def pressure(self, channel: int) -> float:
        """Return what a monitor shows, Pa gauge."""
        gain, offset = self._monitor[channel]
        return (1.0 + gain) * float(self._plant.pressure(channel)) + offset

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
        self._plant.set_supply(open)

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
        self._plant.set_lock(channel, locked)


class PerturbedRods(RodPort):
    """Rods whose encoders err.

    Parameters
    ----------
    plant : RodPort
        The physics.
    draws : Draws
        By how much each channel errs.
    """

    def __init__(self, plant: RodPort, draws: Draws) -> None:
        of = draws.channels
        self._plant = plant
        self._encoder = tuple(zip(of["encoder_scale"], of["encoder_offset"], strict=True))

    def position(self, channel: int) -> float:
        """Return what an encoder makes of a rod's extension, m."""
        scale, offset = self._encoder[channel]
        return (1.0 + scale) * float(self._plant.position(channel)) + offset

    def speed(self, channel: int) -> float:
        """Return what an encoder makes of a rod's speed, m/s."""
        return (1.0 + self._encoder[channel][0]) * float(self._plant.speed(channel))
