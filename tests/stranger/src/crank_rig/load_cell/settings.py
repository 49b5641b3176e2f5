"""What a profile says of a load cell, and what its frames mean."""

from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Gt, Interval, Unit

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.mapping import Entry
from rig.hal import Address

PROFILE: Final = 401
FORCE: Final = Entry(0x6401, 1, "i16")
"""The first analogue input of a CiA 401 module."""


@dataclass(frozen=True, slots=True)
class LoadCellSettings(CanopenDeviceSettings):
    """A load cell on the first analogue input of a CiA 401 module.

    Parameters
    ----------
    node : int
        Its number on the bus.
    capacity : float
        The force at full scale, 32767 counts, N.
    measures : str
        The plant's channel that a simulated one shows.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    capacity: Annotated[float, Unit("N"), Gt(0)]
    measures: str = "rod"

    @property
    def gain(self) -> float:
        """Force of one count, N."""
        return self.capacity / 32767.0

    def channel_names(self) -> tuple[str, ...]:
        """Return the plant's channel that it is mounted on."""
        return (self.measures,)

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the one node."""
        return (Address(device, self.node, PROFILE, serial=serial),)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return that the node sends the force with every SYNC."""
        quantities = {FORCE: Quantity("force", "N", self.gain)}
        return (DescribedNode(name, self.node, (), ((FORCE,),), True, quantities),)
