"""The contact of an emergency stop, at a digital input of a drive.

References
----------
IEC 61800-7-201 (CiA 402-2): digital inputs 0x60FD, whose bits 16 … 31 are the maker's.
"""

from math import inf
from typing import Final

from drivers.canopen.mapping import Entry
from drivers.cia402.contact_settings import ContactSettings
from rig.hal import Reading

DIGITAL_INPUTS: Final = Entry(0x60FD, 0, "u32")


def contact_at(joint: str, settings: ContactSettings | None) -> "DriveContact | None":
    """Return the contact that is wired to a joint's drive, if one is."""
    return None if settings is None or settings.joint != joint else DriveContact(settings)


class DriveContact:
    """The contact as the drive's samples show it; pressed until it is seen closed.

    Parameters
    ----------
    settings : ContactSettings
        Its wiring.
    """

    def __init__(self, settings: ContactSettings) -> None:
        self._mask = 1 << settings.bit
        self._pressed_level = 0 if settings.active_low else self._mask
        self.forget()

    def forget(self) -> None:
        """Take it for pressed again, and a press before now for none."""
        self.reading: Reading[bool] = Reading(True, -inf)
        self.was_pressed = False

    def see(self, inputs: int, t: float) -> None:
        """Take the drive's inputs as they were at `t`, s."""
        pressed = inputs & self._mask == self._pressed_level
        self.reading = Reading(pressed, t)
        if pressed:
            self.was_pressed = True

    def take_look(self, data: bytes, now: float) -> None:
        """Take the answer to a question for 0x60FD."""
        self.see(int.from_bytes(data[:4], "little"), now)
