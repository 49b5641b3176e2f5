"""`rig faults`: what becomes of a rig when something breaks."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import configs_option, json_option
from rig.cli.tables import Table, print_data, print_tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rig.faults.verdict import Verdict

CAMPAIGNS = Path("faults")
SUBSET, FULL = 1, 15
"""How often each fault is drawn on each rig, and with ``--full``."""


@click.group()
def faults() -> None:
    """Break a rig in simulation, and judge it by what is true of it.

    Every case runs the program as it is on `--on virtual`. What judges it is the plant's truth
    until 1.5 s after the program has ended or died, not what the program says of itself.
    """


@faults.command("list")
@click.argument("rig")
@configs_option
@json_option
def list_kinds(rig: str, configs: Path | None, as_json: bool) -> int:
    """Say what can break on RIG, where, and what must come of it."""
    from rig.faults.catalogue import kinds_for
    from rig.faults.survey import experiments_of, survey

    subject = survey(rig, experiments_of(rig, configs)[:1], configs)
    rows = [
        (name, kind.what, ", ".join(place.where for place in kind.places(subject)), kind.why)
        for name, kind in kinds_for(subject).items()
    ]
    header = ("fault", "what", "where", "why it may go unseen")
    if as_json:
        print_data(json.dumps([dict(zip(header, row, strict=True)) for row in rows], indent=2))
    else:
        print_tables([Table(f"faults of {rig}", header, rows)])
    return 0


@faults.command("run")
@click.argument("rigs", nargs=-1)
@click.option("--full", is_flag=True, help=f"Every fault {FULL} times on each rig.")
@click.option(
    "--random", "count", type=click.IntRange(1), help="So many cases, two faults in some."
)
@click.option("--only", help="This fault alone, or two as in a+b; `rig faults list` has the names.")
@click.option("--experiment", "experiments", multiple=True, help="Break it in this one only.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@click.option("--workers", type=click.IntRange(1), default=os.cpu_count() or 1, show_default=True)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=CAMPAIGNS,
    show_default=True,
    help="Where the campaign and its failures are kept.",
)
@configs_option
@json_option
def run(
    rigs: tuple[str, ...],
    full: bool,
    count: int | None,
    only: str | None,
    experiments: tuple[str, ...],
    seed: int,
    workers: int,
    out: Path,
    configs: Path | None,
    as_json: bool,
) -> int:
    """Break RIGS (default: cylinder, joint, arm, legs); exit 1 if anybody might have been hurt."""
    from rig.faults.campaign import draw_each, draw_once, draw_random, run_cases
    from rig.faults.survey import experiments_of, survey

    jobs = []
    for name in rigs or ("cylinder", "joint", "arm", "legs"):
        click.echo(f"{name}: looking at what it has …", err=True)
        subject = survey(name, experiments or experiments_of(name, configs), configs)
        if only is not None:
            cases = draw_once(subject, tuple(only.split("+")), seed, count or 1)
        elif count is not None:
            cases = draw_random(subject, seed, count)
        else:
            cases = draw_each(subject, seed, FULL if full else SUBSET)
        jobs += [(case, subject) for case in cases]
    done: list[Verdict] = []

    def progressed(verdict: Verdict) -> None:
        done.append(verdict)
        if verdict.failed:
            for wrong in verdict.wrongs():
                click.echo(f"  {wrong}\n    {verdict.case.command}", err=True)
        if len(done) % 25 == 0:
            click.echo(f"{len(done)} of {len(jobs)} cases", err=True)

    verdicts = run_cases(jobs, out / f"seed-{seed}", configs, workers, progressed)
    if as_json:
        print_data(json.dumps([verdict.as_json() for verdict in verdicts], indent=2))
    else:
        _show(verdicts)
    return 1 if any(verdict.hazard or verdict.crashed for verdict in verdicts) else 0


def _show(verdicts: Sequence[Verdict]) -> None:
    from rig.faults.table import HEADER, make_row, make_rows

    rows = make_rows(verdicts)
    rows.append(make_row("all", "", verdicts))
    print_tables([Table("faults", HEADER, [row.cells() for row in rows])])
