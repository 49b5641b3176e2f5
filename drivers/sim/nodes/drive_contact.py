"""The contact of an emergency stop that is wired to an emulated drive."""

from drivers.cia402.contact_settings import ContactSettings
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.faults import whole_number


def wire_contact(drive: EmulatedNode, contact: ContactSettings) -> None:
    """Wire a contact to a drive, which knows the fault ``emergency_stop`` from now on.

    Its value is 1, pressed, or 0, released; 1 if there is none.
    """
    mask = 1 << contact.bit
    inputs = drive.dictionary.find(0x60FD, 0)

    def press(value: float | None) -> None:
        pressed = whole_number(drive.name, "emergency_stop", value, 1, 1)
        level = mask if bool(pressed) is not contact.active_low else 0
        inputs.value = inputs.default = level  # a drive that restarts finds it as it is

    press(0.0)
    drive.add_fault("emergency_stop", press, lambda: press(0.0))
