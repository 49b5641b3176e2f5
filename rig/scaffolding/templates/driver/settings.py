"""What a profile says of the sensor, and what its frames mean."""

from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Gt, Interval

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.mapping import Entry
from rig.hal import Address

PROFILE: Final = 401
INPUT: Final = Entry(0x6401, 1, "i16")
"""The first analogue input."""


@dataclass(frozen=True, slots=True)
class MySensorSettings(CanopenDeviceSettings):
    """A sensor on an analogue input.

    Parameters
    ----------
    node : int
        Its number on the bus.
    full_scale : float
        By how much 32767 counts are more than 0 counts, in `unit`.
    offset : float
        What 0 counts are, in `unit`: of a sensor of 4 … 20 mA a quarter of its range below 0.
    unit : str
        Of what the sensor measures, as log, figures and exported files say it.
    measures : str
        The plant's channel that a simulated one shows, as its `channel_value` has it: of the
        cylinders the tension of the wire, N; 0 of a plant without `channel_value`. A channel that
        the plant has not is refused: for what no plant knows, name a simulation of your own in
        parts.py (`DriverParts.simulation`).
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    full_scale: Annotated[float, Gt(0)]
    unit: str
    offset: float = 0.0
    measures: str = "agonist"

    @property
    def gain(self) -> float:
        """What one count is."""
        return self.full_scale / 32767.0

    def channel_names(self) -> tuple[str, ...]:
        """Return the plant's channel that it is mounted on."""
        return (self.measures,)

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the one node."""
        return (Address(device, self.node, PROFILE, serial=serial),)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return that the node sends its input with every SYNC."""
        quantities = {INPUT: Quantity("value", self.unit, self.gain, self.offset)}
        return (DescribedNode(name, self.node, (), ((INPUT,),), True, quantities),)
