"""What a profile says of a regulator bank, and what its frames mean."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Interval

from crank_rig.tecno.codec import decode_monitors
from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.mapping import Entry
from rig.hal import Address

PROFILE: Final = 0
"""In 0x1000: the maker follows no profile of CiA."""
SETPOINTS: Final = Entry(0x2100, 0, "u32")
MONITORS: Final = Entry(0x2200, 0, "u32")


@dataclass(frozen=True, slots=True)
class TecnoSettings(CanopenDeviceSettings):
    """Two regulators on one node; its mapping is fixed.

    Parameters
    ----------
    node : int
        Its number on the bus.
    channels : tuple of str
        What the two regulators fill.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    channels: tuple[str, str]

    def channel_names(self) -> tuple[str, ...]:
        """Return the plant's channels that the regulators fill."""
        return self.channels

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the one node."""
        return (Address(device, self.node, PROFILE, serial=serial),)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what the node exchanges, in words: two numbers share an object."""

        def words(flag: str) -> Callable[[int], str]:
            def pressures(word: int) -> str:
                values, is_set = decode_monitors(word)
                each = zip(self.channels, values, strict=True)
                text = ", ".join(f"{channel} {1e-3 * value:.1f} kPa" for channel, value in each)
                return f"{text}, {flag}" if is_set else text

            return pressures

        return (
            DescribedNode(
                name,
                self.node,
                ((SETPOINTS,),),
                ((MONITORS,),),
                False,
                {
                    SETPOINTS: Quantity("setpoints", words=words("supply open")),
                    MONITORS: Quantity("pressures", words=words("fault")),
                },
            ),
        )
