"""Workers that judge the candidates of a search; what was judged is kept."""

import hashlib
import json
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Final

from controllers.base import Tunable
from rig.sweeping.best import KEEP_ALL, Best
from rig.sweeping.coordinator import Coordinator, Limits
from rig.sweeping.finding import MetricCell
from rig.sweeping.journal import Journal
from rig.sweeping.point import PointJob
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.tuning.candidate import job_of
from rig.tuning.ensemble import DRAWN, Plants
from rig.tuning.gains import gains_at
from rig.tuning.walk import Place

SHAKEN_AT_ONCE: Final = 20
"""Drawn plants that a worker shakes before somebody is told."""
_BAD: Final = 3000.0
"""Cost of gains that a law refuses."""


class Jury:
    """Workers that judge candidates, the same ones never twice.

    Parameters
    ----------
    tunables : sequence of Tunable
        What a place stands for.
    text : str
        Of the request.
    code : str
        Of what is installed.
    folder : Path
        Of the search.
    journal : Journal
        Keeps what was judged.
    pool : Pool
        The workers.
    progress : SweepProgress
        Is told of each.
    """

    def __init__(
        self, tunables: Sequence[Tunable], text: str, code: str, folder: Path, journal: Journal,
        pool: Pool, progress: SweepProgress,
    ) -> None:  # fmt: skip
        self._tunables, self._text, self._code, self._folder = tunables, text, code, folder
        self._journal, self._pool, self._progress = journal, pool, progress

    def __call__(self, places: Sequence[Place], plants: Plants) -> list[tuple[float, Place]]:
        """Return places with what their gains cost on some plants."""
        jobs = [self._job(place, plants) for place in places]
        self._run(jobs)
        return [(self._cost(job.name), place) for job, place in zip(jobs, places, strict=True)]

    def shake(self, place: Place, part: int) -> dict[int, float]:
        """Return the greatest sensitivity of a place's gains on each drawn plant of a part.

        A law that refuses the gains, or a loop that cannot be measured, has none.
        """
        numbers = range(part * DRAWN, (part + 1) * DRAWN)
        jobs = [
            self._job(place, Plants((), tuple(numbers[first : first + SHAKEN_AT_ONCE])))
            for first in range(0, DRAWN, SHAKEN_AT_ONCE)
        ]
        self._run(jobs)
        found = [self._metrics(job.name) for job in jobs]
        return {int(cell["name"]): cell["value"] for cell in chain.from_iterable(found)}

    def _run(self, jobs: Sequence[PointJob]) -> None:
        best = Best(None, KEEP_ALL, self._folder)
        coordinator = Coordinator(self._journal, self._pool, self._progress, Limits(), best)
        coordinator.run(iter(jobs))

    def _job(self, place: Place, plants: Plants) -> PointJob:
        gains = gains_at(self._tunables, place)
        text = json.dumps([self._text, gains, plants, self._code])
        name = hashlib.sha256(text.encode()).hexdigest()[:32]
        return job_of(self._text, gains, plants, self._code, self._folder, name)

    def _cost(self, name: str) -> float:
        metrics = self._metrics(name)
        return metrics[0]["value"] if metrics else _BAD

    def _metrics(self, name: str) -> list[MetricCell]:
        return self._journal[name]["metrics"] if name in self._journal else []
