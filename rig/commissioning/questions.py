"""What an acceptance test asks of whoever stands at the rig, found out on emulated devices."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rig.assembly import Backend, build_rig
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


class _Noting(SimulatedOperator):
    """Simulated hands that note what they are asked."""

    def __init__(self) -> None:
        super().__init__()
        self.step = ""
        self.asked: dict[str, Question] = {}

    def answer(self, task: Task) -> str:
        """See `Operator.answer`."""
        found = super().answer(task)
        self.asked[task.key] = Question(task.key, self.step, task.text, found)
        return found


def questions_of(
    profile: Profile, steps: Sequence[AcceptanceStep]
) -> tuple[list[Question], str | None]:
    """Return what is asked, and where the rehearsal stopped if it did not come to its end.

    Parameters
    ----------
    profile : Profile
        The rig's.
    steps : sequence of AcceptanceStep
        Of its acceptance test, in their order.
    """
    if profile.plant is None:
        return [], f"{profile.name} has no plant on which it could be gone through"
    hands = _Noting()
    with TemporaryDirectory() as out:
        site = Site(profile, lambda its: build_rig(its, Backend.VIRTUAL), hands, Path(out))
        for step in steps:
            hands.step = step.name
            try:
                step.perform(site)
            except RigError as error:
                return list(hands.asked.values()), f"{step.name}: {error}"
    return list(hands.asked.values()), None
