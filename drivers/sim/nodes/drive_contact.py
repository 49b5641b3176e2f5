"""The contact of an emergency stop that is wired to an emulated drive."""

from functools import partial

from drivers.cia402.contact_settings import ContactSettings
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.faults import whole_number


def wire_contact(drive: EmulatedNode, contact: ContactSettings) -> None:
    """Wire a contact to a drive, which knows the faults of it from now on.

    ``emergency_stop`` presses it, ``stop_wire_off`` takes its wire off; a value of 0 undoes that.
    """
    mask = 1 << contact.bit
    inputs = drive.dictionary.find(0x60FD, 0)
    found = dict.fromkeys(("emergency_stop", "stop_wire_off"), False)

    def change(fault: str, value: float | None) -> None:
        found[fault] = bool(whole_number(drive.name, fault, value, 1, 1))
        closes = found["emergency_stop"] is not contact.active_low
        level = mask if closes and not found["stop_wire_off"] else 0
        inputs.value = inputs.default = level  # a drive that restarts finds it as it is

    change("emergency_stop", 0.0)
    for fault in found:
        drive.add_fault(fault, partial(change, fault), partial(change, fault, 0.0))
