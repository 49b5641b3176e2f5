"""What every controller is: a pure function of its state, reference and own memory."""

from typing import Protocol, TypeVar

State = TypeVar("State", contravariant=True)
Reference = TypeVar("Reference", contravariant=True)
Command = TypeVar("Command", covariant=True)


class Controller(Protocol[Reference, State, Command]):
    """A discrete controller with a fixed period.

    No I/O, no clock, no log, no randomness: the same sequence of states and references
    gives the same sequence of commands.
    """

    def reset(self, state: State) -> None:
        """Forget the past and start bumplessly from the measured `state`."""
        ...

    def update(self, state: State, reference: Reference) -> Command:
        """Return the command for this period."""
        ...
