"""Between the driver and whatever grabs and detects for it."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

from drivers.marker_camera.sighting import Sighting


class Ready(NamedTuple):
    """The source is open; frames follow.

    Attributes
    ----------
    serial : str or None
        The camera's serial number, if it has one.
    """

    serial: str | None


class Failure(NamedTuple):
    """No more frames will come; the fields are those of `rig.hal.DeviceError`."""

    what: str
    object: str | None = None
    value: str | None = None
    bound: str | None = None


Event = Ready | Sighting | Failure


class CameraLink(Protocol):
    """Gives a driver the outcome of each frame: a process, or a simulated camera."""

    def show_in(self, picture: Path) -> None:
        """Put pictures into this file from the next `open` on, if it has any."""

    def open(self, now: float) -> None:
        """Start; `Ready` or a `Failure` follows."""

    def poll(self, now: float) -> Sequence[Event]:
        """Return what happened since the last call, in order; never waits."""

    def close(self) -> None:
        """Stop. Idempotent."""
