"""Open any CAN interface: SocketCAN directly, everything else by python-can."""

import contextlib
import logging
from typing import Any, Protocol, cast

from drivers.can.fast_path import AdaptedBus
from drivers.can.interface_names import interface_trouble, is_serial
from drivers.can.multicast import FIRST_PORT, MulticastBus
from drivers.can.socketcan import open_socketcan
from drivers.terminal import check_terminal
from rig.hal import CanBus, ConnectionFailed, FastCanBus

_ADVICE = {
    "Permission denied": "sudo usermod -aG dialout $USER, then log in again",
    "msgpack": "pip install 'python-can[multicast]'",
    "No such file": "look for it with: ls /dev/serial/by-id",
    "insufficient permissions": "the kernel may have a driver for it, which needs none: "
    "ip -brief link show type can",
    "No such device": "give this host a way for multicast: "
    "sudo ip link set lo up && sudo ip route add 224.0.0.0/4 dev lo",
}
"""What to type next, by words of an error."""

# Its complaints reach the user as exceptions.
logging.getLogger("can").addHandler(logging.NullHandler())


class InterfaceSettings(Protocol):
    """The settings of a bus that opening its interface needs."""

    @property
    def interface(self) -> str:
        """The python-can interface."""

    @property
    def channel(self) -> str:
        """What the interface calls the bus."""

    @property
    def bitrate(self) -> int:
        """Of the bus, bit/s."""

    @property
    def options(self) -> dict[str, str | int | float | bool]:
        """More arguments for python-can."""


def open_bus(settings: InterfaceSettings) -> FastCanBus:
    """Open the interface that a profile names.

    Configuration files and environment variables of python-can are not read: the profile
    alone says what is used.

    Raises
    ------
    ConnectionFailed
        The interface is unknown, not there, down, or refuses its options.
    """
    trouble = interface_trouble(settings.interface, settings.channel, settings.options)
    if trouble is not None:
        raise ConnectionFailed(settings.channel, trouble)
    if settings.interface == "socketcan" and not settings.options:
        return open_socketcan(settings.channel, settings.bitrate)
    try:
        if settings.interface == "udp_multicast":
            return MulticastBus(settings.channel, int(settings.options.get("port", FIRST_PORT)))
        import can

        if is_serial(settings.interface):
            check_terminal(settings.channel)
        bus = can.Bus(
            channel=settings.channel,
            interface=settings.interface,
            ignore_config=True,
            bitrate=settings.bitrate,
            **cast("dict[str, Any]", settings.options),
        )
    except Exception as error:  # each interface has errors of its own
        raise ConnectionFailed(
            settings.channel,
            f"cannot open interface {settings.interface!r}: "
            f"{error or type(error).__name__}{_advise(settings.interface, str(error))}",
        ) from error
    # A Message's attributes are a little narrower than the seam's.
    return AdaptedBus(cast("CanBus", bus))


def close_bus(bus: FastCanBus) -> None:
    """Release an interface.

    One that is gone already, an adapter that was pulled say, may complain; there is nothing left to
    be done about it.
    """
    with contextlib.suppress(Exception):
        bus.shutdown()


def _advise(interface: str, text: str) -> str:
    """Return what to do about an error, behind a semicolon."""
    advice = next((advice for words, advice in _ADVICE.items() if words in text), "")
    if not advice and "No module named" in text:
        advice = f"pip install 'python-can[{interface.replace('_', '-')}]'"
    return f"; {advice}" if advice else ""
