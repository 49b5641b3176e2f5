"""One candidate of a search, judged where a worker is."""

import json
from collections.abc import Mapping
from pathlib import Path

from rig.hal.closed_loop import ClosedLoop
from rig.sweeping.finding import MetricCell, PointFinding, one_line
from rig.sweeping.point import PointJob
from rig.sweeping.source import PointSource
from rig.tuning.ensemble import Plants
from rig.tuning.score import HUNTING, LOST, NEAREST, REFUSED, STOPPED, UNSTABLE, score
from rig.tuning.workbench import Workbench, workbench_of

PERFORM = "rig.tuning.candidate:perform"


def job_of(
    text: str,
    gains: Mapping[str, float],
    plants: Plants,
    code: str,
    folder: Path,
    name: str,
) -> PointJob:
    """Return a candidate as a worker gets it.

    Parameters
    ----------
    text : str
        Of the request.
    gains : mapping of str to float
        To be judged.
    plants : Plants
        On these. Without a corner no motion is run: how near its loop is to instability on each
        drawn plant is all that is asked.
    code, folder, name
        Of the code, of the search, and of this candidate.
    """
    options = (text, json.dumps(gains), json.dumps(plants))
    return PointJob(name, PointSource("", (), None, "", code), options, folder, folder)


def perform(job: PointJob) -> PointFinding:
    """Judge a candidate; return its cost, or where no corner is asked for its sensitivities."""
    text, gains, plants = job.options
    bench, chosen, on = workbench_of(text), json.loads(gains), Plants(*json.loads(plants))
    try:
        found = {"cost": cost_of(bench, chosen, on)} if on.corners else _nearness(bench, chosen, on)
    except ValueError as error:  # the law refuses these gains
        return PointFinding(
            point=job.name, status="refused", reason=one_line(str(error)), metrics=[]
        )
    cells = [
        MetricCell(name=name, value=value, unit="", bound=None, kind=None)
        for name, value in found.items()
    ]
    return PointFinding(point=job.name, status="ok", reason="", metrics=cells)


def cost_of(bench: Workbench, gains: Mapping[str, float], plants: Plants) -> float:
    """Return what gains cost on some plants.

    No time is spent on those that are not stable, or that hardware is refused with on the plant as
    told, nor on more plants than one that is lost. Where all corners are asked for, each that the
    program would be stopped on, or that hunts, costs `STOPPED`: nobody has calibrated those, so a
    stop is no hazard, and no margin is given for it; and these are run with the profile's substep,
    as the verdict does: who hunts differs with it. Margins are measured on the drawn plants,
    where a loop can be; else a linear model has the word.
    """
    margins = bench.margins(gains, bench.ensemble.near())
    unstable = sum(not margin.stable for margin in margins)
    if unstable:
        return UNSTABLE + unstable + sum(min(margin.sensitivity, NEAREST) for margin in margins)
    if not margins[0].is_robust:
        return REFUSED + min(margins[0].sensitivity, NEAREST)
    corners = bench.ensemble.corners()
    chosen = [corners[number] for number in plants.corners]
    has_all = len(chosen) == len(corners)
    trials = []
    for number, member in enumerate(chosen):
        trials.append(bench.trial(gains, member, coarse=not has_all))
        if trials[-1].lasted < 1.0:
            return LOST + len(chosen) - number - trials[-1].lasted
    bad = sum(trial.strayed >= 1.0 or trial.hunting > HUNTING for trial in trials)
    stopped = bad if has_all else 0
    measured = _measured(bench, gains, plants)
    nearest = sorted(measured, key=lambda loop: -loop.sensitivity)[plants.spared :]
    return score(trials, nearest or margins).cost + STOPPED * stopped


def _nearness(bench: Workbench, gains: Mapping[str, float], plants: Plants) -> dict[str, float]:
    """Return the greatest sensitivity on each drawn plant by its number; empty: none is known."""
    return {
        str(number): min(loop.sensitivity, NEAREST) if loop.stable else NEAREST
        for number, loop in zip(plants.drawn, _measured(bench, gains, plants), strict=False)
    }


def _measured(bench: Workbench, gains: Mapping[str, float], plants: Plants) -> list[ClosedLoop]:
    drawn = [bench.ensemble.drawn(number) for number in plants.drawn]
    return bench.measured(gains, drawn) or []
