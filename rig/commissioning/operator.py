"""Who stands at the rig: a person who is told and asked, answers from a file, or nobody."""

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

from rig.commissioning.forms import Form, anything
from rig.hal import ConfigurationError
from rig.hal.world import BreakableWorld


class Task(NamedTuple):
    """Something that hands or eyes have to do.

    Parameters
    ----------
    key : str
        Its name in a file of answers.
    text : str
        What to do, in one sentence.
    in_simulation : callable
        Does it in a simulated world, and returns what a person would answer.
    form : callable
        Says what is expected in the place of an answer that is none.
    stem : str
        The key without its end where that is a number that was measured; else empty.
    """

    key: str
    text: str
    in_simulation: Callable[[BreakableWorld], str]
    form: Form = anything
    stem: str = ""


class Operator(Protocol):
    """A person at the rig, or a stand-in."""

    def do(self, task: Task, world: BreakableWorld | None) -> None:
        """Have something done or looked at now; returns at once, as the rig may be energised."""

    def answer(self, task: Task) -> str:
        """Return what came of a task that was given before; nothing is energised meanwhile."""


class SimulatedOperator(Operator):
    """Hands and eyes in a simulated world."""

    def __init__(self) -> None:
        self._answers: dict[str, str] = {}

    def do(self, task: Task, world: BreakableWorld | None) -> None:
        """See `Operator.do`."""
        assert world is not None, "only a simulated rig has a simulated operator"
        self._answers[task.key] = task.in_simulation(world)

    def answer(self, task: Task) -> str:
        """See `Operator.answer`."""
        return self._answers[task.key]


class Person(Operator):
    """A person at a terminal.

    Parameters
    ----------
    tell, ask : callable
        Print a sentence; print one and return what was typed.
    """

    def __init__(self, tell: Callable[[str], None], ask: Callable[[str], str]) -> None:
        self._tell = tell
        self._ask = ask

    def do(self, task: Task, world: BreakableWorld | None) -> None:
        """See `Operator.do`."""
        self._tell(task.text)

    def answer(self, task: Task) -> str:
        """See `Operator.answer`."""
        return self._ask(task.text)


class WrittenAnswers(Operator):
    """WrittenAnswers that were written down before, for somebody else's hands.

    Parameters
    ----------
    given : mapping
        By the keys of tasks.
    hands : Operator
        Does what there is to do.
    """

    def __init__(self, given: Mapping[str, str], hands: Operator) -> None:
        self._given = given
        self._hands = hands

    def do(self, task: Task, world: BreakableWorld | None) -> None:
        """See `Operator.do`."""
        self._hands.do(task, world)

    def answer(self, task: Task) -> str:
        """Return what was written down.

        Raises
        ------
        ConfigurationError
            Nothing was.
        """
        if task.key not in self._given:
            raise ConfigurationError(f"the file of answers has no {task.key!r}: {task.text}")
        return self._given[task.key]
