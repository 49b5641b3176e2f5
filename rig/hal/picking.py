"""Pick the devices that a mechanism's settings name."""

from collections.abc import Mapping
from types import TracebackType
from typing import TypeVar, cast

from rig.hal.devices import Device
from rig.hal.errors import ConfigurationError, SeveralErrors
from rig.hal.offers import lacking

Kind = TypeVar("Kind")


class DevicePicker:
    """Picks the devices that a mechanism's settings name.

    In a ``with`` block all are picked before what is wrong with any is raised; nothing may be done
    with them there.

    Parameters
    ----------
    section : str
        The mechanism's section of the profile, for messages.
    devices : mapping
        The rig's devices by name.
    """

    def __init__(self, section: str, devices: Mapping[str, Device]) -> None:
        self._section = section
        self._devices = devices
        self._found: list[str] | None = None

    def __enter__(self) -> "DevicePicker":
        self._found = []
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        found, self._found = self._found, None
        if error is None and found:
            raise SeveralErrors(found)

    def __call__(self, role: str, name: str, kind: type[Kind]) -> Kind:
        """Return the device of a role; see `pick_device`."""
        try:
            return pick_device(f"{self._section}.{role}", name, kind, self._devices)
        except ConfigurationError as error:
            if self._found is None:
                raise
            self._found.append(str(error))
            return cast("Kind", None)  # which nobody sees: the block ends with the error

    def if_named(self, role: str, name: str | None, kind: type[Kind]) -> Kind | None:
        """Return the device of a role that a rig need not have."""
        return None if name is None else self(role, name, kind)


def pick_device(role: str, name: str, kind: type[Kind], devices: Mapping[str, Device]) -> Kind:
    """Return the device of a role.

    Parameters
    ----------
    role : str
        Where the profile names it, for messages.
    name : str
        The device's name.
    kind : type
        A capability protocol of `rig.hal` that it must satisfy.
    devices : mapping
        The rig's devices by name.

    Raises
    ------
    ConfigurationError
        There is no such device, or it lacks the capability.
    """
    if name not in devices:
        raise ConfigurationError(
            f"{role}: no device is called {name!r}; there are {', '.join(devices)}"
        )
    device = devices[name]
    missing = lacking(device, kind)
    if missing:
        raise ConfigurationError(
            f"{role}: {name} is no {kind.__name__}: it has no {', '.join(missing)}"
        )
    return cast("Kind", device)
