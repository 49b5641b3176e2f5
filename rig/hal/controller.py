"""What the loop needs of a controller: a pure function of its state, reference and own memory."""

from typing import Protocol, TypeVar

State = TypeVar("State", contravariant=True)
Reference = TypeVar("Reference", contravariant=True)
Command = TypeVar("Command", covariant=True)


class Controller(Protocol[Reference, State, Command]):
    """A discrete controller with a fixed period.

    Made as ``Class(settings, model, period)``: its section of the profile, what the mechanism
    tells of the mechanics (`Mechanism.model_of`), and the loop's period in seconds. No I/O, no
    clock, no log, no randomness: the same sequence of states and references gives the same
    sequence of commands. A law need not import this; it satisfies it by its methods.
    """

    def compile(self) -> None:
        """Compile now what would otherwise be compiled in the first cycle; may do nothing."""
        ...

    def reset(self, state: State) -> None:
        """Forget the past and start bumplessly from the measured `state`."""
        ...

    def update(self, state: State, reference: Reference) -> Command:
        """Return the command for this period.

        Raises
        ------
        ValueError
            It cannot go on: the loop makes the rig safe.
        """
        ...
