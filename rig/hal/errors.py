"""What can go wrong with a rig, as one tree.

::

    RigError
    ├── ConfigurationError      a file, option or combination is wrong     (exit 2)
    │   ├── SeveralErrors       several of them, found in one pass
    │   └── ContractBroken      code behind a name is not what it must be
    ├── DeviceError             a device or bus is not as it should be     (exit 3 or 4)
    │   ├── ConnectionFailed    it never answered, or answered as another
    │   └── DeviceFault         it reported or showed a fault
    └── SafetyError             a measured or commanded value is not safe  (exit 4)
        ├── LimitExceeded
        ├── StaleReading
        ├── EmergencyStop
        └── LoopStalled

Whether a `DeviceError` means "never energised" (3) or "fault while running" (4)
depends on when it comes, so the runtime decides that, not the class.
"""

import math
from collections.abc import Sequence

from rig.hal.formats import format_outside


class RigError(Exception):
    """Base of every error that this program raises on purpose."""


class ConfigurationError(RigError):
    """A profile, experiment, calibration or option cannot be used as it is."""


class SeveralErrors(ConfigurationError):
    """Everything that was found in one pass.

    Parameters
    ----------
    messages : sequence of str
        One for each.
    """

    def __init__(self, messages: Sequence[str]) -> None:
        self.messages = tuple(dict.fromkeys(messages))
        count = len(self.messages)
        super().__init__("\n".join([*self.messages, *([f"{count} errors"] if count > 1 else [])]))

    @staticmethod
    def raise_if_any(messages: Sequence[str]) -> None:
        """Raise what was found, if anything was."""
        if messages:
            raise SeveralErrors(messages)

    @staticmethod
    def told_by(error: ConfigurationError) -> tuple[str, ...]:
        """Return the messages of any such error."""
        return error.messages if isinstance(error, SeveralErrors) else (str(error),)


class ContractBroken(ConfigurationError):
    """Code behind a name is not, or does not return, what the contract says."""


class MotionRefused(ConfigurationError):
    """The rig cannot, or must not, move as it is asked to; found before it moved."""


class DeviceError(RigError):
    """A device or its bus is not as it should be.

    Parameters
    ----------
    device : str
        The device's name in the profile.
    what : str
        One sentence without the device's name.
    node : int, optional
        Node number on its bus.
    object : str, optional
        The object, register or frame concerned, e.g. ``"0x6443:01"``.
    value, bound : str, optional
        What was seen and what was allowed, formatted with their unit.
    """

    def __init__(
        self,
        device: str,
        what: str,
        *,
        node: int | None = None,
        object: str | None = None,
        value: str | None = None,
        bound: str | None = None,
    ) -> None:
        self.device = device
        self.what = what
        self.node = node
        self.object = object
        self.value = value
        self.bound = bound
        super().__init__(str(self))

    def __str__(self) -> str:
        where = self.device if self.node is None else f"{self.device} (node 0x{self.node:02X})"
        text = f"{where}: {self.what}"
        details = [
            f"{label} {item}"
            for label, item in (
                ("object", self.object),
                ("value", self.value),
                ("bound", self.bound),
            )
            if item is not None
        ]
        return f"{text} [{', '.join(details)}]" if details else text


class ConnectionFailed(DeviceError):
    """A device never answered, or what answered is not what the profile says."""


class DeviceFault(DeviceError):
    """A device reported a fault or showed one."""


class SafetyError(RigError):
    """A measured or commanded value is not safe."""


class LimitExceeded(SafetyError):
    """A quantity left its permitted range.

    Parameters
    ----------
    quantity : str
        What left its range, e.g. ``"position of the pair"``.
    value : float
        What was measured or commanded, SI.
    lower, upper : float
        The permitted range, SI.
    unit : str
        The SI unit of all three.
    suspicion : str, optional
        What else looks wrong, and may be the cause.
    """

    def __init__(
        self,
        quantity: str,
        value: float,
        lower: float,
        upper: float,
        unit: str,
        suspicion: str | None = None,
    ) -> None:
        self.quantity = quantity
        self.value = value
        self.lower = lower
        self.upper = upper
        self.unit = unit
        super().__init__(
            f"{quantity} is {format_outside(value, lower, upper, unit)}"
            + (f"; {suspicion}" if suspicion else "")
        )

    def suspecting(self, suspicion: str) -> "LimitExceeded":
        """Return the same error with a likely cause."""
        named = LimitExceeded(
            self.quantity, self.value, self.lower, self.upper, self.unit, suspicion
        )
        for note in getattr(self, "__notes__", ()):
            named.add_note(note)
        return named


class StaleReading(SafetyError):
    """A reading is older than its limit.

    Parameters
    ----------
    device : str
        The device whose reading is too old.
    age, bound : float
        How old it is and how old it may be, s.
    part : str
        What of the device it is of: ``joint q2``; empty: all of it.
    """

    def __init__(self, device: str, age: float, bound: float, part: str = "") -> None:
        self.device = device
        self.age = age
        self.bound = bound
        # Rounded up: one that is older by a microsecond is not as old as is allowed.
        shown = math.ceil(age * 1e4 - 1e-9) / 10.0
        super().__init__(
            f"{f'{device} {part}' if part else device}: the last reading is {shown:.1f} ms old, "
            f"at most {bound * 1e3:.1f} ms is allowed"
        )


class EmergencyStop(SafetyError):
    """The emergency stop was pressed."""

    @classmethod
    def open_at(cls, place: str) -> "EmergencyStop":
        """Return the error of a contact that is open, with the device and input that read it."""
        return cls(
            "the emergency stop is pressed or its circuit is open; its contact is read by " + place
        )


class LoopStalled(SafetyError):
    """The control loop missed more deadlines than it may."""
