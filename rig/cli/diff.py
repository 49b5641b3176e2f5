"""`rig diff`: two runs beside each other."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import json_option, run_argument, runs_option
from rig.cli.tables import Table, print_data, print_json, print_tables
from rig.run_names import find_run

if TYPE_CHECKING:
    from rig.replaying.difference import MetricChange, TimeChange
    from rig.run_folder import RunFolder


@click.command()
@run_argument("first")
@run_argument("second")
@runs_option
@json_option
def diff(first: str, second: str, runs: Path, as_json: bool) -> int:
    """Show what two runs differ in: profile, code, metrics, and the first cycle that differs.

    Whether chance explains a metric's difference is told from the runs beside the first one that
    differ from it in nothing but their seed. How long their cycles took is shown beside, by stage
    (stage `control` is the law). It exits with 0 if all else is the same, else with 1.
    """
    from rig.run_folder import RunFolder

    one, other = (RunFolder.open(find_run(name, runs)) for name in (first, second))
    return show(one, other, as_json=as_json, timed=True)


def show(one: RunFolder, other: RunFolder, *, as_json: bool = False, timed: bool = False) -> int:
    """Print what two runs differ in; return 0 if it is nothing.

    Parameters
    ----------
    one, other : RunFolder
        The runs.
    as_json : bool
        Print it as JSON.
    timed : bool
        Also how long their cycles took, which makes no difference: that is the computer's.
    """
    from rig.replaying.difference import (
        differing_code,
        differing_settings,
        first_difference,
        metrics_beside,
        siblings_of,
        times_beside,
    )

    settings, code = differing_settings(one, other), differing_code(one, other)
    metrics = metrics_beside(one, other, siblings_of(one, one.path.resolve().parent))
    header = ("", one.path.name, other.path.name)
    log = first_difference(one, other)
    times = times_beside(one, other) if timed else []
    if as_json:
        content = {
            "settings": [change._asdict() for change in settings],
            "code": [change._asdict() for change in code],
            "metrics": [metric._asdict() for metric in metrics],
            "log": None if log is None else str(log),
        }
        print_json({**content, "timing": [of._asdict() for of in times]} if timed else content)
    else:
        rows = [_row(metric) for metric in metrics]
        print_tables(
            [
                Table("settings that differ", header, settings),
                Table("code and versions that differ", header, code),
                Table("metrics", (*header, "difference", "by chance"), rows),
                Table("time that a cycle takes", header, [_times(of) for of in times]),
            ]
        )
        told = "every cycle of both logs is the same"
        print_data(told if log is None else f"the logs differ first at {log}")
    same = not settings and not code and log is None
    return 0 if same and all(m.by_chance == "the same" for m in metrics) else 1


def _times(of: TimeChange) -> tuple[str, str, str]:
    from rig.hal.formats import format_quantity

    first, second = (format_quantity(value, "s") for value in (of.first, of.second))
    return f"{of.stage}, {of.which}", first, second


def _row(metric: MetricChange) -> tuple[str, ...]:
    from rig.hal.formats import format_quantity

    unit = metric.unit or "1"
    values = (metric.first, metric.second, metric.second - metric.first)
    texts = [format_quantity(v, unit) if math.isfinite(v) else "-" for v in values]
    for k, value in enumerate(values[:2]):
        if math.isinf(value):
            texts[k] = "never"
    chance = metric.by_chance
    if metric.spread is not None:
        chance += f" (σ {format_quantity(metric.spread, unit)})"
    return (metric.name, *texts, chance)
