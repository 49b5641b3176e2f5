"""Decoders of a profile's CAN buses: frames in the profile's names and in SI."""

from collections.abc import Mapping

from rig.assembly.registry import REGISTRY
from rig.assembly.rows import load
from rig.config import Profile
from rig.hal.frames import UNKNOWN, Decoded, Decoder, LoggedFrame


def make_decoders(profile: Profile) -> dict[str, Decoder]:
    """Make the decoder of every bus of a profile whose protocol has one, by the bus's name."""
    decoders: dict[str, Decoder] = {}
    for bus, entry in profile.buses.items():
        path = REGISTRY.protocol(entry.protocol).decoder
        if path is not None:
            devices = [
                (name, device.settings, device.eds)
                for name, device in profile.devices.items()
                if device.bus == bus
            ]
            decoders[bus] = load(path)(entry.settings, devices)
    return decoders


def decode(decoders: Mapping[str, Decoder], frame: LoggedFrame) -> Decoded:
    """Return what a frame says."""
    decoder = decoders.get(frame.channel)
    return UNKNOWN if decoder is None else decoder.decode(frame.can_id, frame.data)


def hexadecimal(frame: LoggedFrame) -> tuple[str, str]:
    """Return a frame's identifier and its data as candump writes them; ``R`` asks for data."""
    from drivers.can.candump import format_frame

    can_id, _, data = format_frame(frame.can_id, frame.data).partition("#")
    return can_id, data
