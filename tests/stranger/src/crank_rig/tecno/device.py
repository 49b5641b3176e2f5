"""The driver: set-points out and monitors in with every SYNC."""

from math import inf

from crank_rig.tecno.codec import MOST, decode_monitors, encode_setpoints
from crank_rig.tecno.settings import MONITORS, PROFILE, SETPOINTS, TecnoSettings
from drivers.can.cyclic import CyclicFrame
from drivers.canopen.bus import CanopenBus
from drivers.canopen.inputs import CyclicInputs
from drivers.canopen.node import CanopenNode, pdo_id
from rig.hal import DeviceFault, PressureRegulator, Reading, Vector

_SAFE = encode_setpoints((0.0, 0.0), supply=False)


class TecnoRegulators(PressureRegulator):
    """Two regulators on one node.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : TecnoSettings
        See there.
    bus : CanopenBus
        The bus that it hangs on.
    serial : int, optional
        The serial number that it must report.
    """

    pressure_range = (0.0, MOST)

    def __init__(
        self, name: str, settings: TecnoSettings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        self.name = name
        self.channels = settings.channels
        self._serial = serial
        self._node = CanopenNode(name, settings.node, bus)
        self._inputs = CyclicInputs(
            name, settings.node, bus, ((MONITORS,),), self._take, hold_after=2, fault_after=5
        )
        self._frame = CyclicFrame(pdo_id(1, settings.node), _SAFE)
        bus.add(self._frame)
        self._reading: Reading[Vector] = Reading((0.0, 0.0), -inf)
        self._faulty = False
        self._armed = False

    def connect(self) -> None:
        """Find the node, and compare its mapping: it is fixed."""
        self.make_safe()
        self._node.connect(profile=PROFILE, serial=self._serial)
        self._node.map_pdos(((SETPOINTS,),), ((MONITORS,),), remap=False)

    def arm(self) -> None:
        """Start the node and take a first reading; the supply opens with the first setpoint."""
        self._node.arm()
        self._frame.active = True
        self._inputs.take_first()
        self._armed = True

    def make_safe(self) -> None:
        """Vent both, and shut the supply, until it is armed again."""
        self._armed = False
        self._frame.data = _SAFE

    def close(self) -> None:
        """Expect nothing of the node any more."""
        self.make_safe()
        self._node.disarm()

    def check(self, now: float) -> None:
        """Raise if the node is silent, or reports a fault."""
        self._node.check(now)
        if not self._armed:
            return
        self._inputs.check(now)
        if self._faulty:
            raise DeviceFault(self.name, "a regulator reports a fault", object=str(MONITORS))

    def pressure(self) -> Reading[Vector]:
        """Return the monitored pressures, Pa gauge."""
        return self._reading

    def set_pressure(self, pressure: Vector) -> None:
        """Take setpoints for this cycle, Pa gauge; ignored unless armed."""
        if self._armed:
            first, second = pressure
            self._frame.data = encode_setpoints((first, second), supply=True)

    def safe_pressure(self) -> Vector:
        """Return what `make_safe` sets: nothing."""
        return (0.0, 0.0)

    def _take(self, values: tuple[int, ...], t: float) -> None:
        pressures, self._faulty = decode_monitors(values[0])
        self._reading = Reading(pressures, t)
