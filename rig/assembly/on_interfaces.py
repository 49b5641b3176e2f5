"""Other interfaces than the profile's, from the command line: ``vcan0``, ``slcan:/dev/ttyACM0``."""

import re
from difflib import get_close_matches
from typing import Any

from rig.assembly.buses import is_can
from rig.assembly.rig import Backend
from rig.config import BusEntry, Profile
from rig.hal import ConfigurationError

Interfaces = dict[str, dict[str, Any]]
"""Settings that replace a bus's own, by the bus's name."""

_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")
_SHARED = ("socketcan", "udp_multicast")
"""Interfaces that two programs of one host may open at once, and hear each other on."""
_ON_THIS_HOST = ("udp_multicast",)
"""Interfaces that never leave the host; `drivers.can.interfaces` sees to it."""


def backend_of(on: str) -> Backend:
    """Return the backend that ``--on`` means, be it one's name or an interface.

    An interface that never leaves the host has a simulated rig on it, and any other a real one.

    Raises
    ------
    ConfigurationError
        It can be neither: a channel bears a number (``vcan0``), and anything else has an interface
        in front of it (``slcan:/dev/ttyACM0``).
    """
    if on in list(Backend):
        return Backend(on)
    if ":" not in on and not any(map(str.isdigit, on)):
        near = get_close_matches(on, [str(name) for name in Backend], n=1)
        hint = f" Did you mean {near[0]}?" if near else ""
        raise ConfigurationError(
            f"{on!r} is neither one of {', '.join(Backend)} nor a CAN interface such as vcan0, "
            f"vcan0,vcan1, socketcan:can0 or slcan:/dev/ttyACM0.{hint}"
        )
    first = on.split(",", maxsplit=1)[0]
    interface, channel = _split(first.partition("=")[2] or first)
    stays = interface in _ON_THIS_HOST or channel.startswith(("vcan", "vxcan"))
    return Backend.VCAN if stays else Backend.HARDWARE


def parse_interfaces(on: str, profile: Profile) -> Interfaces:
    """Return the interface of each CAN bus.

    Parameters
    ----------
    on : str
        ``CHANNEL`` or ``INTERFACE:CHANNEL`` for each CAN bus in the profile's order, with
        commas between; a channel alone is SocketCAN's. From a single one with a number on,
        further buses take the next numbers: ``vcan0`` means ``vcan0,vcan1`` for two buses.
        ``can1=vcan5,can0=vcan4`` names the buses. ``vcan`` is short for ``vcan0``.
    profile : Profile
        Whose buses.

    Raises
    ------
    ConfigurationError
        It does not fit the profile's buses.
    """
    buses = [name for name, entry in profile.buses.items() if is_can(entry)]
    if not buses:
        raise ConfigurationError(
            f"--on {on}: the profile {profile.name} has no CAN bus, so it runs on no CAN interface"
        )
    words = [word.strip() for word in ("vcan0" if on == "vcan" else on).split(",")]
    if any("=" in word for word in words):
        named = _named(on, words, buses)
    else:
        if len(words) == 1:
            words = _count_on(words[0], len(buses))
        if len(words) != len(buses):
            raise ConfigurationError(
                f"--on {on}: {len(words)} interfaces for the CAN buses of {profile.name}, "
                f"{', '.join(buses)}; give one for each, or a single one with a number, "
                "from which the others count on"
            )
        named = dict(zip(buses, words, strict=True))
    if len(set(named.values())) != len(named):
        raise ConfigurationError(f"--on {on}: two buses on one interface")
    return {bus: _settings(on, word, profile.buses[bus]) for bus, word in named.items()}


def _named(on: str, words: list[str], buses: list[str]) -> dict[str, str]:
    named = {bus.strip(): word.strip() for bus, _, word in (w.partition("=") for w in words)}
    if set(named) != set(buses) or len(words) != len(named):
        raise ConfigurationError(
            f"--on {on}: the profile's CAN buses are {', '.join(buses)}; name each once, "
            "as in " + ",".join(f"{bus}=vcan{number}" for number, bus in enumerate(buses))
        )
    return named


def _count_on(word: str, count: int) -> list[str]:
    found = _LAST_NUMBER.search(word)
    if count == 1 or found is None:
        return [word]
    before, number, after = word[: found.start()], int(found[1]), word[found.end() :]
    return [f"{before}{number + k}{after}" for k in range(count)]


def _split(word: str) -> tuple[str, str]:
    interface, colon, channel = word.partition(":")
    return (interface, channel) if colon else ("socketcan", word)


def own_interfaces(profile: Profile) -> str | None:
    """Return the interfaces of a profile's CAN buses as `parse_interfaces` takes them.

    None: it has no CAN bus, or one on an adapter that a single program opens.
    """
    own = [entry.settings for entry in profile.buses.values() if is_can(entry)]
    if any(its.interface not in _SHARED for its in own):
        return None
    words = [
        its.channel if its.interface == "socketcan" else f"{its.interface}:{its.channel}"
        for its in own
    ]
    return ",".join(words) or None


def _settings(on: str, word: str, replaced: BusEntry) -> dict[str, Any]:
    interface, channel = _split(word)
    if not interface or not channel:
        raise ConfigurationError(
            f"--on {on}: an interface is CHANNEL or INTERFACE:CHANNEL, as in vcan0, "
            "socketcan:can0 or slcan:/dev/ttyACM0"
        )
    # The profile's options belong to the interface that is replaced; its own one keeps them.
    own = replaced.settings
    options: dict[str, Any] = {}
    if (interface, channel) == (own.interface, own.channel):
        options = dict(own.options)
    elif interface == "udp_multicast" and (number := _LAST_NUMBER.search(channel)) is not None:
        # Linux hands what comes for one group to whoever listens to another on the same port.
        from drivers.can.multicast import FIRST_PORT

        options["port"] = FIRST_PORT + int(number[1])
    return {"interface": interface, "channel": channel, "options": options}
