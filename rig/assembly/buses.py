"""What the assembly knows of each protocol beside its bus class: how a bus is opened and filled."""

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from rig.assembly.registry import REGISTRY
from rig.config import BusEntry, Profile
from rig.hal import Clock, CyclicBus


class _Protocol(NamedTuple):
    """Paths of functions, imported on use.

    Parameters
    ----------
    open : str
        ``open(settings)`` opens the interface.
    check_load : str
        ``check_load(name, settings, devices, rate)`` computes the load, and refuses too much.
    is_can : bool
        Whether it runs on a CAN interface.
    """

    open: str
    check_load: str
    is_can: bool = True


_CAN = _Protocol("drivers.can:open_bus", "drivers.canopen.load:check_bus_load")
_PROTOCOLS = {
    "canopen": _CAN,
    "cansimple": _CAN,
    "dynamixel": _Protocol(
        "drivers.dynamixel.port:open_port", "drivers.dynamixel.load:check_serial_load", False
    ),
}


def is_can(entry: BusEntry) -> bool:
    """Return whether a bus runs on a CAN interface, as one of another package's protocol does."""
    return _PROTOCOLS.get(entry.protocol, _CAN).is_can


def make_bus(
    name: str,
    entry: BusEntry,
    clock: Clock,
    period: float,
    on: Mapping[str, Any] | None = None,
    opened: Callable[[], Any] | None = None,
    frames: Any = None,
) -> CyclicBus:
    """Make a bus.

    Parameters
    ----------
    name : str
        Its name in the profile.
    entry : BusEntry
        Protocol and settings.
    clock : Clock
        The rig's.
    period : float
        Of the loop, s.
    on : mapping, optional
        Settings that replace the profile's: another interface.
    opened : callable, optional
        Returns the interface, in the place of the real one.
    frames : FrameLog, optional
        Records what passes on a CAN interface, see `drivers.can.frame_log`.
    """
    settings = dataclasses.replace(entry.settings, **(on or {}))
    open_interface = _load(_PROTOCOLS.get(entry.protocol, _CAN).open)
    opened = opened or (lambda: open_interface(settings))
    if frames is not None and is_can(entry):
        opened = partial(_open_recorded, frames, name, clock, opened)
    bus: CyclicBus = REGISTRY.load("bus", entry.protocol)(name, settings, opened, clock, period)
    return bus


def _open_recorded(frames: Any, name: str, clock: Clock, opened: Callable[[], Any]) -> Any:
    return frames.tap(name, clock, opened())


def bus_loads(profile: Profile) -> dict[str, Any]:
    """Return the worst-case load of each bus of a profile, `drivers.canopen.load.BusLoad`.

    Raises
    ------
    ConfigurationError
        A bus has more to carry than its `max_load`.
    """
    return {
        name: _load(_PROTOCOLS.get(entry.protocol, _CAN).check_load)(
            name, entry.settings, _devices_on(profile, name), profile.loop.rate
        )
        for name, entry in profile.buses.items()
    }


def _devices_on(profile: Profile, bus: str) -> list[tuple[str, Any]]:
    return [(name, entry.settings) for name, entry in profile.devices.items() if entry.bus == bus]


def _load(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
