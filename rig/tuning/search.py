"""The search for gains: a covariance matrix adaptation over candidates that workers judge.

References
----------
N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772, 2016.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple, Protocol

import numpy as np

from controllers.base import Tunable
from rig.hal.closed_loop import SENSITIVITY
from rig.sweeping.best import KEEP_ALL, Best
from rig.sweeping.code import code_version
from rig.sweeping.coordinator import Coordinator, Limits
from rig.sweeping.engine import WorkerSetup
from rig.sweeping.journal import Journal
from rig.sweeping.point import PointJob
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.tuning.candidate import PERFORM, job_of
from rig.tuning.ensemble import Member
from rig.tuning.gains import gains_at, place_of, values_of
from rig.tuning.score import LOST, score
from rig.tuning.walk import STEPS, Place, one_by_one, together, tried_by_walk
from rig.tuning.workbench import Request, Workbench

GENERATION: Final = 12
"""Candidates at once: what CMA takes for some 15 numbers."""
_STEPS: Final = (0.2, 0.12, 0.06)
"""Of each part of the search as it begins, as a share of the bounds."""
_MORE: Final = 2
"""So many plants come in before each part but the first: those that the best gains bear least."""
FIRST_LOOK: Final = 4
"""So many generations look anywhere; the best of them is where the search begins."""
_SHORTLIST: Final = (2, 2, 4)
"""So many candidates, the best of each part of the search, have the whole ensemble in the end."""
_WALKED: Final = 2
"""So many of the walk, or of what was seen before it, have it, too."""
LAST_LOOK: Final = 1 + _WALKED + sum(_SHORTLIST)
"""At most, those in force among them: some are the best of two parts."""
_PLACES: Final = 400
"""From so many places those are chosen."""
_BESIDE: Final = GENERATION
"""So many of them lie beside the gains in force: those of a rig much like this one are nearly
right, and may lack no more than a little margin."""
_STEPS_ASIDE: Final = 60
"""From so many places beside them those are chosen."""
_STEP_ASIDE: Final = 0.05
"""Their standard deviation, as a share of the bounds."""
_BAD: Final = 3000.0
"""Cost of gains that a law refuses."""


class FoundGains(NamedTuple):
    """The end of a search.

    Parameters
    ----------
    gains : dict of str to float
        The best.
    costs : tuple of float
        The least cost after each generation.
    members : tuple of int
        Corners of the ensemble that it was judged on in the end.
    """

    gains: dict[str, float]
    costs: tuple[float, ...]
    members: tuple[int, ...]


class GainSearch:
    """A search that goes on where it was broken off: what was judged before is not judged again.

    Parameters
    ----------
    bench : Workbench
        Of the request.
    request : Request
        What is tuned.
    folder : Path
        Keeps what was judged.
    workers : int
        Processes.
    generations : int
        How many.
    """

    def __init__(
        self, bench: Workbench, request: Request, folder: Path, workers: int, generations: int
    ) -> None:
        import cma

        self._cma = cma
        self._bench, self._text, self._folder = bench, request.text(), folder
        self._code = code_version().digest
        self._rng = np.random.default_rng(request.seed)
        self._workers, self._generations = workers, generations
        self.before = values_of(bench.tunables, bench.settings)
        """The gains that the profile has."""

    def run(self) -> FoundGains:
        """Search.

        Raises
        ------
        SweepStopped
            It cannot go on; what was judged is kept.
        """
        setup = WorkerSetup(PERFORM, self._code, self._folder.resolve() / "workers.log")
        progress = SweepProgress(
            trials_of(self._generations, len(self._bench.tunables)) + LAST_LOOK
        )
        with closing(Journal(self._folder)) as journal, closing(Pool(self._workers, setup)) as pool:
            judge = _Judge(
                self._bench.tunables, self._text, self._code, self._folder, journal, pool, progress
            )
            try:
                return self._go(judge, progress)
            finally:
                progress.clear()

    def _go(self, judge: "_Judge", progress: SweepProgress) -> FoundGains:
        members = self._bench.ensemble.first()
        here = place_of(self._bench.tunables, self._bench.settings)
        looks = [here, *self._robust_places(here), *self._stable_places(len(here))]
        seen = judge(looks, members)
        is_lost = seen[0][0] >= LOST
        least, best = min(seen)
        history = [least]
        members = self._with_worst(best, members)
        walked = self._walk(judge, best if is_lost else here, members)
        passed = sorted([*judge([best], members), *walked])
        finalists = [(seen[0][0], here), *passed[:_WALKED]]
        least, best = passed[0]
        progress.say(f"cost {least:.3f} on {len(members)} plants, one gain after the other")
        for part, step, wanted in zip(_parts(self._generations), _STEPS, _SHORTLIST, strict=True):
            if history[1:]:
                members = self._with_worst(best, members)
                ((least, best),) = judge([best], members)  # more, on more plants
            tried = self._adapt(judge, members, best, step, part)
            for generation in tried:
                least, best = min((least, best), *generation)
                history.append(least)
            progress.say(f"cost {least:.3f} on {len(members)} plants")
            finalists += sorted(chain.from_iterable(tried))[:wanted]
        return self._last_look(judge, [place for _, place in finalists], history, progress)

    def _walk(
        self, judge: "_Judge", place: Place, members: tuple[int, ...]
    ) -> list[tuple[float, Place]]:
        """Return the places that a walk from one tries, with their costs, the best first.

        Parameters
        ----------
        judge : _Judge
            Of candidates.
        place : list of float
            Where it begins: at the gains in force, unless they lose a plant.
        members : tuple of int
            Corners of the ensemble that candidates are judged on.
        """
        passed = judge([place], members)
        for step in STEPS:
            least, here = passed[0]
            alone = judge(one_by_one(here, step), members)
            both = judge(together(here, least, alone), members)
            passed = sorted([*passed, *alone, *both])
        return passed

    def _adapt(
        self, judge: "_Judge", members: tuple[int, ...], place: Place, step: float, count: int
    ) -> list[list[tuple[float, Place]]]:
        """Return generations of CMA-ES from a place, each its places with their costs."""
        strategy = self._strategy(place, step)
        generations = []
        for _ in range(count):
            asked = strategy.ask()
            tried = judge([[float(share) for share in one] for one in asked], members)
            strategy.tell(asked, [cost for cost, _ in tried])
            generations.append(tried)
        return generations

    def _last_look(
        self,
        judge: "_Judge",
        finalists: Sequence[Place],
        history: Sequence[float],
        progress: SweepProgress,
    ) -> FoundGains:
        """Return the gains that cost least on the whole ensemble.

        What was best on the few plants of the search may lose others, the sooner the fewer
        generations there were: gains of an earlier part may then be the better ones.
        """
        members = tuple(range(len(self._bench.ensemble.corners())))
        different = [place for k, place in enumerate(finalists) if place not in finalists[:k]]
        least, best = min(judge(different, members))
        progress.say(f"cost {least:.3f} on all {len(members)} plants")
        return FoundGains(gains_at(self._bench.tunables, best), tuple(history), members)

    def _stable_places(self, count: int) -> list[list[float]]:
        """Return places anywhere, those first whose loops are farthest from instability.

        A loop's margins cost a fiftieth of its trials: most places need no trial.
        """
        places: list[list[float]] = self._rng.uniform(size=(_PLACES, count)).tolist()
        nearness = [self._nearness(place) for place in places]
        order = sorted(range(_PLACES), key=lambda number: nearness[number])
        return [places[number] for number in order[: FIRST_LOOK * GENERATION - 1 - _BESIDE]]

    def _robust_places(self, here: Sequence[float]) -> list[list[float]]:
        """Return places beside one, those first whose loops keep their distance on every plant.

        Parameters
        ----------
        here : sequence of float
            Of the gains in force.
        """
        aside = self._rng.normal(0.0, _STEP_ASIDE, (_STEPS_ASIDE, len(here)))
        places: list[list[float]] = np.clip(np.asarray(here) + aside, 0.0, 1.0).tolist()
        nominal = [self._nearness(place) for place in places]
        few = sorted(range(_STEPS_ASIDE), key=lambda number: nominal[number])[: 2 * _BESIDE]
        members = self._bench.ensemble.near()
        worst = {number: self._nearness(places[number], members) for number in few}
        return [places[number] for number in sorted(few, key=lambda n: worst[n])[:_BESIDE]]

    def _nearness(self, place: Sequence[float], members: Sequence[Member] = ()) -> float:
        """Return how near the loop at a place is to instability; infinite: there is none.

        Parameters
        ----------
        place : sequence of float
            Of the gains.
        members : sequence of Member
            The plants, of which the worst counts; default: the nominal one.
        """
        gains = gains_at(self._bench.tunables, place)
        try:
            margins = self._bench.margins(gains, list(members) or [self._bench.ensemble.nominal])
        except ValueError:  # the law refuses these gains
            return math.inf
        if not all(margin.stable for margin in margins):
            return math.inf
        return max(SENSITIVITY, *(margin.sensitivity for margin in margins))

    def _strategy(self, place: Sequence[float], step: float) -> "_Strategy":
        options = {
            "bounds": [0.0, 1.0], "popsize": GENERATION, "verbose": -9,
            "seed": int(self._rng.integers(1, 2**31)),
        }  # fmt: skip
        strategy: _Strategy = self._cma.CMAEvolutionStrategy(
            np.clip(place, 0.01, 0.99), step, options
        )
        return strategy

    def _with_worst(self, place: Place, members: tuple[int, ...]) -> tuple[int, ...]:
        """Return the members, and besides the corners that the gains of a place bear least."""
        bench, corners = self._bench, self._bench.ensemble.corners()
        gains = gains_at(bench.tunables, place)
        nominal = bench.trial(gains, corners[0], coarse=True)
        costs = {}
        for number, corner in enumerate(corners):
            if number not in members:
                trial = bench.trial(gains, corner, coarse=True)
                costs[number] = score([nominal, trial], ()).cost
        worst = sorted(costs, key=lambda number: -costs[number])
        return (*members, *worst[:_MORE])


class _Strategy(Protocol):
    """A search that is asked for places and told what they cost."""

    def ask(self) -> Sequence[Sequence[float]]: ...

    def tell(self, places: Sequence[Sequence[float]], costs: Sequence[float]) -> None: ...


class _Judge:
    """Has candidates judged by workers, the same ones never twice."""

    def __init__(
        self, tunables: Sequence[Tunable], text: str, code: str, folder: Path, journal: Journal,
        pool: Pool, progress: SweepProgress,
    ) -> None:  # fmt: skip
        self._tunables, self._text, self._code, self._folder = tunables, text, code, folder
        self._journal, self._pool, self._progress = journal, pool, progress

    def __call__(
        self, places: Sequence[Place], members: tuple[int, ...]
    ) -> list[tuple[float, Place]]:
        """Return places with what their gains cost on some corners of the ensemble."""
        jobs = [self._job(gains_at(self._tunables, place), members) for place in places]
        best = Best(None, KEEP_ALL, self._folder)
        coordinator = Coordinator(self._journal, self._pool, self._progress, Limits(), best)
        coordinator.run(iter(jobs))
        return [(self._cost(job.name), place) for job, place in zip(jobs, places, strict=True)]

    def _job(self, gains: Mapping[str, float], members: tuple[int, ...]) -> PointJob:
        text = json.dumps([self._text, gains, members, self._code])
        name = hashlib.sha256(text.encode()).hexdigest()[:32]
        return job_of(self._text, gains, members, self._code, self._folder, name)

    def _cost(self, name: str) -> float:
        metrics = self._journal[name]["metrics"] if name in self._journal else []
        return metrics[0]["value"] if metrics else _BAD


def trials_of(generations: int, count: int) -> int:
    """Return how many candidates a search of so many gains tries at most before the last look."""
    return (FIRST_LOOK + generations) * GENERATION + tried_by_walk(count) + len(_STEPS) + 1


def _parts(generations: int) -> list[int]:
    """Return how the generations are parted: the last part has what is left."""
    each = generations // len(_STEPS)
    return [*(each for _ in _STEPS[1:]), generations - each * (len(_STEPS) - 1)]
