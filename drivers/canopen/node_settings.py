"""What the settings of every driver of ours say of its CANopen nodes."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Interval

from drivers.canopen.device_settings import CanopenDeviceSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeSettings(CanopenDeviceSettings):
    """The identity of a device's nodes, and how they are mapped and missed.

    Parameters
    ----------
    vendor, product : int, optional
        What the device (every node of it) must report in 0x1018.
    eds : str, optional
        The device's own EDS file, relative to this one: types are taken from it, and what it
        says the device cannot do is refused.
    remap : bool
        Write the PDO mapping; False for devices whose mapping is fixed, which is then
        compared.
    hold_after, fault_after : int
        Readings missed in a row that are counted as held, and that are a fault.
    """

    vendor: Annotated[int, Interval(ge=0, le=0xFFFF_FFFF)] | None = None
    product: Annotated[int, Interval(ge=0, le=0xFFFF_FFFF)] | None = None
    eds: str | None = None
    remap: bool = True
    hold_after: Annotated[int, Ge(1)] = 2
    fault_after: Annotated[int, Interval(ge=1, le=100)] = 5

    def __post_init__(self) -> None:
        if self.fault_after < self.hold_after:
            raise ValueError(
                f"fault_after ({self.fault_after}) is below hold_after ({self.hold_after})."
            )
