"""Whether an analogue module has got the setpoints that it was sent."""

from collections.abc import Mapping, Sequence
from typing import Final

from drivers.canopen.bus import CanopenBus
from drivers.cia401.channel_settings import Channel
from drivers.servos.setpoint_echo import SetpointEcho
from rig.hal import DeviceFault

_SLACK: Final = 0.5  # counts


class OutputEchoes:
    """The outputs of a module as it sends them back, none where it does not.

    Parameters
    ----------
    device : str
        Its name in the profile.
    node : int
        Its number.
    channels : mapping of str to Channel
        What it echoes.
    bus : CanopenBus
        That counts what is lost.
    """

    def __init__(
        self, device: str, node: int, channels: Mapping[str, Channel], bus: CanopenBus
    ) -> None:
        self._device = device
        self._node = node
        self._channels = dict(channels)
        period = bus.period or 0.0
        self._echoes = tuple(SetpointEcho(period, _SLACK, exact=True) for _ in channels)
        for echo in self._echoes:
            bus.lost_setpoints.append(echo.count_lost)

    def reset(self) -> None:
        """Forget what was sent."""
        for echo in self._echoes:
            echo.reset()

    def send(self, counts: Sequence[float]) -> None:
        """Take the setpoints of this cycle, counts."""
        for k, echo in enumerate(self._echoes):
            echo.send(counts[k])

    def hear(self, counts: Sequence[float]) -> None:
        """Take what a sample says that the outputs are, counts."""
        for k, echo in enumerate(self._echoes):
            echo.hear(counts[k])

    @property
    def are_missing(self) -> bool:
        """Whether setpoints do not arrive in time."""
        return any(echo.missing is not None for echo in self._echoes)

    def check(self) -> None:
        """Raise `DeviceFault` if setpoints do not arrive in time."""
        for echo, (name, channel) in zip(self._echoes, self._channels.items(), strict=True):
            if echo.missing is not None:
                raise DeviceFault(
                    self._device,
                    f"setpoints of {name} do not arrive, or come late",
                    node=self._node,
                    object=str(channel.setpoint.entry),
                )
