"""What this computer has that a rig could be wired to, while no profile names any of it."""

import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from rig.doctor.look import Fitness, Look
from rig.doctor.wiring import look_at_device_file

_USUAL_BITRATE: Final = 1_000_000
"""Of the command that is shown, bit/s; a profile says its own."""
_CAN: Final = "280"
"""ARPHRD_CAN, linux/if_arp.h."""
_UP: Final = 0x1
"""IFF_UP, linux/if.h."""
_SERIAL: Final = ("ttyUSB*", "ttyACM*")
_CAMERAS: Final = ("video*",)


def look_at_ports(system: Path = Path("/sys"), devices: Path = Path("/dev")) -> Iterator[Look]:
    """Yield CAN interfaces, serial ports and cameras that are there; nothing is opened.

    What is missing is poor and no lack: which of them a rig needs, its profile says.

    Parameters
    ----------
    system, devices : Path
        Where the kernel shows its devices, and their files.
    """
    yield from _can_interfaces(system)
    yield from _files("serial ports", _SERIAL, devices)
    yield from _files("cameras", _CAMERAS, devices)


def _can_interfaces(system: Path) -> Iterator[Look]:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        yield Look(
            "SocketCAN", f"this kernel has none ({error.strerror})", Fitness.POOR,
            "sudo modprobe can_raw",
        )  # fmt: skip
        return
    names = sorted(
        path.parent.name
        for path in system.glob("class/net/*/type")
        if path.read_text().strip() == _CAN
    )
    if not names:
        yield Look(
            "SocketCAN", "the kernel has it, and there is no interface", Fitness.POOR,
            "plug the adapter in, or for a bus that is simulated: "
            "sudo ip link add dev vcan0 type vcan && sudo ip link set vcan0 up",
        )  # fmt: skip
    for name in names:
        yield _can_interface(name, int((system / f"class/net/{name}/flags").read_text(), 0))


def _can_interface(name: str, flags: int) -> Look:
    from drivers.can.bitrate import bitrate_of
    from drivers.can.socketcan import link_command

    what = f"CAN interface {name}"
    if not flags & _UP:
        return Look(what, "is down", Fitness.POOR, link_command(name, _USUAL_BITRATE))
    bitrate = bitrate_of(name)
    return Look(what, "up" if bitrate is None else f"up, {bitrate} bit/s", Fitness.OK)


def _files(what: str, patterns: tuple[str, ...], devices: Path) -> Iterator[Look]:
    found = sorted(path for pattern in patterns for path in devices.glob(pattern))
    if not found:
        yield Look(what, "none", Fitness.OK)
    for path in found:
        look = look_at_device_file(f"{what.removesuffix('s')} {path}", str(path))
        yield look if look.verdict is Fitness.OK else look._replace(verdict=Fitness.POOR)
