"""The driver: one reading with every SYNC, in the log.

To have a mechanism use it, inherit one of the capabilities in `rig.hal.devices` as well.
"""

from math import inf

from drivers.canopen.bus import CanopenBus
from drivers.canopen.inputs import CyclicInputs
from drivers.canopen.node import CanopenNode
from rig.hal import Device, Reading
from rig.hal.devices import device_column
from rig.scaffolding.templates.driver.settings import INPUT, PROFILE, MySensorSettings


class MySensor(Device):
    """A sensor that is logged.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : MySensorSettings
        See there.
    bus : CanopenBus
        The bus that it hangs on.
    serial : int, optional
        The serial number that it must report.
    """

    def __init__(
        self, name: str, settings: MySensorSettings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        self.name = name
        column = device_column(name, "value", settings.unit, "what the sensor measures")
        self.log_columns = (column,)
        self._gain, self._offset = settings.gain, settings.offset
        self._serial = serial
        self._node = CanopenNode(name, settings.node, bus)
        self._inputs = CyclicInputs(
            name, settings.node, bus, ((INPUT,),), self._take, hold_after=2, fault_after=5
        )
        self._value: Reading[float] = Reading(0.0, -inf)
        self._armed = False

    def connect(self) -> None:
        """Find the module, and have it send its first input with every SYNC."""
        self._node.connect(profile=PROFILE, serial=self._serial)
        self._node.map_pdos((), ((INPUT,),), remap=True)

    def arm(self) -> None:
        """Start the node and take a first reading."""
        self._node.arm()
        self._inputs.take_first()
        self._armed = True

    def check(self, now: float) -> None:
        """Raise if the module is silent."""
        self._node.check(now)
        if self._armed:
            self._inputs.check(now)

    def make_safe(self) -> None:
        """Do nothing: a sensor moves nothing."""

    def close(self) -> None:
        """Expect nothing of the module any more."""
        self._armed = False
        self._node.disarm()

    def log_values(self) -> tuple[float, ...]:
        """Return the value of this cycle."""
        return (self._value.value,)

    def _take(self, values: tuple[int, ...], t: float) -> None:
        self._value = Reading(self._gain * values[0] + self._offset, t)
