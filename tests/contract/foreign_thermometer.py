"""A driver of another package, without a simulation: a thermometer that no mechanism uses."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.inputs import CyclicInputs
from drivers.canopen.mapping import Entry
from drivers.canopen.node import CanopenNode
from rig.hal import Address, Device, device_column
from rig.hal.parts import DriverParts

TEMPERATURE = Entry(0x6401, 1, "i16")
STEP, ZERO = 0.1, 273.15


@dataclass(frozen=True, slots=True)
class ThermometerSettings(CanopenDeviceSettings):
    node: Annotated[int, Interval(ge=1, le=127)]
    silent: bool = False
    eds: str | None = None

    def addresses(self, device, serial):
        return (Address(device, self.node, 404, vendor=0x2A, serial=serial),)

    def describe_nodes(self, name):
        if self.silent:
            return ()
        quantities = {TEMPERATURE: Quantity("temperature", "K", STEP, ZERO)}
        return (DescribedNode(name, self.node, (), ((TEMPERATURE,),), True, quantities),)


class Thermometer(Device):
    def __init__(self, name, settings, bus, *, serial=None):
        self.name = name
        self._serial = serial
        self.log_columns = (device_column(name, "temperature", "K", "of the oil"),)
        self._node = CanopenNode(name, settings.node, bus)
        self._inputs = CyclicInputs(
            name, settings.node, bus, ((TEMPERATURE,),), self._take, hold_after=2, fault_after=5
        )
        self._bus = bus
        self._kelvin = 0.0

    def _take(self, counts, now):
        self._kelvin = STEP * counts[0] + ZERO

    def connect(self):
        self._node.connect(profile=404, vendor=0x2A, serial=self._serial)
        self._node.map_pdos((), ((TEMPERATURE,),), remap=True)

    def arm(self):
        self._node.arm()
        self._inputs.take_first()

    def check(self, now):
        self._node.check(now)
        self._inputs.check(now)

    def log_values(self):
        return (self._kelvin,)

    def make_safe(self):
        pass

    def close(self):
        self._node.disarm()


PARTS = DriverParts(
    settings="foreign_thermometer:ThermometerSettings", device="foreign_thermometer:Thermometer"
)
