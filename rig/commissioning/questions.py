"""What an acceptance test asks of whoever stands at the rig, found out on emulated devices."""

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rig.assembly import Backend, build_rig
from rig.commissioning.forms import Form
from rig.commissioning.operator import SimulatedOperator, Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep
from rig.config import Profile
from rig.hal import RigError


class Question(NamedTuple):
    """Something that a file of answers holds.

    Parameters
    ----------
    key : str
        Its key in the file.
    step : str
        Which step asks.
    text : str
        As it is asked.
    simulated : str
        What simulated hands have answered: in what form the step takes it.
    """

    key: str
    step: str
    text: str
    simulated: str


class Rehearsed(NamedTuple):
    """The questions of an acceptance test, as far as it was gone through.

    Parameters
    ----------
    questions : list of Question
        In their order.
    tasks : mapping of str to Task
        Of each question, by its key.
    stopped : str or None
        What ended it before all was asked.
    """

    questions: list[Question]
    tasks: Mapping[str, Task]
    stopped: str | None

    def stem_of(self, key: str) -> str:
        """Return the stem of a key that ends in a number that is measured; empty: it has none."""
        for task in self.tasks.values():
            if task.stem and key.startswith(task.stem) and _is_number(key[len(task.stem) :]):
                return task.stem
        return ""

    def form_of(self, key: str) -> Form | None:
        """Return the form of the answer to a key; None: nothing asks for it."""
        if key in self.tasks:
            return self.tasks[key].form
        stem = self.stem_of(key)
        return next((its.form for its in self.tasks.values() if stem and its.stem == stem), None)


def _is_number(text: str) -> bool:
    try:
        return isfinite(float(text))
    except ValueError:
        return False


class _Noting(SimulatedOperator):
    """Simulated hands that note what they are asked."""

    def __init__(self) -> None:
        super().__init__()
        self.step = ""
        self.asked: dict[str, Question] = {}
        self.tasks: dict[str, Task] = {}

    def answer(self, task: Task) -> str:
        """See `Operator.answer`."""
        found = super().answer(task)
        self.tasks[task.key] = task
        self.asked[task.key] = Question(task.key, self.step, task.text, found)
        return found

    def rehearsed(self, stopped: str | None) -> Rehearsed:
        """Return what was asked so far."""
        return Rehearsed(list(self.asked.values()), self.tasks, stopped)


def questions_of(profile: Profile, steps: Sequence[AcceptanceStep]) -> Rehearsed:
    """Return what is asked, and where the rehearsal stopped if it did not come to its end.

    Parameters
    ----------
    profile : Profile
        The rig's.
    steps : sequence of AcceptanceStep
        Of its acceptance test, in their order.
    """
    if profile.plant is None:
        return Rehearsed([], {}, f"{profile.name} has no plant on which it could be gone through")
    hands = _Noting()
    with TemporaryDirectory() as out:
        site = Site(profile, lambda its: build_rig(its, Backend.VIRTUAL), hands, Path(out))
        for step in steps:
            hands.step = step.name
            try:
                step.perform(site)
            except RigError as error:
                return hands.rehearsed(f"{step.name}: {error}")
    return hands.rehearsed(None)
