"""Runs of the joint in which something breaks, and when that was noticed."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

from rig.assembly import build_rig
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
AT = 2.0
"""When things break, s on the rig's clock: in the middle of the circle."""


class Broken(NamedTuple):
    """A run that something ended."""

    result: object
    log: object
    """None if the loop never ran."""
    events: list
    after: float
    """How long it took to be noticed, s; of what was wrong from the start: into the run."""


def options(faults, more=()):
    listed = ", ".join(
        f"{{at: {at}, device: {device}, fault: {fault}"
        + ("}" if value is None else f", value: {value}}}")
        for at, device, fault, value in faults
    )
    return [
        "reference.tones=[{frequency: 0.5 Hz, laps: 1}]",
        "approach=0.5 s",
        "metrics={}",
        "figures=[]",
        f"simulation.faults=[{listed}]",
        *more,
    ]


@cache
def start_of(backend):
    """Return the rig's time when the loop begins, s: connecting takes some of it."""
    rig = build_rig(load_plan("joint-ideal-circle", options(()), configs=CONFIGS).profile, backend)
    with rig:
        rig.arm()
        return rig.clock.now()


def run(folder, backend, faults, more=()):
    plan = load_plan("joint-ideal-circle", options(faults, more), configs=CONFIGS)
    result = run_experiment(plan, backend, folder, report=False)
    opened = RunFolder.open(result.path)
    log = read_log(opened.log_path) if opened.log_path.exists() else None
    last = float(log.t[-1]) if log is not None else 0.0
    at = max((fault[0] for fault in faults), default=0.0)
    after = last + start_of(backend) - at if at > 0.0 else last
    return Broken(result, log, opened.events(), after)
