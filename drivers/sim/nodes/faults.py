"""Faults of an emulated node, by name: what any CANopen device may do wrong."""

from math import inf

from drivers.sim.breakable import Breakable
from drivers.sim.nodes.emergency import GENERIC, Emergency
from drivers.sim.nodes.object_dictionary import Abort, Variable


class FaultInjection(Breakable):
    """The faults that every node knows; a device profile adds its own with `add_fault`.

    ``silent`` (value: s, default for ever)
        Off the bus: sends and hears nothing, as with a pulled plug.
    ``reboot``
        Power cycle: all settings are lost, a boot-up message follows.
    ``wrong_state`` (value: NMT state, default 4 = STOPPED)
        Changes its state although no master asked for it.
    ``wrong_device_type`` (value: object 0x1000, default 0)
        Says that it is something else.
    ``sdo_abort`` (value: index·256 + sub-index)
        Refuses every access to that object with 0x08000000.
    ``sdo_silent`` (value: s, default for ever)
        Does not answer SDO requests.
    ``heartbeat_silent`` (value: s, default for ever)
        Works, but sends no heartbeat.
    ``emergency`` (value: error code, default 0x1000)
        Sends an EMCY.
    ``repair``
        Ends everything above except what a reboot or state change did.
    """

    # Provided by the node.
    now: float
    due: float

    def __init__(self) -> None:
        super().__init__()
        self.lasting: set[str] = set()
        """The faults of `add_lasting_fault` that last now."""
        self.fault_due = inf
        self._ends: dict[str, float] = {}

    def offer_faults(
        self, device_type: Variable, refused: dict[tuple[int, int], int], emergency: Emergency
    ) -> None:
        """Make the faults known that need no more than these parts of the node."""
        true_type = device_type.default

        def set_device_type(value: float | None) -> None:
            # In the default too: the fault is one of the device, a reset does not end it.
            number = whole_number(self.name, "wrong_device_type", value, 0, 0xFFFF_FFFF)
            device_type.value = device_type.default = number

        def restore_device_type() -> None:
            device_type.value = device_type.default = true_type

        def refuse(value: float | None) -> None:
            address = whole_number(self.name, "sdo_abort", value, 0x1000_00, 0xFFFF_FF)
            refused[address >> 8, address & 0xFF] = Abort.GENERAL

        def report(value: float | None) -> None:
            code = whole_number(self.name, "emergency", value, 0x1000, 0xFFFF)
            emergency.raise_error(f"injected {code}", code, GENERIC)

        for fault in ("silent", "sdo_silent", "heartbeat_silent"):
            self.add_lasting_fault(fault)
        self.add_fault("wrong_device_type", set_device_type, restore_device_type)
        self.add_fault("sdo_abort", refuse, refused.clear)
        self.add_fault("emergency", report, emergency.clear_injected)

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; see `Breakable.inject`."""
        super().inject(fault, value)
        self.due = -inf

    def repair(self) -> None:
        """End all faults that last."""
        self._ends.clear()
        self.fault_due = inf
        self.lasting.clear()
        super().repair()
        self.due = -inf

    def add_lasting_fault(self, fault: str) -> None:
        """Make a fault known that does nothing but last, for its value in s if it has one."""
        self.add_fault(fault, lambda value: self._last_for(fault, value))

    def _last_for(self, fault: str, duration: float | None) -> None:
        """Have a fault last, for `duration` (s) if there is one.

        Raises
        ------
        ValueError
            The duration is not positive.
        """
        lasting = self.lasting_time("a fault", duration)
        self.lasting.add(fault)
        self._ends.pop(fault, None)
        if lasting < inf:
            self._ends[fault] = self.now + lasting
        self.fault_due = min(self._ends.values(), default=inf)

    def expire_faults(self, now: float) -> None:
        """End the faults whose time has come."""
        if now < self.fault_due:
            return
        for fault in [fault for fault, end in self._ends.items() if now >= end]:
            del self._ends[fault]
            self.lasting.discard(fault)
        self.fault_due = min(self._ends.values(), default=inf)


def whole_number(name: str, fault: str, value: float | None, default: int, high: int) -> int:
    """Return a fault's value as an integer in 0 … `high`.

    Raises
    ------
    ValueError
        It is none, or outside.
    """
    number = default if value is None else value
    if not 0 <= number <= high or number != int(number):
        raise ValueError(f"{name}: {fault} takes a whole number in 0 … {high}, not {number:g}")
    return int(number)
