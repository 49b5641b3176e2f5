"""`rig compare`: one experiment under several controllers, side by side."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rig.cli.names import complete_experiment, complete_rig
from rig.cli.tables import print_data

if TYPE_CHECKING:
    from rig.experiment.run import Result


class _Job(NamedTuple):
    """One run of a comparison, as it can be handed to another process."""

    experiment: str
    options: tuple[str, ...]
    rig: str | None
    configs: Path | None
    backend: str
    out: Path


@click.command()
@click.argument("experiment", shell_complete=complete_experiment)
@click.option(
    "--controllers",
    metavar="A,B,…",
    help="Which controllers; default: all that the rig's profile has settings for.",
)
@click.option(
    "--on", "backend", type=click.Choice(("sim", "virtual", "vcan", "hardware")),
    default="virtual", show_default=True, help="As for `rig run`.",
)  # fmt: skip
@click.option(
    "--rig", "rig_name", metavar="PROFILE", shell_complete=complete_rig,
    help="Another rig than the experiment's.",
)  # fmt: skip
@click.option("--set", "overrides", multiple=True, metavar="A.B=C", help="Override a setting.")
@click.option("--seed", type=int, help="Seed of the simulation; short for simulation.seed.")
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("runs"), show_default=True,
    help="Where run folders live.",
)  # fmt: skip
@click.option("--configs", type=click.Path(path_type=Path), help="Folder of configurations.")
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
def compare(
    experiment: str,
    controllers: str | None,
    backend: str,
    rig_name: str | None,
    overrides: tuple[str, ...],
    seed: int | None,
    out: Path,
    configs: Path | None,
    as_json: bool,
) -> int:
    """Run EXPERIMENT once under each controller; one table, one figure.

    Simulated runs go on at the same time, one per processor; a physical rig takes them one
    after the other.
    """
    from rig.experiment.plan import load_plan
    from rig.report.compare import compare_metrics, draw_comparison

    options = list(overrides)
    if seed is not None:
        options.append(f"simulation.seed={seed}")
    plan = load_plan(experiment, options, rig=rig_name, configs=configs)
    names = _chosen(controllers, tuple(plan.profile.controllers))
    jobs = [
        _Job(experiment, (*options, f"controller={name}"), rig_name, configs, backend, out)
        for name in names
    ]
    for job in jobs:  # all of it is valid before any of it moves
        load_plan(experiment, job.options, rig=rig_name, configs=configs)
    results = _run_all(jobs, names, backend)
    finished = [
        (name, result) for name, result in zip(names, results, strict=True) if result.metrics
    ]
    for name, result in zip(names, results, strict=True):
        if result.message is not None:
            click.echo(f"{name}: {result.status}: {result.message}", err=True)
    if finished:
        paths = [result.path for _, result in finished]
        labels = [name for name, _ in finished]
        folder = _comparison_folder(out, plan.experiment.name, backend)
        rows = compare_metrics(paths, labels)
        content = {"labels": labels, "runs": [str(path) for path in paths], "metrics": rows}
        (folder / "compare.json").write_text(json.dumps(content, indent=2) + "\n")
        draw_comparison(paths, labels, folder)
        if as_json:
            print_data(json.dumps(content, indent=2))
        else:
            _print_table(labels, rows)
        click.echo(f"figure: {folder / 'compare.png'}", err=True)
    # A bound that one of them misses is a finding of the comparison, not its failure.
    return max((result.exit_code for result in results if result.exit_code > 1), default=0)


def _chosen(text: str | None, known: Sequence[str]) -> tuple[str, ...]:
    import difflib

    from rig.hal import ConfigurationError

    if text is None:
        return tuple(known)
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
            raise ConfigurationError(f"--controllers: no controller {name!r}; {hint}")
    if not names:
        raise ConfigurationError("--controllers names none")
    return names


def _run_all(jobs: Sequence[_Job], names: Sequence[str], backend: str) -> list[Result]:
    if backend not in ("sim", "virtual"):
        return [_run(job, watched=True) for job in jobs]
    import os
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    workers = min(len(jobs), os.cpu_count() or 1)
    results: list[Result] = []
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(_run, job) for job in jobs]
        for name, future in zip(names, futures, strict=True):
            results.append(future.result())
            click.echo(f"{name}: {results[-1].path}", err=True)
    return results


def _run(job: _Job, *, watched: bool = False) -> Result:
    from rig.assembly import Backend
    from rig.cli.progress import ProgressLine
    from rig.experiment.plan import load_plan
    from rig.experiment.run import run_experiment

    plan = load_plan(job.experiment, job.options, rig=job.rig, configs=job.configs)
    backend = Backend(job.backend)
    if not watched:
        return run_experiment(plan, backend, job.out, overrides=job.options)
    with ProgressLine(plan.experiment.controller, job.backend) as line:
        return run_experiment(plan, backend, job.out, overrides=job.options, watcher=line)


def _comparison_folder(out: Path, experiment: str, backend: str) -> Path:
    from datetime import UTC, datetime

    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H%M%SZ")
    folder = out / f"{stamp}-{experiment}-{backend}-compare"
    folder.mkdir(parents=True)
    return folder


def _print_table(labels: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    from rig.config.quantities import format_quantity

    cells = [["", *labels]]
    for row in rows:
        values = [
            "-" if value is None else format_quantity(value, row["unit"] or "1")
            for value in row["values"]
        ]
        cells.append([row["name"], *values])
    widths = [max(len(line[column]) for line in cells) for column in range(len(cells[0]))]
    lines = []
    for line in cells:
        texts = [line[0].ljust(widths[0])]
        texts += [text.rjust(width) for text, width in zip(line[1:], widths[1:], strict=True)]
        lines.append("  ".join(texts).rstrip())
    print_data("\n".join(lines))
