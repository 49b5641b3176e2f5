"""What the program asks of the settings of any driver and any bus; every answer has a default."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import ClassVar, NamedTuple, Protocol, Self


class Address(NamedTuple):
    """A node that a profile says is on a bus.

    Parameters
    ----------
    name : str
        The device, or device and axis, ``"servos.q1"``.
    number : int
        Its node number, axis number or id.
    profile, vendor, product, serial : int or None
        What it must say of itself; None: anything. `profile` is the CiA device profile.
    """

    name: str
    number: int
    profile: int | None = None
    vendor: int | None = None
    product: int | None = None
    serial: int | None = None


class AxisBounds(NamedTuple):
    """The bounds within which a drive takes setpoints.

    Parameters
    ----------
    low, high : float
        Of its axis, rad.
    speed : float
        Greatest one, rad/s.
    """

    low: float
    high: float
    speed: float


Keys = tuple[str | int, ...]
"""Where a value stands below a device's entry in the profile."""


Scalar = str | int | float | bool | None
"""One value of a profile."""


class FileIdentity(NamedTuple):
    """Whose file a device's own description file is; None where it does not say.

    Attributes
    ----------
    vendor, product : int or None
        Numbers of both.
    profile : int or None
        Number of the CiA device profile.
    """

    vendor: int | None
    product: int | None
    profile: int | None


class DeviceFile(Protocol):
    """A device's own description file (``eds:``)."""

    def identity(self) -> FileIdentity:
        """Return whose file it is."""
        return FileIdentity(None, None, None)

    def mapped(self, plain: Mapping[str, object]) -> Mapping[Keys, Scalar]:
        """Return the settings by which the device exchanges what it can, by their keys.

        Parameters
        ----------
        plain : mapping
            The settings of a device like it.
        """
        return {}

    def values(self, plain: Mapping[str, object]) -> Mapping[tuple[str, ...], Scalar]:
        """Return the settings that the file knows, by their keys.

        Parameters
        ----------
        plain : mapping
            The settings as they were written; those that they say already stay.
        """

    def findings(self, device: str, settings: "DriverSettings") -> Iterable[tuple[Keys, str]]:
        """Return what the device cannot do of what the settings want, with the keys that want it.

        Parameters
        ----------
        device : str
            Its name in the profile.
        settings : DriverSettings
            The driver's.
        """


class DriverSettings:
    """Base of the settings of a driver."""

    __slots__ = ()

    scaling: ClassVar[tuple[str, ...]] = ()
    """Keys that say what its raw numbers mean, ``*`` for any one of a section: what was measured
    through them does not hold with others."""

    def channel_names(self) -> tuple[str, ...]:
        """Return the device's channels or axes as the plant calls them; empty if it has no names.

        A device without names measures the one channel that `Mechanism.wiring` gives it.
        """
        return ()

    def kept_channels(self) -> tuple[str, ...]:
        """Return which of its channels keep their energy in the safe state, as the profile says."""
        return ()

    def axis_bounds(self) -> Mapping[str, AxisBounds]:
        """Return beyond what each of its axes refuses a setpoint; empty if it has no axes."""
        return {}

    def resolution(self, channel: str) -> float:
        """Return the smallest step of what a channel reads, SI; 0 where it is not known."""
        return 0.0

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the nodes that should answer on the bus.

        Parameters
        ----------
        device : str
            The device's name in the profile.
        serial : int or None
            The serial number that the profile wants of it.
        """
        return ()

    def acts_after(self, bus: object) -> float | None:
        """Return after how long without the program the device makes itself safe, s.

        None: it takes no setpoints.

        Parameters
        ----------
        bus : object
            The settings of its bus; None if it is on none.
        """
        return None

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings for a rig that nobody trusts yet. Default: there is nothing to lower.

        Parameters
        ----------
        speed : float
            At most so fast may an axis be, rad/s.
        window : float
            At most so far may an axis be from its setpoint, rad.
        effort : float
            Share of the torque or current that the settings permit.
        """
        return self

    def device_path(self) -> str | None:
        """Return the file below ``/dev`` that it is opened by; None: it has none of its own."""
        return None

    def confirmed_bytes(self) -> tuple[bool, ...]:
        """Return which bytes of what it is told come back as it got them; empty: none do.

        Of the first frame with setpoints, as those that confirm any confirm all of them. A byte
        that comes back is not wrong unseen.
        """
        return ()

    def holds_without_position(self) -> bool:
        """Return whether its velocity loop alone holds an axis whose position encoder lies."""
        return False

    @classmethod
    def read_description(cls, path: Path) -> DeviceFile | None:
        """Read the file that the device's key ``eds`` names; None: the driver reads none.

        Raises
        ------
        ConfigurationError
            The file is missing or broken.
        """
        return None


class Endpoint(NamedTuple):
    """The interface of a bus, for people: ``socketcan``, ``can0`` and bit/s."""

    interface: str
    channel: str
    bitrate: int


class BusSettings(Protocol):
    """The settings of a bus, whatever is spoken on it."""

    __slots__ = ()

    @property
    def max_load(self) -> float:
        """Share of its time that a rig may take."""

    def endpoint(self) -> Endpoint:
        """Return what it runs on."""

    def trouble(self) -> str | None:
        """Say why what a file names is not opened, whatever is there; None: it may be."""
        return None
