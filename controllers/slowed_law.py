"""A planning law whose motion is passed with a share of its speed."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

State = TypeVar("State", contravariant=True)
Reference = TypeVar("Reference", contravariant=True)


class Moving(Protocol):
    """A command with speeds."""

    @property
    def positions(self) -> tuple[float, ...]: ...  # noqa: D102 - rad
    @property
    def velocities(self) -> tuple[float, ...]: ...  # noqa: D102 - rad/s


Command = TypeVar("Command", bound=Moving, covariant=True)


class Planning(Protocol[State, Reference, Command]):
    """A law as far as it is slowed."""

    def reset(self, state: State) -> None:
        """See `Law.reset`."""

    def update(self, state: State, reference: Reference) -> Command:
        """See `Law.update`."""


class SlowedLaw(Generic[State, Reference, Command]):
    """A law for a shorter period than the loop's: it goes as far in a cycle as in that.

    Parameters
    ----------
    law : PlanningLaw
        Made for the loop's period times `share`; its motion is prepared.
    share : float
        Of the speed that it thinks it has.
    command : callable
        ``command(positions, velocities)``.
    """

    def __init__(
        self,
        law: Planning[State, Reference, Command],
        share: float,
        command: Callable[..., Command],
    ) -> None:
        self._law = law
        self._make = command
        self._share = share

    def reset(self, state: State) -> None:
        """See `Law.reset`."""
        self._law.reset(state)

    def update(self, state: State, reference: Reference) -> Command:
        """Return the law's own command, with the velocities that it comes to."""
        command = self._law.update(state, reference)
        slow = tuple([self._share * v for v in command.velocities])
        return self._make(command.positions, slow)
