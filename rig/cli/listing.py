"""`rig list`: rigs, experiments and runs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from rig.cli.names import MANIFEST, RUNS, configs_option, json_option, list_runs
from rig.cli.tables import Table, print_data, print_tables


@click.command()
@click.argument("what", type=click.Choice(["rigs", "experiments", "runs"]), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=RUNS,
    show_default=True,
    help="Where run folders live.",
)
@configs_option
@json_option
def listing(what: str | None, out: Path, configs: Path | None, as_json: bool) -> int:
    """List rigs, experiments and runs, the newest run first; default: all three."""
    made: dict[str, list[dict[str, Any]]] = {}
    if what != "runs":
        from rig.config.names import find_configs

        search = find_configs(configs)
        if what != "experiments":
            made["rigs"] = list_configs("rigs", search)
        if what != "rigs":
            made["experiments"] = list_configs("experiments", search)
    if what in (None, "runs"):
        made["runs"] = [describe_run(path) for path in list_runs(out)]
    if as_json:
        print_data(json.dumps(made if what is None else made[what], indent=2))
        return 0
    print_tables([_table(kind, entries) for kind, entries in made.items()])
    for kind, entries in made.items():
        if not entries:
            click.echo(f"no {kind}" + (f" in {out}" if kind == "runs" else ""), err=True)
    return 0


def list_configs(folder: Any, search: Sequence[Path]) -> list[dict[str, Any]]:
    """Return name, description and file of every rig or experiment, valid or not."""
    from rig.config.names import list_files

    return [
        {"name": name, "description": _description(path), "file": str(path)}
        for name, path in list_files(folder, search).items()
    ]


def describe_run(path: Path) -> dict[str, Any]:
    """Return what a list says of a run; one whose process died is marked crashed."""
    entry: dict[str, Any] = {"name": path.name, "path": str(path)}
    manifest = _read_object(path / MANIFEST)
    if manifest.get("status") == "running":
        from rig.hal import RigError
        from rig.run_folder import RunFolder  # slow to import; only a live or dead run needs it

        try:
            manifest = RunFolder.open(path).manifest
        except RigError:
            manifest = {}
    for key in ("status", "experiment", "backend", "started"):
        value = manifest.get(key)
        entry[key] = value if isinstance(value, str) else None
    entry["status"] = entry["status"] or "unreadable"
    entry["metric"] = _headline(_read_object(path / "metrics.json"))
    return entry


def _headline(content: dict[str, Any]) -> dict[str, Any] | None:
    """Return the first metric that missed its bound, else the first with one, else the first."""
    found = content.get("metrics")
    metrics = [m for m in found if isinstance(m, dict)] if isinstance(found, list) else []
    for wanted in (False, True, None):
        for metric in metrics:
            if metric.get("pass") is wanted:
                return metric
    return None


def _read_object(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _description(path: Path) -> str:
    import yaml

    try:
        with path.open("rb") as stream:
            content = yaml.load(stream, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, ValueError, yaml.YAMLError):
        return f"cannot be read; see `rig check {path}`"
    text = content.get("description", "") if isinstance(content, dict) else ""
    return " ".join(str(text).split())


def _table(kind: str, entries: Sequence[dict[str, Any]]) -> Table:
    if kind != "runs":
        rows = [(entry["name"], entry["description"]) for entry in entries]
        return Table(kind, ("name", "description"), rows)
    return Table(
        kind,
        ("run", "status", "backend", "started", "metric"),
        [
            (
                entry["name"],
                entry["status"],
                entry["backend"] or "-",
                (entry["started"] or "-")[:19].replace("T", " "),
                _metric_text(entry["metric"]),
            )
            for entry in entries
        ],
    )


def _metric_text(metric: dict[str, Any] | None) -> str:
    if metric is None:
        return "-"
    from rig.config.formats import format_quantity

    value, unit = metric.get("value"), metric.get("unit") or "1"
    text = "never" if value is None else format_quantity(value, unit)
    verdict = "" if metric.get("pass") is None else " ok" if metric["pass"] else " MISSED"
    return f"{metric.get('name')} {text}{verdict}"
