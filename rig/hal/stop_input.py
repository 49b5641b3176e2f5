"""The contact of an emergency stop, as whatever device reads it shows it."""

from abc import abstractmethod
from typing import Protocol

from rig.hal.reading import Reading


class EmergencyStopInput(Protocol):
    """A device that also reads the emergency-stop contact.

    Attributes
    ----------
    name : str
        The device's name in the profile.
    looks_alone : bool
        Whether `look` works before `connect`, which a drive that holds its joint would let go at.
    no_contact : str
        The key of its settings that would say where the contact is, if none says it; else empty.
    """

    name: str
    looks_alone: bool = False
    no_contact: str = ""

    @abstractmethod
    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop is pressed (an open contact or broken wire is pressed)."""

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed at any look since `connect`, be it released again."""
        return self.emergency_stop().value

    def stop_place(self) -> str:
        """Return which device reads the contact, and at which of its inputs, for messages."""
        return self.name

    def look(self) -> None:
        """Read the contact now, outside the cycle: between the steps of connecting a rig.

        A device whose reading is always the newest has nothing to do.
        """
        return

    def wake(self) -> None:
        """Have `look` answered that works before `connect`, by a device that a bus has stopped."""
        return
