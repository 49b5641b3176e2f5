"""`rig sweep`: an experiment under many settings, in parallel, resumable."""

from __future__ import annotations

import contextlib
import math
import shutil
import signal
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    OneOf,
    configs_option,
    experiment_argument,
    json_option,
    rig_option,
    set_option,
    uncommissioned_option,
    yes_option,
)
from rig.cli.tables import Table, print_json, print_tables
from rig.terminals import is_terminal

if TYPE_CHECKING:
    from rig.sweeping.data import SweepData
    from rig.sweeping.result import Sweep

_TOLD = {"failed": "missed a bound"}


@click.command()
@experiment_argument
@click.option(
    "--vary", "axes", multiple=True, metavar="A.B=VALUES",
    help="A setting and its values: 1..5:9, '10..50 kPa:5', log:1..100:5, x,y, or drawn together "
    "with other axes: uniform:0..1:50, normal:1+-0.1:50, sobol:0..1:64.",
)  # fmt: skip
@click.option("--seeds", metavar="FIRST:END", help="Seeds of the simulation: 0:20 is 0 to 19.")
@click.option(
    "--on", "backend", type=OneOf(("sim", "virtual", "vcan", "hardware")),
    default=None, help="As for `rig run`; default: virtual.",
)  # fmt: skip
@rig_option
@set_option
@click.option(
    "--workers", type=click.IntRange(1, 1024),
    help="How many processes; default: what the file says, else every core.",
)  # fmt: skip
@click.option("--dask", metavar="ADDRESS", help="A Dask scheduler: tcp://host:8786, or its file.")
@click.option("--stop-when", metavar="'METRIC < BOUND'", help="End with the first such point.")
@click.option("--budget", metavar="TIME", help="Begin no point after 30 min, or '500 points'.")
@click.option("--metric", help="The metric to draw, and to be best in; default: the first.")
@click.option("--keep", metavar="K|all", help="Logs of the best K, 3; failures' always.")
@click.option("--draw-seed", type=int, default=None, help="Of axes that are drawn.")
@click.option("--serial", is_flag=True, help="One after the other on one rig, hardware too.")
@click.option("--cool-down", metavar="TIME", help="With --serial: rest between two points.")
@click.option(
    "--out", type=click.Path(path_type=Path),
    help="The sweep's folder; default: sweeps/EXPERIMENT-BACKEND among the runs.",
)  # fmt: skip
@click.option(
    "--runs", type=click.Path(path_type=Path), help="Where run folders live; default: runs."
)
@configs_option
@json_option
@uncommissioned_option
@yes_option
def sweep(
    experiment: str,
    axes: tuple[str, ...],
    seeds: str | None,
    backend: str | None,
    rig_name: str | None,
    overrides: tuple[str, ...],
    workers: int | None,
    dask: str | None,
    stop_when: str | None,
    budget: str | None,
    metric: str | None,
    keep: str | None,
    draw_seed: int | None,
    serial: bool,
    cool_down: str | None,
    out: Path | None,
    runs: Path | None,
    configs: Path | None,
    as_json: bool,
    uncommissioned: str | None,
    yes: str | None,
) -> int:
    """Run EXPERIMENT under many settings; leave a table, a figure and a page.

    EXPERIMENT is a name from `rig list`, the path of an experiment, or of a sweep file. What is
    finished is never run again: the same command goes on after an interruption, and with another
    value on an axis only what is new is run.
    """
    from rig.cli.announce import may_move
    from rig.experiment.plan import load_plan
    from rig.sweeping.axis import parse_axis, parse_seeds
    from rig.sweeping.design import make_design
    from rig.sweeping.progress import SweepProgress
    from rig.sweeping.request import SweepRequest
    from rig.sweeping.run import run_sweep
    from rig.sweeping.stop_rule import parse_budget, parse_duration, parse_stop_rule
    from rig.sweeping.sweep_file import is_sweep_file, load_sweep, parse_keep

    file = load_sweep(Path(experiment)) if is_sweep_file(experiment) else SweepRequest(experiment)
    if runs is not None and out is not None:
        raise click.UsageError(
            "--out is the sweep's folder, --runs where it lies: give one of them"
        )
    # What the command line says goes before what the file says.
    file = file if runs is None else replace(file, out=None)
    said: dict[str, object] = {
        "on": backend,
        "rig": rig_name,
        "configs": configs,
        "workers": workers,
        "dask": dask,
        "out": out,
        "runs": runs,
        "best": metric,
        "draw_seed": draw_seed,
        "seeds": seeds and parse_seeds(seeds),
        "stop_when": stop_when and parse_stop_rule(stop_when),
        "keep": keep and parse_keep(keep),
        "cool_down": cool_down and parse_duration(cool_down),
    }
    if budget:
        said["seconds"], said["points"] = parse_budget(budget)
    request = replace(
        file,
        **{name: value for name, value in said.items() if value is not None},  # type: ignore[arg-type]
        axes=(*file.axes, *map(parse_axis, axes)),
        options=(*file.options, *overrides),
        serial=serial,
        uncommissioned=uncommissioned,
    ).checked()
    if request.serial:
        first = make_design(request.axes, request.seeds, request.draw_seed).options(0)
        options = (*request.options, *first)
        plan = load_plan(request.experiment, options, rig=request.rig, configs=request.configs)
        if not may_move(plan, request.on, yes, uncommissioned):
            return 2
    with _ended_as_interrupted():
        found = run_sweep(request, SweepProgress)
    if as_json:
        print_json(found.table)
    else:
        show(found, request.best)
    return 130 if found.end == "interrupted" else 0


