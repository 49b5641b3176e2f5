"""The state machine of a CiA 402 drive, seen from the master.

References
----------
IEC 61800-7-201 (CiA 402-2): power drive system state machine, status word 0x6041 and control
word 0x6040.
"""

from enum import IntEnum
from typing import Final


class DriveState(IntEnum):
    """States of the power drive system; the values are those of the masked status word."""

    NOT_READY = 0x00
    SWITCH_ON_DISABLED = 0x40
    READY_TO_SWITCH_ON = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP_ACTIVE = 0x07
    FAULT_REACTION_ACTIVE = 0x0F
    FAULT = 0x08


FAULTY: Final = (DriveState.FAULT, DriveState.FAULT_REACTION_ACTIVE)


class Goal(IntEnum):
    """The state in which the master wants a drive."""

    DISABLED = 0
    ENABLED = 1
    STOPPED = 2


# Control words; fault reset (0x80) is not among them, since the cycle never sends it.
DISABLE_VOLTAGE: Final = 0x00
QUICK_STOP: Final = 0x02
SHUTDOWN: Final = 0x06
SWITCH_ON: Final = 0x07
ENABLE_OPERATION: Final = 0x0F
FAULT_RESET: Final = 0x80

# Bits of the status word.
VOLTAGE_ENABLED: Final = 0x0010
"""Its power stage has voltage, and may have it (not where safe torque off is open)."""
LIMIT_ACTIVE: Final = 0x0800
FOLLOWING_ERROR: Final = 0x2000

_NAMES: Final = {
    DriveState.NOT_READY: "NOT READY TO SWITCH ON",
    DriveState.SWITCH_ON_DISABLED: "SWITCH ON DISABLED",
    DriveState.READY_TO_SWITCH_ON: "READY TO SWITCH ON",
    DriveState.SWITCHED_ON: "SWITCHED ON",
    DriveState.OPERATION_ENABLED: "OPERATION ENABLED",
    DriveState.QUICK_STOP_ACTIVE: "QUICK STOP ACTIVE",
    DriveState.FAULT_REACTION_ACTIVE: "FAULT REACTION ACTIVE",
    DriveState.FAULT: "FAULT",
}

# Bit 5 (quick stop) tells states apart only where the power stage may be on.
_SHORT: Final[dict[int, DriveState]] = {
    state.value: state
    for state in (
        DriveState.NOT_READY,
        DriveState.SWITCH_ON_DISABLED,
        DriveState.FAULT_REACTION_ACTIVE,
        DriveState.FAULT,
    )
}
_LONG: Final[dict[int, DriveState]] = {
    state.value: state
    for state in (
        DriveState.READY_TO_SWITCH_ON,
        DriveState.SWITCHED_ON,
        DriveState.OPERATION_ENABLED,
        DriveState.QUICK_STOP_ACTIVE,
    )
}

_CONTROL: Final[dict[Goal, dict[DriveState, int]]] = {
    Goal.ENABLED: {
        DriveState.SWITCH_ON_DISABLED: SHUTDOWN,
        DriveState.READY_TO_SWITCH_ON: SWITCH_ON,
        DriveState.SWITCHED_ON: ENABLE_OPERATION,
        DriveState.OPERATION_ENABLED: ENABLE_OPERATION,
        # Out of a quick stop by way of SWITCH ON DISABLED, which every drive can do.
        DriveState.QUICK_STOP_ACTIVE: DISABLE_VOLTAGE,
    },
    Goal.DISABLED: {
        DriveState.OPERATION_ENABLED: SWITCH_ON,  # "disable operation": stops by its ramp
        DriveState.SWITCHED_ON: SHUTDOWN,
    },
}


def decode_state(status: int) -> DriveState | None:
    """Return the state that a status word tells; None if it tells none."""
    return _LONG.get(status & 0x6F) or _SHORT.get(status & 0x4F)


def next_control(state: DriveState | None, goal: Goal) -> int:
    """Return the control word for the one next transition towards a goal.

    It depends on nothing but the last state seen, so that a lost frame costs a cycle and
    nothing else. A fault is never reset here.

    Parameters
    ----------
    state : DriveState or None
        Of the last status word.
    goal : Goal
        STOPPED keeps a drive in a quick stop, and one that is not enabled out of use.
    """
    if goal is Goal.STOPPED:
        return QUICK_STOP
    if state is None:
        return DISABLE_VOLTAGE
    return _CONTROL[goal].get(state, DISABLE_VOLTAGE)


def describe_status(status: int) -> str:
    """Return a status word in words."""
    state = decode_state(status)
    name = "no state of CiA 402" if state is None else _NAMES[state]
    said = f"status word 0x{status:04X} ({name})"
    if status & VOLTAGE_ENABLED or state is None or state in FAULTY:
        return said
    return f"{said}, its motor has no voltage: safe torque off is open, or its supply is off"
