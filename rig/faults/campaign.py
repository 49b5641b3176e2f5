"""Many cases: drawn, and performed unit by unit, as many units at once as there are workers."""

import difflib
import random
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path

from rig.faults.case import UNIT, Case, draw_case
from rig.faults.catalogue import KINDS, kinds_for
from rig.faults.subject import Subject
from rig.faults.unit import no_verdict, perform_unit
from rig.faults.verdict import Verdict
from rig.faults.workers import Tell, share_out
from rig.hal import ConfigurationError

DOUBLES = 0.15
"""Share of the cases drawn at random in which a second fault follows."""
SHARING = 25
"""So many cases share a run: more would have one worker end long after the others."""

Job = tuple[Case, Subject]


def draw_once(subject: Subject, kinds: tuple[str, ...], seed: int, times: int) -> list[Case]:
    """Draw cases of chosen kinds; the first has the seed itself.

    Raises
    ------
    ConfigurationError
        There is no such kind, or the rig has nothing that could suffer it.
    """
    possible = kinds_for(subject)
    for name in kinds:
        if name not in possible:
            if name in KINDS:
                raise ConfigurationError(f"{subject.rig} has nothing that could suffer {name}")
            near = difflib.get_close_matches(name, possible, n=1)
            hint = f"did you mean {near[0]!r}?" if near else "`rig faults list` shows all"
            raise ConfigurationError(f"no fault is called {name!r}; {hint}")
    if len(kinds) > 2:
        raise ConfigurationError("a case has two faults at most")
    return [draw_case(subject, kinds, one) for one in _seeds(seed, times)]


def draw_each(subject: Subject, seed: int, times: int) -> list[Case]:
    """Draw cases of every kind that a rig can suffer, `times` each."""
    names = [(name,) for name in kinds_for(subject) for _ in range(times)]
    return _draw(subject, names, seed)


def draw_random(subject: Subject, seed: int, count: int) -> list[Case]:
    """Draw kinds at random, now and then two in one case."""
    chance = random.Random(f"{seed} {subject.rig}")
    names = [name for name in kinds_for(subject) if name != "nothing"]
    drawn = [
        tuple(chance.sample(names, 2 if chance.random() < DOUBLES else 1)) for _ in range(count)
    ]
    return _draw(subject, drawn, seed)


def _draw(subject: Subject, kinds: Sequence[tuple[str, ...]], seed: int) -> list[Case]:
    """Draw a case of each; neighbours share a run."""
    chance = random.Random(f"{seed} {subject.rig} units")
    first, count = chance.randrange(10_000), len(kinds)
    order = chance.sample(range(count), count)  # every unit has something of everything
    seeds = [UNIT * (first + place // SHARING) + place % SHARING for place in order]
    return [draw_case(subject, *pair) for pair in zip(kinds, seeds, strict=True)]


def _seeds(seed: int, times: int) -> list[int]:
    """Return a seed and those after it, some in each unit."""
    return [seed, *(seed + UNIT * (k // 5) + k % 5 for k in range(1, times))]


def run_cases(
    jobs: Sequence[Job],
    out: Path,
    configs: Path | None,
    workers: int,
    progress: Callable[[Verdict], None],
    *,
    keeps: bool = False,
) -> list[Verdict]:
    """Run cases, and return their verdicts, rig by rig.

    Parameters
    ----------
    jobs : sequence of (Case, Subject)
        What to do.
    out : Path
        Where the run folders go; those of cases in which nothing is wrong are removed.
    configs : Path, optional
        The folder of the configurations.
    workers : int
        How many units at once.
    progress : callable
        Told each verdict as it comes.
    keeps : bool
        Keep the run folders of all cases.
    """
    out = out.resolve()
    verdicts: list[Verdict] = []

    def perform(unit: Sequence[Job], tell: Tell) -> None:
        perform_unit([case for case, _ in unit], unit[0][1], out, configs, tell, keeps=keeps)

    for verdict in share_out(_units(jobs), perform, workers):
        verdicts.append(verdict)
        progress(verdict)
    order = {case: number for number, (case, _) in enumerate(jobs)}
    told = {verdict.case for verdict in verdicts}
    for case, subject in jobs:  # a worker that died is no pass
        if case not in told:
            verdicts.append(no_verdict(case, subject, "its worker ended without a word"))
            progress(verdicts[-1])
    return sorted(verdicts, key=lambda verdict: order[verdict.case])


def _units(jobs: Sequence[Job]) -> list[list[Job]]:
    def key(job: Job) -> tuple[str, str, str, int, int]:
        """Return what the cases of a run have in common."""
        case = job[0]
        drawn = -1 if case.drawn_with is None else case.drawn_with // UNIT
        return case.rig, case.stretch, case.experiment, case.seed, drawn

    return [list(group) for _, group in groupby(sorted(jobs, key=key), key)]
