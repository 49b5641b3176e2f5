"""`rig compare`: one experiment under several controllers or settings, side by side."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.compared_runs import INTERRUPTED, Job, run_all
from rig.cli.names import (
    OneOf,
    configs_option,
    experiment_argument,
    json_option,
    out_option,
    rig_option,
    seed_option,
    set_option,
    uncommissioned_option,
    with_seed,
    yes_option,
)  # fmt: skip
from rig.cli.patience import told_if_long
from rig.cli.tables import print_data, print_json

if TYPE_CHECKING:
    from rig.cli.compared_runs import Ended
    from rig.hal.closed_loop import ClosedLoop


@click.command()
@experiment_argument
@click.option(
    "--controllers",
    metavar="A,B,…",
    help="Which controllers; default: all that the rig's profile has settings for, or with "
    "--vary the experiment's.",
)
@click.option(
    "--vary",
    metavar="A.B=C,D,…",
    help="A setting and the values that it takes in turn.",
)
@click.option(
    "--on", "backend", type=OneOf(("sim", "virtual", "vcan", "hardware")),
    default="virtual", show_default=True, help="As for `rig run`.",
)  # fmt: skip
@rig_option
@set_option
@seed_option
@out_option
@configs_option
@json_option
@uncommissioned_option
@yes_option
def compare(
    experiment: str,
    controllers: str | None,
    vary: str | None,
    backend: str,
    rig_name: str | None,
    overrides: tuple[str, ...],
    seed: int | None,
    out: Path,
    configs: Path | None,
    as_json: bool,
    uncommissioned: str | None,
    yes: str | None,
) -> int:
    """Run EXPERIMENT once under each controller or setting; one table, one figure.

    A controller that refuses the motion is told, with its reason. Simulated runs go on at the same
    time, one per processor; a physical rig takes them one after the other. Ctrl-C ends all of it,
    and the table has the runs that were done.
    """
    from rig.cli.announce import may_move
    from rig.cli.compared_table import saying_never, table_lines
    from rig.experiment.plan import load_plan
    from rig.hal.files import check_writable
    from rig.installation import need
    from rig.report.compare import compare_metrics, draw_comparison

    need("matplotlib")
    check_writable(out, "run folders")
    options = with_seed(overrides, seed)
    with told_if_long("planning the motion"):
        plan = load_plan(experiment, options, rig=rig_name, configs=configs)
    if not may_move(plan, backend, yes, uncommissioned):
        return 2
    names: tuple[str, ...] = (plan.experiment.controller,)
    if controllers is not None or vary is None:
        names = _chosen(controllers, tuple(plan.profile.controllers))
    asked = [
        Job(
            label,
            experiment,
            (*options, *own),
            rig_name,
            configs,
            backend,
            out,
            uncommissioned=uncommissioned,
        )
        for label, own in _variants(names, vary)
    ]
    with told_if_long("planning it under each of them"):
        jobs, refused = _permitted(asked)
    ended, interrupted = run_all(jobs, backend)
    results = {job.label: ended[job.label] for job in jobs if job.label in ended}
    for label, result in results.items():
        if result.message is not None:
            click.echo(f"{label}: {result.status}: {result.message}", err=True)
    if interrupted:
        click.echo(f"interrupted: {len(results)} of {len(jobs)} runs were done", err=True)
    finished = {label: result for label, result in results.items() if result.is_measured}
    if finished:
        labels, paths = list(finished), [result.path for result in finished.values()]
        folder = _comparison_folder(out, plan.experiment.name, backend)
        rows = compare_metrics(paths, labels)
        broken = {label: r.message or "" for label, r in results.items() if not r.is_measured}
        for row in rows:
            row["values"] += [None] * len(broken) + [row.get("refused")] * len(refused)
        columns = [*labels, *broken, *refused]
        content = {
            "labels": columns,
            "runs": [str(path) for path in paths],
            "metrics": rows,
            "faulted": broken,
            "refused": refused,
        }
        (folder / "compare.json").write_text(json.dumps(content, indent=2) + "\n")
        endings = {label: _ending(result) for label, result in results.items()}
        endings |= dict.fromkeys(refused, "refused")
        if not interrupted:
            absent = {label: endings[label] for label in (*broken, *refused)}
            draw_comparison(paths, labels, folder, absent)
        margins = {job.label: job.loop for job in jobs if job.loop and job.label in labels}
        if as_json:
            print_json({**content, "loops": margins})
        else:
            told = saying_never(rows, paths)
            print_data("\n".join(table_lines(columns, told, endings, margins)))
            _say_missed({label: result.path for label, result in finished.items()})
        kept = "compare.json" if interrupted else "compare.png"
        click.echo(f"{'table' if interrupted else 'figure'}: {folder / kept}", err=True)
    if interrupted:
        return INTERRUPTED
    # A bound that one of them misses is a finding of the comparison, not its failure.
    return max((result.exit_code for result in results.values() if result.exit_code > 1), default=0)


def _ending(result: Ended) -> str:
    """Return a run's status, or what came of it where that would not say it."""
    from rig.run_facts import ending_word

    return ending_word(result.status, is_flawed=result.message is not None)


