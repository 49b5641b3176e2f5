"""What settings must be together: every rule that is broken is told, and not only the first."""

from collections.abc import Callable
from types import TracebackType
from typing import ParamSpec

_Given = ParamSpec("_Given")


class BrokenRules(ValueError):
    """Rules that a dataclass of settings does not keep.

    Parameters
    ----------
    messages : tuple of str
        One for each.
    """

    def __init__(self, messages: tuple[str, ...]) -> None:
        self.messages = messages
        super().__init__(" ".join(messages))


class Rules:
    """The rules of one ``__post_init__``: a ``with`` block that raises all that was noted."""

    def __init__(self) -> None:
        self._broken: list[str] = []

    def __enter__(self) -> "Rules":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # What cannot be computed of values that broke a rule says nothing more.
        if self._broken and (error is None or isinstance(error, ValueError | ArithmeticError)):
            raise BrokenRules(tuple(dict.fromkeys(self._broken))) from error

    def broken(self, message: str) -> None:
        """Note a rule that is not kept."""
        self._broken.append(message)

    def of(
        self, check: Callable[_Given, object], *given: _Given.args, **named: _Given.kwargs
    ) -> None:
        """Note what another check refuses: that of a base class, say."""
        try:
            check(*given, **named)
        except ValueError as error:
            self._broken.extend(told_by(error))


def told_by(error: BaseException) -> tuple[str, ...]:
    """Return the messages of an error: one for each rule that was broken."""
    return error.messages if isinstance(error, BrokenRules) else (str(error),)
