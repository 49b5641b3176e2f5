"""The state machine inside an emulated CiA 402 drive.

References
----------
IEC 61800-7-201 (CiA 402-2): figure and table of the power drive system state machine,
transitions 1 … 16, and the coding of status word and control word.
"""

from collections.abc import Callable
from enum import Enum


class State(Enum):
    """States with the bits that the status word shows for them (bits 0 … 3, 5, 6)."""

    NOT_READY = 0b000_0000
    DISABLED = 0b100_0000
    READY = 0b010_0001
    SWITCHED_ON = 0b010_0011
    ENABLED = 0b010_0111
    QUICK_STOP = 0b000_0111
    FAULT_REACTION = 0b000_1111
    FAULT = 0b000_1000


POWERED = (State.ENABLED, State.QUICK_STOP, State.FAULT_REACTION)
"""States in which the motor is under torque."""

_RESET = 1 << 7


class DriveStateMachine:
    """Take control words, one transition each, and leave the ramps to the drive.

    Parameters
    ----------
    slow_down : callable
        ``slow_down(state)`` starts the ramp of a state that is about to be left, or of the
        quick stop or fault reaction that was entered, and returns where it ends: a state, or
        None to stay. Called for a command that the option codes may answer with a ramp.
    entered : callable
        Called after every change of state.
    may_enable : callable
        Whether the power stage may be used.

    Attributes
    ----------
    state : State
        Now.
    ending : State or None
        Where a ramp that is under way will end.
    """

    def __init__(
        self,
        slow_down: Callable[[str], "State | None"],
        entered: Callable[["State"], None],
        may_enable: Callable[[], bool],
    ) -> None:
        self._slow_down = slow_down
        self._entered = entered
        self._may_enable = may_enable
        self._word = 0
        self.state = State.NOT_READY
        self.ending: State | None = None

    def power_on(self) -> None:
        """Begin anew, not ready yet."""
        self._word = 0
        self.ending = None
        self.state = State.NOT_READY

    def enter(self, state: State) -> None:
        """Change the state."""
        self.ending = None
        if state is not self.state:
            self.state = state
            self._entered(state)

    def finish_ramp(self) -> None:
        """Take the state that a ramp was to end in: the motor stands still."""
        if self.ending is not None:
            self.enter(self.ending)

    def fault(self) -> None:
        """Take the fault reaction, or the fault at once where no torque is on."""
        if self.state in (State.FAULT, State.FAULT_REACTION):
            return
        if self.state in POWERED:
            self._ramp("fault", State.FAULT_REACTION)
        else:
            self.enter(State.FAULT)

    def stop_quickly(self) -> None:
        """Obey the command "quick stop", whoever gives it."""
        if self.state is State.ENABLED:
            self._ramp("quick stop", State.QUICK_STOP)
        elif self.state in (State.READY, State.SWITCHED_ON):
            self.enter(State.DISABLED)

    def disable_voltage(self) -> None:
        """Obey the command "disable voltage": no torque, at once."""
        if self.state in (State.READY, State.SWITCHED_ON, State.ENABLED, State.QUICK_STOP):
            self.enter(State.DISABLED)

    def command(self, word: int) -> None:
        """Obey a control word: at most one transition."""
        rising = word & _RESET and not self._word & _RESET
        self._word = word
        state = self.state
        if state is State.FAULT:
            if rising:
                self.enter(State.DISABLED)
        elif state in (State.FAULT_REACTION, State.NOT_READY):
            pass
        elif not word & 0b0010:
            self.disable_voltage()
        elif not word & 0b0100:
            self.stop_quickly()
        elif self.ending is not None:
            pass  # on its way down already
        elif not word & 0b0001:
            self._shut_down(state)
        elif not word & 0b1000:
            self._switch_on(state)
        else:
            self._enable(state)

    def _shut_down(self, state: State) -> None:
        if state is State.DISABLED:
            if self._may_enable():
                self.enter(State.READY)
        elif state is State.SWITCHED_ON:
            self.enter(State.READY)
        elif state is State.ENABLED:
            self._ramp("shutdown", state)

    def _switch_on(self, state: State) -> None:
        if state is State.READY:
            self.enter(State.SWITCHED_ON)
        elif state is State.ENABLED:
            self._ramp("disable operation", state)

    def _enable(self, state: State) -> None:
        # From READY this is "switch on" too; the second transition needs a second word.
        if state is State.READY:
            self.enter(State.SWITCHED_ON)
        elif state is State.SWITCHED_ON or (state is State.QUICK_STOP and self.ending is None):
            self.enter(State.ENABLED)

    def _ramp(self, reason: str, meanwhile: State) -> None:
        """Enter the state of a ramp; the option code says what comes after it."""
        if meanwhile is not self.state:
            self.enter(meanwhile)
        self.ending = self._slow_down(reason)


def stop_for(reason: str, option: int, slow: int, quick: int) -> tuple[State | None, int]:
    """Return the state after a stop, None for the same, and its ramp, 0 for none.

    Parameters
    ----------
    reason : str
        Which option code it is that counts.
    option : int
        Its value.
    slow, quick : int
        The ramps 0x6084 and 0x6085.
    """
    if reason == "quick stop":
        ramp = {0: 0, 1: slow, 5: slow}.get(option, quick)
        return {5: None, 6: None}.get(option, State.DISABLED), ramp
    if reason == "fault":
        return State.FAULT, (0, slow, quick)[option]
    if reason == "halt":
        return None, quick if option == 2 else slow
    return State.READY if reason == "shutdown" else State.SWITCHED_ON, slow if option else 0
