"""The search for gains: a covariance matrix adaptation over candidates that workers judge.

References
----------
N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772, 2016.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple, Protocol

import numpy as np

from rig.hal.closed_loop import SENSITIVITY
from rig.sweeping.code import code_version
from rig.sweeping.engine import WorkerSetup
from rig.sweeping.journal import Journal
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.tuning.candidate import PERFORM
from rig.tuning.ensemble import DRAWN, Member, Plants
from rig.tuning.gains import gains_at, place_of, values_of
from rig.tuning.jury import SHAKEN_AT_ONCE, Jury
from rig.tuning.score import LOST, score
from rig.tuning.verdict import ENOUGH
from rig.tuning.walk import STEPS, Place, one_by_one, together, tried_by_walk
from rig.tuning.workbench import Request, Workbench

GENERATION: Final = 12
"""Candidates at once: what CMA takes for some 15 numbers."""
_STEPS: Final = (0.2, 0.12, 0.06)
"""Of each part of the search as it begins, as a share of the bounds."""
_MORE: Final = 2
"""So many corners come in before each part: those that the best gains bear least."""
_DRAWN: Final = 6
"""On so many of 200 plants margins are measured: those that the gains in force bear least."""
_MORE_DRAWN: Final = 3
"""And on so many of 200 others from each part on: those that the best gains bear least."""
_SPARED: Final = 5
"""One in so many of these counts no more than the next one: on some units a pair catches while it
is shaken, whatever the gains. Where the worst one counted, a search gave away half of the accuracy
of `cylinder-valves` for it."""
_WAY_BACK: Final = (1.0, 0.8, 0.6, 0.4)
"""Shares of the way from the gains in force to the best: what bears those plants may bear more than
is asked for."""
FIRST_LOOK: Final = 4
"""So many generations look anywhere; the best of them is where the search begins."""
_SHORTLIST: Final = (2, 2, 4)
"""So many candidates, the best of each part of the search, have the whole ensemble in the end."""
_WALKED: Final = 6
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


class FoundGains(NamedTuple):
    """The end of a search.

    Parameters
    ----------
    gains : dict of str to float
        The best.
    costs : tuple of float
        The least cost after each generation.
    plants : Plants
        Those of the ensemble that it was judged on in the end.
    """

    gains: dict[str, float]
    costs: tuple[float, ...]
    plants: Plants


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
        trials = trials_of(self._generations, len(self._bench.tunables)) + _shaken_at_most()
        progress = SweepProgress(trials + LAST_LOOK + len(_WAY_BACK))
        with closing(Journal(self._folder)) as journal, closing(Pool(self._workers, setup)) as pool:
            judge = Jury(
                self._bench.tunables, self._text, self._code, self._folder, journal, pool, progress
            )
            try:
                return self._go(judge, progress)
            finally:
                progress.clear()

    def _go(self, judge: Jury, progress: SweepProgress) -> FoundGains:
        here = place_of(self._bench.tunables, self._bench.settings)
        plants = _sparing(self._bench.ensemble.first(), _nearest(judge.shake(here, 1), _DRAWN))
        looks = [here, *self._robust_places(here), *self._stable_places(len(here))]
        seen = judge(looks, plants)
        is_lost = seen[0][0] >= LOST
        least, best = min(seen)
        history = [least]
        plants = self._with_worst(judge, best, plants)
        walked = self._walk(judge, best if is_lost else here, plants)
        passed = sorted([*judge([best], plants), *walked])
        finalists = [(seen[0][0], here), *passed[:_WALKED]]
        least, best = passed[0]
        progress.say(f"cost {least:.3f} {_on(plants)}, one gain after the other")
        for part, step, wanted in zip(_parts(self._generations), _STEPS, _SHORTLIST, strict=True):
            plants = self._with_worst(judge, best, plants)
            ((least, best),) = judge([best], plants)  # more, on more plants
            tried = self._adapt(judge, plants, best, step, part)
            for generation in tried:
                least, best = min((least, best), *generation)
                history.append(least)
            progress.say(f"cost {least:.3f} {_on(plants)}")
            finalists += sorted(chain.from_iterable(tried))[:wanted]
        everywhere = plants._replace(corners=tuple(range(len(self._bench.ensemble.corners()))))
        places = [place for _, place in finalists]
        different = [place for k, place in enumerate(places) if place not in places[:k]]
        best = self._last_look(judge, different, everywhere, progress)
        if best != here and plants.drawn:
            best = self._way_back(judge, here, best, everywhere, progress)
        return FoundGains(gains_at(self._bench.tunables, best), tuple(history), everywhere)

    def _walk(self, judge: Jury, place: Place, plants: Plants) -> list[tuple[float, Place]]:
        """Return the places that a walk from one tries, with their costs, the best first.

        Parameters
        ----------
        judge : Jury
            Of candidates.
        place : list of float
            Where it begins: at the gains in force, unless they lose a plant.
        plants : Plants
            Those that candidates are judged on.
        """
        passed = judge([place], plants)
        for step in STEPS:
            least, here = passed[0]
            alone = judge(one_by_one(here, step), plants)
            both = judge(together(here, least, alone), plants)
            passed = sorted([*passed, *alone, *both])
        return passed

    def _adapt(
        self, judge: Jury, plants: Plants, place: Place, step: float, count: int
    ) -> list[list[tuple[float, Place]]]:
        """Return generations of CMA-ES from a place, each its places with their costs."""
        strategy = self._strategy(place, step)
        generations = []
        for _ in range(count):
            asked = strategy.ask()
            tried = judge([[float(share) for share in one] for one in asked], plants)
            strategy.tell(asked, [cost for cost, _ in tried])
            generations.append(tried)
        return generations

    def _last_look(
        self,
        judge: Jury,
        finalists: Sequence[Place],
        plants: Plants,
        progress: SweepProgress,
    ) -> Place:
        """Return the place whose gains cost least on the whole ensemble.

        What was best on the few plants of the search may lose others, the sooner the fewer
        generations there were: gains of an earlier part may then be the better ones.
        """
        least, best = min(judge(finalists, plants))
        progress.say(f"cost {least:.3f} {_on(plants)}, which are all corners")
        return best

    def _way_back(
        self, judge: Jury, here: Place, best: Place, plants: Plants, progress: SweepProgress
    ) -> Place:
        """Return the place that costs least on the way from the gains in force to the best.

        A search is careful, as it has the plants that are borne least. Here every place has 200
        that it has not seen, and as many of them are spared as may miss the margin.
        """
        part = _part_after(plants)
        whole = Plants(
            plants.corners, tuple(range(part * DRAWN, (part + 1) * DRAWN)),
            round((1.0 - ENOUGH) * DRAWN),
        )  # fmt: skip
        between = [
            [old + share * (new - old) for old, new in zip(here, best, strict=True)]
            for share in _WAY_BACK
        ]
        passed = judge(between, whole)
        least, found = min(passed)
        share = _WAY_BACK[between.index(found)]
        progress.say(f"cost {least:.3f} {_on(whole)}, {share:.0%} of the way from those in force")
        return found

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

    def _with_worst(self, judge: Jury, place: Place, plants: Plants) -> Plants:
        """Return the plants, and besides those that the gains of a place bear least."""
        bench, corners = self._bench, self._bench.ensemble.corners()
        gains = gains_at(bench.tunables, place)
        nominal = bench.trial(gains, corners[0], coarse=True)
        costs = {}
        for number, corner in enumerate(corners):
            if number not in plants.corners:
                trial = bench.trial(gains, corner, coarse=True)
                costs[number] = score([nominal, trial], ()).cost
        worst = sorted(costs, key=lambda number: -costs[number])
        drawn = _nearest(judge.shake(place, _part_after(plants)), _MORE_DRAWN)
        return _sparing((*plants.corners, *worst[:_MORE]), (*plants.drawn, *drawn))


class _Strategy(Protocol):
    """A search that is asked for places and told what they cost."""

    def ask(self) -> Sequence[Sequence[float]]: ...

    def tell(self, places: Sequence[Sequence[float]], costs: Sequence[float]) -> None: ...


def _nearest(found: Mapping[int, float], count: int) -> tuple[int, ...]:
    """Return the drawn plants that are nearest to instability, by their greatest sensitivity."""
    return tuple(sorted(found, key=lambda number: -found[number])[:count])


def _sparing(corners: tuple[int, ...], drawn: tuple[int, ...]) -> Plants:
    return Plants(corners, drawn, len(drawn) // _SPARED)


def _part_after(plants: Plants) -> int:
    """Return which part of all drawn plants comes next: none comes twice, the first not at all."""
    return 1 + max(plants.drawn, default=0) // DRAWN


def _on(plants: Plants) -> str:
    shaken = f", {len(plants.drawn)} shaken" if plants.drawn else ""
    return f"on {len(plants.corners)} plants{shaken}"


def _shaken_at_most() -> int:
    """Return how many jobs shake all drawn plants: at first, before the walk and each part."""
    return (2 + len(_STEPS)) * math.ceil(DRAWN / SHAKEN_AT_ONCE)


def trials_of(generations: int, count: int) -> int:
    """Return how many candidates a search of so many gains tries at most before the last look."""
    return (FIRST_LOOK + generations) * GENERATION + tried_by_walk(count) + len(_STEPS) + 1


def _parts(generations: int) -> list[int]:
    """Return how the generations are parted: the last part has what is left."""
    each = generations // len(_STEPS)
    return [*(each for _ in _STEPS[1:]), generations - each * (len(_STEPS) - 1)]