def _say_missed(runs: Mapping[str, Path]) -> None:
    """Say which bounds each run missed: the table need not have a row for all of them."""
    from rig.explaining.ended_run import missed_bounds

    for label, path in runs.items():
        missed = "; ".join(said for _, said in missed_bounds(path))
        if missed:
            click.echo(f"{label}: bound missed: {missed}", err=True)


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


def _variants(names: Sequence[str], vary: str | None) -> list[tuple[str, tuple[str, ...]]]:
    """Return label and options of each run: every controller with every value."""
    from rig.config.setting import Setting
    from rig.hal import ConfigurationError

    laws = {name: Setting(f"controller={name}", f"--controllers {name}") for name in names}
    if vary is None:
        return [(name, (law,)) for name, law in laws.items()]
    key, equals, text = vary.partition("=")
    values = [value.strip() for value in text.split(",") if value.strip()]
    if not equals or not key.strip() or len(values) < 2:
        raise ConfigurationError(
            f"--vary {vary}: expected a setting and at least two values, "
            "as in plant.seals=standard,low-speed"
        )
    short = key.strip().rpartition(".")[2]
    return [
        (
            f"{name}, {short} {value}" if len(names) > 1 else f"{short} {value}",
            (law, Setting(f"{key.strip()}={value}", f"--vary {key.strip()}={value}")),
        )
        for name, law in laws.items()
        for value in values
    ]


def _permitted(jobs: Sequence[Job]) -> tuple[list[Job], dict[str, str]]:
    """Return the jobs whose motion is possible, before any of them moves; and why others are not.

    Raises
    ------
    ConfigurationError
        A file or option is wrong, or no job is possible.
    """
    from rig.config import ProfileError
    from rig.experiment.loop_margins import loop_of
    from rig.experiment.plan import load_plan
    from rig.hal import MotionRefused

    permitted = []
    refused: dict[str, str] = {}
    last: MotionRefused | None = None
    for job in jobs:
        try:
            plan = load_plan(job.experiment, job.options, rig=job.rig, configs=job.configs)
        except ProfileError:
            raise
        except MotionRefused as error:
            last = error
            refused[job.label] = str(error)
            click.echo(f"{job.label}: refused: {error}", err=True)
        else:
            loop = loop_of(plan.profile, plan.controller)
            permitted.append(job._replace(loop="" if loop is None else _margin(loop)))
    if not permitted and last is not None:
        raise last
    return permitted, refused


def _margin(loop: ClosedLoop) -> str:
    """Return what a linear model says of a loop, in a word or two."""
    if not loop.stable:
        return "by friction only"
    return "stable" if loop.is_robust else f"sensitivity {loop.sensitivity:.2g}"


def _comparison_folder(out: Path, experiment: str, backend: str) -> Path:
    from datetime import UTC, datetime

    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H%M%SZ")
    folder = out / f"{stamp}-{experiment}-{backend}-compare"
    folder.mkdir(parents=True)
    return folder
