"""Sensors on one CANopen node: they sample at each SYNC, and move nothing."""

from typing import Protocol

from drivers.canopen.bus import CanopenBus
from drivers.canopen.frozen import FrozenInputs
from drivers.canopen.identified import IdentifiedDevice
from drivers.canopen.inputs import CyclicInputs, Take
from drivers.canopen.mapping import Layout
from drivers.canopen.node import CanopenNode


class SensorSettings(Protocol):
    """The settings of a sensor's driver, as far as all of them have the same.

    See `drivers.canopen.node_settings.NodeSettings`; `frozen_timeout` is that of `FrozenInputs`.
    """

    @property
    def node(self) -> int:
        """Its number on the bus."""

    @property
    def vendor(self) -> int | None:
        """What it must report, if that is said."""

    @property
    def product(self) -> int | None:
        """What it must report, if that is said."""

    @property
    def remap(self) -> bool:
        """Whether its mapping is written."""

    @property
    def hold_after(self) -> int:
        """Samples missed in a row that are counted as held."""

    @property
    def fault_after(self) -> int:
        """Samples missed in a row that are a fault."""

    @property
    def frozen_timeout(self) -> float | None:
        """For how long no count may change, s."""

    @property
    def layouts(self) -> tuple[Layout, ...]:
        """What it sends each cycle, PDO by PDO."""


class CyclicSensor(IdentifiedDevice):
    """The life of a sensor on one node, from `connect` to `close`.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : SensorSettings
        All of its driver's.
    bus : CanopenBus
        Where its node is.
    take : callable
        ``take(values, t)`` receives each sample in counts, and its time, s. Hot path.
    profile : int
        The device profile that it must report: the number of the CiA's.
    serial : int, optional
        The serial number that it must report.
    """

    def __init__(
        self,
        name: str,
        settings: SensorSettings,
        bus: CanopenBus,
        take: Take,
        *,
        profile: int,
        serial: int | None,
    ) -> None:
        self.name = name
        self._of, self._profile, self._serial = settings, profile, serial
        self._node = CanopenNode(name, settings.node, bus)
        self._inputs = CyclicInputs(
            name,
            settings.node,
            bus,
            settings.layouts,
            take,
            hold_after=settings.hold_after,
            fault_after=settings.fault_after,
        )
        self._frozen = FrozenInputs(name, settings.frozen_timeout)
        self._armed = False

    def connect(self) -> None:
        """Find, identify and configure the sensor, and compare what it says of itself.

        Raises
        ------
        ConnectionFailed
            It does not answer, is another device or set otherwise than the profile says, or did
            not take a setting.
        """
        self._armed = False
        its, node = self._of, self._node
        node.connect(
            profile=self._profile, vendor=its.vendor, product=its.product, serial=self._serial
        )
        self.compare()
        node.map_pdos((), its.layouts, remap=its.remap)

    def compare(self) -> None:
        """Raise `ConnectionFailed` if it is set otherwise than the profile says."""

    def arm(self) -> None:
        """Start the node and take a first reading.

        Raises
        ------
        ConnectionFailed
            It does not become OPERATIONAL, or sends no reading.
        """
        self._node.arm()
        self._frozen.restart()
        self._inputs.take_first()
        self._armed = True

    def make_safe(self) -> None:
        """Do nothing: a sensor moves nothing."""

    def close(self) -> None:
        """Expect nothing of the sensor any more. Idempotent."""
        self._armed = False
        self._node.disarm()

    def check(self, now: float) -> None:
        """Raise if the sensor is silent or frozen.

        Raises
        ------
        DeviceFault
            With for how long.
        """
        self._node.check(now)
        if self._armed:
            self._inputs.check(now)
            self._frozen.check()
