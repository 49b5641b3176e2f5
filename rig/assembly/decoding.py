"""Decoders of a profile's CAN buses: frames in the profile's names and in SI."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from rig.assembly.buses import is_can
from rig.config import Profile


class Decoder(Protocol):
    """What reads the frames of one bus, in their order."""

    def decode(self, can_id: int, data: bytes) -> Any:
        """Return a `drivers.can.decoded.Decoded`."""
        ...


def make_decoders(profile: Profile) -> dict[str, Decoder]:
    """Make the decoder of every CAN bus of a profile, by the bus's name."""
    return {
        bus: _cansimple(profile, bus) if entry.protocol == "cansimple" else _canopen(profile, bus)
        for bus, entry in profile.buses.items()
        if is_can(entry)
    }


def decode(decoders: Mapping[str, Decoder], frame: Any) -> Any:
    """Return what a `drivers.can.candump.LoggedFrame` says, a `drivers.can.decoded.Decoded`."""
    from drivers.can.decoded import UNKNOWN

    decoder = decoders.get(frame.channel)
    return UNKNOWN if decoder is None else decoder.decode(frame.can_id, frame.data)


def hexadecimal(frame: Any) -> tuple[str, str]:
    """Return a frame's identifier and its data as candump writes them; ``R`` asks for data."""
    from drivers.can.candump import format_frame

    can_id, _, data = format_frame(frame.can_id, frame.data).partition("#")
    return can_id, data


def _canopen(profile: Profile, bus: str) -> Decoder:
    from drivers.canopen.decoder import CanopenDecoder

    nodes: list[Any] = []
    names: dict[int, Any] = {}
    for name, entry in profile.devices.items():
        # What a driver does not describe shows as frames of nodes without a name.
        describe = getattr(entry.settings, "describe_nodes", None)
        if entry.bus != bus or describe is None:
            continue
        described = describe(name)
        nodes += described
        if entry.eds is not None:
            eds = _read_eds(entry.eds)
            names |= {node.node: eds for node in described}
    master = getattr(profile.buses[bus].settings, "master_id", 0)
    return CanopenDecoder(nodes, master, names)


def _cansimple(profile: Profile, bus: str) -> Decoder:
    from drivers.odrive.decoder import CansimpleDecoder

    return CansimpleDecoder(
        (name, entry.settings)
        for name, entry in profile.devices.items()
        if entry.bus == bus and entry.driver == "odrive"
    )


def _read_eds(path: Path) -> Any:
    from drivers.canopen.eds import read_eds

    return read_eds(path)