@contextlib.contextmanager
def _ended_as_interrupted() -> Iterator[None]:
    """Take SIGTERM, by which batch systems end a job, for Ctrl-C: the table is written."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are not ours
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def show(found: Sweep, metric: str | None) -> None:
    """Print the best points or the table of variations, and where all of them are on stderr."""
    from rig.sweeping.best_points import best_points, fitting
    from rig.sweeping.run import LOGS
    from rig.sweeping.variations import VARIATION

    data = found.data
    counts = {status: data.statuses.count(status) for status in dict.fromkeys(data.statuses)}
    if data.metrics:
        name, _ = data.metric(metric)
        if VARIATION in data.settings:
            print_tables(_of_variations(data, name))
        else:
            header, rows = best_points(data, metric)
            shown, rows = fitting(header, rows, name, _room())
            print_tables([Table(f"best in {name}", shown, rows)])
            if len(shown) < len(header):
                click.echo(f"{len(header) - len(shown)} more metrics: {found.folder}", err=True)
            if (first := data.order(metric)[:1]) and data.missed[first[0]]:
                click.echo("no point kept all of its bounds: none of them is good", err=True)
            runs = (found.folder / LOGS / data.points[number] for number in data.order(metric))
            kept = next((run for run in runs if run.is_dir()), None)
            if kept is not None:
                click.echo(f"the best run that is kept: {kept}", err=True)
    told = ", ".join(f"{count} {_TOLD.get(status, status)}" for status, count in counts.items())
    click.echo(f"{len(data.points)} of {found.total} points: {told or 'none'}", err=True)
    click.echo(_where(found), err=True)


def _where(found: Sweep) -> str:
    """Return how it ended, and which files have what it found."""
    from rig.sweeping.page import PAGE
    from rig.sweeping.result import SweepEnd
    from rig.sweeping.table import CSV

    if found.end is SweepEnd.INTERRUPTED:
        return (
            f"interrupted: what is finished is kept in {found.folder / CSV}; the same command goes "
            "on from there, and draws the figure"
        )
    page = f", {PAGE}" if (found.folder / PAGE).is_file() else ""
    return f"{found.end}: {found.folder / CSV}{page}"


def _room() -> float:
    """Return how many characters a line on stdout may have: any number in a file or pipe."""
    return shutil.get_terminal_size().columns if is_terminal(sys.stdout) else math.inf


def _of_variations(data: SweepData, metric: str) -> list[Table]:
    from rig.sweeping.variation_table import table_of
    from rig.sweeping.variations import VARIATION

    table = table_of(data, metric)
    header = (VARIATION, *(law or metric for law in table.laws))
    return [
        Table(metric, header, table.texts()),
        Table("what stopped them, one of each", ("fault", "said"), list(table.faults().items())),
    ]
