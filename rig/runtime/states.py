"""The states of a rig and the moves between them."""

from collections.abc import Callable
from enum import StrEnum

from rig.hal import RigError


class RigState(StrEnum):
    """The state of a rig."""

    DISCONNECTED = "disconnected"
    IDLE = "idle"
    RUNNING = "running"
    STOPPING = "stopping"
    FAULT = "fault"


_MOVES = {
    RigState.DISCONNECTED: {RigState.IDLE, RigState.FAULT},
    RigState.IDLE: {RigState.RUNNING, RigState.DISCONNECTED, RigState.FAULT},
    RigState.RUNNING: {RigState.STOPPING, RigState.FAULT},
    RigState.STOPPING: {RigState.IDLE, RigState.FAULT},
    RigState.FAULT: set(),
}


class IllegalMove(RigError):
    """The rig cannot go from its state to the one that was asked for."""


class StateMachine:
    """The rig's state in one process; nothing leaves FAULT.

    Beyond the process, on hardware, `rig.experiment.fault_latch` keeps it.

    Parameters
    ----------
    on_change : callable
        Called with the old and the new state after each move.
    """

    def __init__(self, on_change: Callable[[RigState, RigState], None] | None = None) -> None:
        self.state = RigState.DISCONNECTED
        self.on_change = on_change
        self.fault: Exception | None = None

    def move(self, to: RigState) -> None:
        """Go to another state.

        Raises
        ------
        IllegalMove
            There is no such move, or the rig is in FAULT.
        """
        if to not in _MOVES[self.state]:
            reason = f"; it is latched by: {self.fault}" if self.state is RigState.FAULT else ""
            raise IllegalMove(f"the rig is {self.state} and cannot become {to}{reason}")
        self._set(to)

    def latch_fault(self, fault: Exception) -> None:
        """Go to FAULT from any state; the first fault is the one that is kept."""
        if self.state is not RigState.FAULT:
            self.fault = fault
            self._set(RigState.FAULT)

    def _set(self, to: RigState) -> None:
        old, self.state = self.state, to
        if self.on_change is not None:
            self.on_change(old, to)
