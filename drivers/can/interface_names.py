"""What may stand for an interface in a file: a device or a name, and nothing that opens more.

A profile comes from somebody else. pyserial takes URLs, some of which write files or connect to
other machines, and adapters' libraries take paths of code: these only the user of this machine may
allow, in a file of their own.
"""

import ipaddress
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from rig.hal import ConfigurationError
from rig.hal.files import read_regular, users_folder

_NAME: Final = re.compile(r"[A-Za-z0-9_.][A-Za-z0-9_.:, -]{0,63}")
_LINK: Final = re.compile(r"[A-Za-z0-9_.-]{1,15}")  # IFNAMSIZ of linux/if.h
_DEVICE: Final = re.compile(r"/[A-Za-z0-9_.:+/-]{1,250}(?:@[0-9]{1,9})?")
_MOST: Final = 1 << 16  # bytes of the list of what is allowed


def _is_group(channel: str) -> bool:
    try:
        return ipaddress.ip_address(channel).is_multicast
    except ValueError:
        return False


_Test = Callable[[str], object]
_AN_ADAPTER: Final = (
    _NAME.fullmatch,
    "the name or number of an adapter, such as PCAN_USBBUS1",
)
_A_DEVICE: Final = (_DEVICE.fullmatch, "the path of a serial device, such as /dev/ttyACM0")

_CHANNELS: Final[Mapping[str, tuple[_Test, str]]] = {
    "socketcan": (_LINK.fullmatch, "the name of a network interface, such as can0"),
    "virtual": _AN_ADAPTER,
    "udp_multicast": (_is_group, "the address of a multicast group, such as 239.74.163.2"),
    **dict.fromkeys(("slcan", "serial", "robotell", "seeedstudio"), _A_DEVICE),
    **dict.fromkeys(
        ("canalystii", "cantact", "etas", "gs_usb", "iscan", "ixxat", "kvaser", "neousys", "neovi",
         "nican", "nixnet", "pcan", "systec", "usb2can", "vector"), _AN_ADAPTER,
    ),
}  # fmt: skip
"""What the channel of an interface is. Those that are missing connect to other machines."""


def interface_trouble(interface: str, channel: str, options: Mapping[str, object]) -> str | None:
    """Say why an interface is not opened; None: it may be.

    Parameters
    ----------
    interface, channel : str
        As for python-can.
    options : mapping
        More arguments for it.
    """
    test, what = _CHANNELS.get(interface, (None, ""))
    if test is None:
        trouble = f"{interface!r} not supported; there are {', '.join(sorted(_CHANNELS))}"
    elif not test(channel) or ".." in channel:
        trouble = f"the channel of {interface} is {what}, not {channel!r}"
    else:
        named = [key for key, value in options.items() if re.search(r"[/\\]", str(value))]
        if not named:
            return None
        trouble = f"the option {named[0]} of {interface} names a file or another machine"
    return None if f"{interface}:{channel}" in _allowed() else f"{trouble}. {_how_to_allow()}"


def is_serial(interface: str) -> bool:
    """Return whether an interface opens a serial line."""
    return _CHANNELS.get(interface) is _A_DEVICE


def _list_of_allowed() -> Path:
    return users_folder("XDG_CONFIG_HOME", ".config") / "rig" / "interfaces"


def _how_to_allow() -> str:
    return f"Other interfaces are allowed by a line INTERFACE:CHANNEL in {_list_of_allowed()}"


def _allowed() -> set[str]:
    try:
        return set(read_regular(_list_of_allowed(), _MOST).decode().split("\n"))
    except (ConfigurationError, UnicodeDecodeError):
        return set()
