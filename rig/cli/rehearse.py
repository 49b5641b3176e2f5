"""A run gone through in simulation, to be laid under the one that is watched."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rig.experiment.plan import Plan


def gone_through(plan: Plan, out: Path) -> Path | None:
    """Go through a whole plan on `sim` and leave a run folder; None: it ended in a fault.

    Parameters
    ----------
    plan : Plan
        Of its own: its controller is used up.
    out : Path
        Where the folder is made.

    Raises
    ------
    KeyboardInterrupt
        Somebody has interrupted it.
    """
    from dataclasses import replace

    from rig.assembly import Backend
    from rig.cli.progress import ProgressLine
    from rig.experiment.ending import EXIT_INTERRUPTED
    from rig.experiment.run import run_experiment
    from rig.run_facts import RunStatus

    profile = plan.profile
    healthy = replace(profile, simulation=replace(profile.simulation, faults=()))
    plan = plan._replace(profile=healthy)
    line = ProgressLine(f"rehearsal of {plan.experiment.name}", Backend.SIM.value)
    with line:
        result = run_experiment(plan, Backend.SIM, out, watcher=line, report=False)
    if result.exit_code == EXIT_INTERRUPTED:
        raise KeyboardInterrupt
    if result.status is RunStatus.FAULTED:
        click.echo(f"in rehearsal: {result.message}", err=True)
        return None
    return result.path


def gone_through_again(run: Path, out: Path) -> Path | None:
    """Go through the run of a folder on `sim`; see `gone_through`."""
    from rig.replaying.rerun import Repeat

    return gone_through(Repeat(run).plan, out)
