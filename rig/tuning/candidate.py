"""One candidate of a search, judged where a worker is."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from rig.sweeping.finding import MetricCell, PointFinding, one_line
from rig.sweeping.point import PointJob
from rig.sweeping.source import PointSource
from rig.tuning.score import LOST, NEAREST, REFUSED, STOPPED, UNSTABLE, score
from rig.tuning.workbench import Workbench, workbench_of

PERFORM = "rig.tuning.candidate:perform"

_SHAKEN = 3
"""Plants on which margins are measured, two units of each: the greatest counts."""
_OF_MORE = 1.04
"""Times the greatest sensitivity of those few: 200 drawn plants have greater ones. Gains that kept
the bound on these few kept it on 95.5 % of 200."""


def job_of(
    text: str,
    gains: Mapping[str, float],
    members: Sequence[int],
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
    members : sequence of int
        Of the ensemble's corners: on these.
    code, folder, name
        Of the code, of the search, and of this candidate.
    """
    options = (text, json.dumps(gains), json.dumps(list(members)))
    return PointJob(name, PointSource("", (), None, "", code), options, folder, folder)


def perform(job: PointJob) -> PointFinding:
    """Judge a candidate; return its cost."""
    text, gains, members = job.options
    try:
        cost = cost_of(workbench_of(text), json.loads(gains), json.loads(members))
    except ValueError as error:  # the law refuses these gains
        return PointFinding(
            point=job.name, status="refused", reason=one_line(str(error)), metrics=[]
        )
    cell = MetricCell(name="cost", value=cost, unit="", bound=None, kind=None)
    return PointFinding(point=job.name, status="ok", reason="", metrics=[cell])


def cost_of(bench: Workbench, gains: Mapping[str, float], members: Sequence[int]) -> float:
    """Return what gains cost on some corners of the ensemble.

    No time is spent on those that are not stable, or that hardware is refused with on the plant as
    told, nor on more plants than one that is lost. Where all corners are asked for, each that the
    program would be stopped on costs `STOPPED`: nobody has calibrated those, so a stop is no
    hazard, and no margin is given for it. Margins are measured, where a loop can be, on those
    plants whose loops are nearest to instability as a linear model says.
    """
    near = bench.ensemble.near()
    margins = bench.margins(gains, near)
    unstable = sum(not margin.stable for margin in margins)
    if unstable:
        return UNSTABLE + unstable + sum(min(margin.sensitivity, NEAREST) for margin in margins)
    if not margins[0].is_robust:
        return REFUSED + min(margins[0].sensitivity, NEAREST)
    corners = bench.ensemble.corners()
    chosen = [corners[number] for number in members]
    trials = []
    for number, member in enumerate(chosen):
        trials.append(bench.trial(gains, member, coarse=True))
        if trials[-1].lasted < 1.0:
            return LOST + len(chosen) - number - trials[-1].lasted
    stopped = sum(trial.strayed >= 1.0 for trial in trials) if len(chosen) == len(corners) else 0
    nearest = sorted(zip(margins, near, strict=True), key=lambda pair: -pair[0].sensitivity)
    shaken = bench.ensemble.other_units([member for _, member in nearest[:_SHAKEN]])
    measured = bench.measured(gains, shaken)
    if measured is not None:
        measured = [loop._replace(sensitivity=_OF_MORE * loop.sensitivity) for loop in measured]
    return score(trials, measured or margins).cost + STOPPED * stopped
