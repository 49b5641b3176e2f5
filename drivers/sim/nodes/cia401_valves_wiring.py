"""From the settings of a CiA 401 module with proportional valves to its simulated forms."""

from drivers.cia401.valve_settings import Cia401ValvesSettings
from drivers.sim.direct.valves import SimulatedValves
from drivers.sim.nodes.cia401 import EmulatedCia401
from drivers.sim.nodes.cia401_wiring import emulated_module, monitor_resolution
from drivers.sim.valve_port import ValvePort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock


class SpoolsOnOutputs:
    """The spools that a module's analogue outputs move: to it, a signal stands for a number.

    Parameters
    ----------
    plant : ValvePort
        The valves.
    """

    def __init__(self, plant: ValvePort) -> None:
        self._plant = plant

    def set_pressure_setpoint(self, channel: int, value: float) -> None:
        """Give a spool the opening that its signal stands for."""
        self._plant.set_opening(channel, value)

    def pressure(self, channel: int) -> float:
        """Return what a chamber's sensor shows, Pa gauge."""
        return self._plant.pressure(channel)

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
        self._plant.set_supply(open)

    def set_lock(self, channel: int, locked: bool) -> None:
        """Refuse: a spool in the middle shuts a chamber, and nothing else does.

        Raises
        ------
        AssertionError
        """
        raise AssertionError(f"no valve locks channel {channel}")


def emulate_valves(of: Installed[Cia401ValvesSettings, ValvePort]) -> tuple[EmulatedCia401]:
    """Return an emulated CiA 401 module, wired as the driver's settings say."""
    locks = (None,) * len(of.channels)
    return (emulated_module(of, of.built, SpoolsOnOutputs(of.plant), locks),)


def simulate_valves(
    of: Installed[Cia401ValvesSettings, ValvePort], clock: Clock
) -> SimulatedValves:
    """Return simulated valves with the ranges and resolution of the wired ones."""
    settings = of.settings
    of.require_plant_order()
    return SimulatedValves(
        of.name,
        tuple(settings.channels),
        of.plant,
        clock,
        opening_range=settings.opening_range,
        sensor_range=settings.sensor_range,
        resolution=monitor_resolution(settings),
    )


WIRING = Wiring(emulate_valves, simulate_valves)
