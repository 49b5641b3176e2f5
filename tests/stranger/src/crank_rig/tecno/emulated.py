"""The simulated bank: a node on an emulated bus, and a device on none.

The node reads the maker's code with its own eyes: it shares nothing with the driver's codec, so
that a mistake in one shows against the other.
"""

from crank_rig.tecno.settings import TecnoSettings
from drivers.sim.direct.regulators import SimulatedRegulators
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.object_dictionary import UNSIGNED32, Variable
from drivers.sim.regulator_port import RegulatorPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock


class EmulatedTecno(EmulatedNode):
    """Two regulators of the plant behind the maker's objects.

    Fault of its own, beside those of every node: ``regulator_fault``.
    """

    def __init__(self, of: Installed[TecnoSettings, RegulatorPort]) -> None:
        super().__init__(of.name, of.settings.node, device_type=0, serial=of.serial or 0)
        self._plant = of.plant
        self._channels = of.channels
        self._faulty = False
        add = self.dictionary.add
        self._setpoints = add(0x2100, 0, Variable(UNSIGNED32, 0, mapping="r"))
        self._monitors = add(0x2200, 0, Variable(UNSIGNED32, 0, "ro", mapping="t"))
        self.add_pdos(receive=((0x2100_0020,),), transmit=((0x2200_0020,),))
        self.add_fault("regulator_fault", lambda value: self._fail(True), lambda: self._fail(False))
        self.power_on()

    def apply_outputs(self, now: float) -> None:
        """Give the regulators what the object says."""
        self._drive(self._setpoints.integer)

    def leave_operational(self, now: float) -> None:
        """Vent both."""
        self._drive(0)

    def restore_process(self) -> None:
        """Power-on: vented."""
        self._drive(0)

    def sample_inputs(self, now: float) -> None:
        """Put both pressures into the object, in mbar."""
        word = 0x8000_0000 if self._faulty else 0
        for place, channel in enumerate(self._channels):
            millibar = round(self._plant.pressure(channel) / 100.0)
            word |= min(max(millibar, 0), 4095) << 12 * place
        self._monitors.value = word

    def _drive(self, word: int) -> None:
        self._plant.set_supply(word >= 0x8000_0000)
        for place, channel in enumerate(self._channels):
            self._plant.set_pressure_setpoint(channel, 100.0 * (word >> 12 * place & 0xFFF))

    def _fail(self, faulty: bool) -> None:
        self._faulty = faulty


def emulate(of: Installed[TecnoSettings, RegulatorPort]) -> tuple[EmulatedTecno, ...]:
    """Return the node of an emulated bus."""
    return (EmulatedTecno(of),)


def simulate(of: Installed[TecnoSettings, RegulatorPort], clock: Clock) -> SimulatedRegulators:
    """Return regulators straight on the plant, with the bank's range and resolution."""
    return SimulatedRegulators(
        of.name,
        of.settings.channels,
        of.plant,
        clock,
        pressure_range=(0.0, 409.5e3),
        resolution=100.0,
        deviation=100e3,
        deviation_time=1.0,
    )


TECNO = Wiring(emulate, simulate)
