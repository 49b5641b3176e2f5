"""What the loop needs of a controller: a pure function of its state, reference and own memory."""

from abc import abstractmethod
from typing import Any, ClassVar, Protocol, TypeVar

State = TypeVar("State", contravariant=True)
Reference = TypeVar("Reference", contravariant=True)
Command = TypeVar("Command", covariant=True)


class Controller(Protocol[Reference, State, Command]):
    """A discrete controller with a fixed period.

    No I/O, no clock, no log, no randomness: the same sequence of states and references gives the
    same sequence of commands.
    """

    @abstractmethod
    def reset(self, state: State) -> None:
        """Forget the past and start bumplessly from the measured `state`."""

    @abstractmethod
    def update(self, state: State, reference: Reference) -> Command:
        """Return the command for this period.

        Raises
        ------
        ValueError
            It cannot go on: the loop makes the rig safe.
        """


AnyController = Controller[Any, Any, Any]
"""A controller of any mechanism."""


class Law(Controller[Reference, State, Command], Protocol[Reference, State, Command]):
    """A controller that a profile names.

    Made as ``Class(settings, model, period)``: its section of the profile, what the mechanism
    tells of the mechanics (`Mechanism.model_of`), and the loop's period in seconds. A law need
    not import this package; it satisfies the protocol by its methods, which `controllers.base`
    has with defaults. A law that plans a whole motion has what its mechanism's `plan` asks for.
    """

    Settings: ClassVar[type]
    """Dataclass of the law's section."""

    def compile(self) -> None:
        """Compile now what would otherwise be compiled in the first cycle; may do nothing."""
