"""`rig list`: rigs, experiments and runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import compress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from rig.cli.names import OneOf, configs_option, json_option, out_option
from rig.cli.tables import Table, print_json, print_tables, visible
from rig.run_names import list_runs_within

if TYPE_CHECKING:
    from rig.config.names import Folder
    from rig.run_facts import MetricRow


class ConfigEntry(NamedTuple):
    """A rig or an experiment in a list."""

    name: str
    description: str
    file: str


class RunEntry(NamedTuple):
    """A run in a list; None stands for what its manifest does not say."""

    name: str
    path: str
    status: str
    experiment: str | None
    backend: str | None
    started: str | None
    metric: MetricRow | None
    rig: str | None
    law: str | None


@click.command()
@click.argument("what", type=OneOf(["rigs", "experiments", "runs"]), required=False)
@out_option
@configs_option
@json_option
@click.option(
    "--where", metavar="'NAME < VALUE UNIT'",
    help="Only the runs of which this is true: metrics, status, rig, experiment, law, backend or "
    "name, e.g. 'marker_rms < 0.2 mm and rig = joint'.",
)  # fmt: skip
def listing(
    what: str | None, out: Path, configs: Path | None, as_json: bool, where: str | None
) -> int:
    """List rigs, experiments and runs, the newest run first; default: all three."""
    if where is not None and what not in (None, "runs"):
        raise click.UsageError("--where is for runs.")
    what = what if where is None else "runs"
    made: dict[str, Sequence[ConfigEntry] | Sequence[RunEntry]] = {}
    tables: list[Table] = []
    everything: list[RunEntry] = []
    if what != "runs":
        from rig.config.names import find_configs

        search = find_configs(configs)
        folders: tuple[Folder, ...] = ("rigs", "experiments")
        for folder in folders:
            if what in (None, folder):
                made[folder] = found = list_configs(folder, search)
                tables.append(Table(folder, ("name", "description"), [c[:2] for c in found]))
    if what in (None, "runs"):
        everything = [_by_path(path, out) for path in list_runs_within(out)]
        made["runs"] = runs = everything if where is None else _chosen(everything, where)
        header = ("run", "status", "backend", "started", "metric")
        tables.append(Table("runs", header, [_run_row(run) for run in runs]))
    if as_json:
        content = {kind: [entry._asdict() for entry in entries] for kind, entries in made.items()}
        print_json(content if what is None else content[what])
        return 0
    print_tables(tables)
    for kind, entries in made.items():
        if not entries:
            click.echo(_nothing_of(kind, out, where, len(everything)), err=True)
    return 0


def _by_path(path: Path, out: Path) -> RunEntry:
    """Return what a list says of a run, with its path within the folder that is listed."""
    return describe_run(path)._replace(name=str(path.relative_to(out)))


def _nothing_of(kind: str, out: Path, where: str | None, count: int) -> str:
    """Say that there is nothing to list."""
    if kind != "runs":
        return f"no {kind}"
    if not count:
        return f"there are no runs in {out}" + ("" if where is None else ", so --where finds none")
    of_all = "the one run" if count == 1 else f"the {count} runs"
    return f"of {of_all} in {out} none has {where}"


def _chosen(found: Sequence[RunEntry], where: str) -> list[RunEntry]:
    """Return those of the runs that are asked for."""
    from rig.run_query import Candidate, choose, parse_query

    chosen = choose(where, [Candidate(run._asdict(), _values(run)) for run in found])
    asked = [term.name for term in parse_query(where)]
    runs = [_with_metric(run, asked) for run in compress(found, chosen)]
    for run in found:
        if run.status == "unreadable" and run not in runs:
            click.echo(visible(f"{run.name} cannot be read: nothing is known of it"), err=True)
    return runs


def _with_metric(run: RunEntry, asked: Sequence[str]) -> RunEntry:
    """Return a run that shows the first metric that was asked for, if one was."""
    metrics = _metrics(Path(run.path))
    shown = [metric for name in asked for metric in metrics if metric["name"] == name]
    return run._replace(metric=shown[0]) if shown else run


def _values(run: RunEntry) -> dict[str, tuple[float, str]]:
    """Return value and unit of every metric of a run; NaN for one without a value."""
    found = {}
    for metric in _metrics(Path(run.path)):
        value = metric["value"]
        found[metric["name"]] = math.nan if value is None else float(value), metric["unit"]
    return found


def list_configs(folder: Folder, search: Sequence[Path]) -> list[ConfigEntry]:
    """Return name, description and file of every rig or experiment, valid or not."""
    from rig.cli.descriptions import descriptions_of
    from rig.config.names import list_files

    files = list_files(folder, search)
    said = descriptions_of(files.values())
    return [ConfigEntry(name, said[path], str(path)) for name, path in files.items()]


def describe_run(path: Path) -> RunEntry:
    """Return what a list says of a run; one whose process died is marked crashed.

    A folder that cannot be read is unreadable, and keeps no other from being shown.
    """
    from rig.hal import RigError
    from rig.run_facts import RunStatus, read_manifest

    try:
        manifest = read_manifest(path)
        if manifest["status"] == RunStatus.RUNNING:
            from rig.run_folder import RunFolder  # slow to import

            manifest = RunFolder.open(path).manifest
    except RigError:
        return RunEntry(path.name, str(path), "unreadable", *(None,) * 6)
    return RunEntry(
        path.name, str(path), manifest["status"], manifest.get("experiment"),
        manifest.get("backend"), manifest.get("started"), _headline(_metrics(path)),
        manifest.get("rig"), manifest.get("law"),
    )  # fmt: skip


def _metrics(path: Path) -> list[MetricRow]:
    """Return what a run's folder says of its metrics, if it can be read."""
    from rig.hal import ConfigurationError
    from rig.run_facts import read_metrics

    try:
        return read_metrics(path)
    except ConfigurationError:
        return []


def _headline(metrics: Sequence[MetricRow]) -> MetricRow | None:
    """Return the first metric that missed its bound, else the first with one, else the first."""
    for wanted in (False, True, None):
        for metric in metrics:
            if metric.get("pass") is wanted:
                return metric
    return None


def _run_row(run: RunEntry) -> tuple[str, ...]:
    started = (run.started or "-")[:19].replace("T", " ")
    return (run.name, run.status, run.backend or "-", started, _metric_text(run.metric))


def _metric_text(metric: MetricRow | None) -> str:
    if metric is None:
        return "-"
    from rig.hal.formats import format_quantity

    value, unit = metric["value"], metric["unit"] or "1"
    nothing = "NaN" if metric.get("is_nan") else "never"
    text = nothing if value is None else format_quantity(value, unit)
    verdict = "" if metric.get("pass") is None else " ok" if metric["pass"] else " MISSED"
    return f"{metric['name']} {text}{verdict}"
