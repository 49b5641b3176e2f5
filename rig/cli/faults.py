"""`rig faults`: what becomes of a rig when something breaks."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import OneOf, complete_rig, configs_option, json_option, workers_option
from rig.cli.number_option import NumberWithin
from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rig.faults.campaign import Job
    from rig.faults.kind import FaultKind, Place
    from rig.faults.quiet import QuietRun
    from rig.faults.subject import Subject
    from rig.faults.table import Row
    from rig.faults.verdict import Verdict

CAMPAIGNS = Path("faults")
_FEW = 12
"""So many cases are shown one by one, with what the rig said."""
RIGS = ("cylinder", "joint", "arm", "arm-odrive", "legs", "legs-can")
FULL = 6
"""How often each fault is drawn on each rig with ``--full``."""


@click.group()
def faults() -> None:
    """Break a rig in simulation, and judge it by what is true of it.

    Every case runs the program as it is, on emulated devices in virtual time. What judges it is
    the plant's truth until 1.5 s after the program has ended or died, not what the program says.
    """
    # Cases are copies of a running process, and threads do not survive that.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")


@faults.command("list")
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--experiment", metavar="NAME|FILE", help="Look at it in this one; default: one of the rig's."
)
@configs_option
@json_option
def list_kinds(rig: str, experiment: str | None, configs: Path | None, as_json: bool) -> int:
    """Say what can break on RIG, where and how much, and as what in a profile; and what cannot.

    `rig explain FAULT` says why one may go unseen; --json has it for all.
    """
    from rig.faults.catalogue import kind_named, kinds_for, refused_for
    from rig.faults.survey import experiments_of, survey

    found = (experiment,) if experiment else experiments_of(rig, configs, any_world=True)
    subject = survey(rig, found[:1], configs)
    header = ("fault", "what", "where", "magnitude", "in simulation.faults", "why it may go unseen")
    rows = [
        (
            name,
            kind.what,
            ", ".join(place.where for place in kind.places(subject)),
            "" if kind.magnitude is None else str(kind.magnitude),
            _as_setting(kind, kind.places(subject)),
            kind.why,
        )
        for name, kind in kinds_for(subject).items()
    ]
    if as_json:
        print_json([dict(zip(header, row, strict=True)) for row in rows])
    else:
        refused = [
            (name, kind_named(name).what, needs) for name, needs in refused_for(subject).items()
        ]
        lacking = Table(f"refused on {rig}", ("fault", "what", "it would need"), refused)
        what = [(name, said, where, size or "none") for name, said, where, size, _, _ in rows]
        settings = [(name, setting) for name, *_, setting, _ in rows if setting]
        as_settings = Table("in simulation.faults", ("fault", "setting"), settings)
        print_tables([Table(f"faults of {rig}", header[:4], what), as_settings, lacking])
    return 0


def _as_setting(kind: FaultKind, places: Sequence[Place]) -> str:
    """Return what a profile calls a fault, of the first of its places, and what numbers mean."""
    from rig.faults.world_kinds import in_simulation

    setting = in_simulation(kind, places[0]) if places else None
    if setting is None:
        return ""
    of = [place for place in places if place.target == places[0].target]
    numbers = [f"{p.number:g} {p.names[0]}" for p in of if p.number is not None]
    return f"{setting}  # value: {', '.join(numbers)}" if numbers else setting


@faults.command("run")
@click.argument("rigs", nargs=-1, metavar="[RIG|FILE]...")
@click.option("--full", is_flag=True, help=f"Every fault {FULL} times on each rig.")
@click.option(
    "--random",
    "count",
    type=click.IntRange(1),
    metavar="N",
    help="N cases on each rig, in some of them two faults.",
)
@click.option(
    "--only",
    metavar="FAULT",
    help="This fault alone, or two as in a+b; `rig faults list` has the names.",
)
@click.option(
    "--quiet",
    "hours",
    type=NumberWithin(0.0, 1e5, min_open=True),
    metavar="HOURS",
    help="Break nothing for so many simulated hours: whatever stops a rig then is a false trip.",
)
@click.option(
    "--on",
    type=OneOf(["virtual", "sim"]),
    default="virtual",
    show_default=True,
    help="With --quiet; sim has no frames, and takes a fraction of the time.",
)
@click.option(
    "--experiment",
    "experiments",
    multiple=True,
    metavar="NAME",
    help="Break it in this experiment; may be given again. Default: all of the rig's.",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Of the drawing: the same seed gives the same cases.",
)
@workers_option
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help=f"Where the campaign and its failures are kept; default: {CAMPAIGNS}, or {CAMPAIGNS} "
    "below --runs.",
)
@click.option(
    "--runs", type=click.Path(path_type=Path, file_okay=False), help="Where run folders live."
)
@click.option("--keep-all", is_flag=True, help="Keep the run folders of cases that went well, too.")
@configs_option
@json_option
def run(
    rigs: tuple[str, ...],
    full: bool,
    count: int | None,
    only: str | None,
    hours: float | None,
    on: str,
    experiments: tuple[str, ...],
    seed: int,
    workers: int,
    out: Path | None,
    runs: Path | None,
    keep_all: bool,
    configs: Path | None,
    as_json: bool,
) -> int:
    """Break rigs, or what files of scenarios say; exit 1 if anybody might have been hurt.

    Without a name cylinder, joint, arm, arm-odrive, legs and legs-can are broken, every fault once
    on each. Each case that goes wrong leaves a run folder with what was true after the fault, and
    the line that repeats it; `rig rerun` of that folder repeats it, too.
    A fault whose moment never came is no pass; the exit code is 2 then.
    With --quiet nothing is broken, and the exit code is 1 after a false trip.
    """  # fmt: skip
    from rig.assembly import Backend
    from rig.cli.file_kinds import is_rig
    from rig.config.names import find_configs
    from rig.faults.campaign import run_cases
    from rig.faults.progress import CampaignProgress
    from rig.faults.quiet import draw_quiet
    from rig.faults.table import make_rows
    from rig.faults.uncounted import say_uncounted

    if sum((full, count is not None and only is None)) > 1:
        raise click.UsageError("--full and --random say two things about how many cases there are")
    if out is not None and runs is not None:
        raise click.UsageError("--out is where campaigns lie, --runs what has a folder of them")
    out = out or (CAMPAIGNS if runs is None else runs / CAMPAIGNS)
    breaks = full or count is not None or only is not None
    if hours is not None and breaks:
        raise click.UsageError("--quiet breaks nothing; --full, --random and --only do")
    if hours is None and on != "virtual":
        raise click.UsageError("without frames there is little to break; --on is for --quiet")
    search = find_configs(configs)
    scenarios = {name for name in rigs if _is_file(name) and not is_rig(name, search)}
    for name in scenarios:
        if breaks or hours is not None or experiments:
            raise click.UsageError(f"{name} says itself what breaks, once, and in what")
    if hours is not None:
        subjects = [_survey(rig, experiments, configs) for rig in rigs or RIGS]
        drawn = draw_quiet(subjects, hours, seed, configs, Backend(on))
        return _be_quiet(drawn, make_folder(out, seed), workers, as_json)
    jobs: list[Job] = []
    for name in rigs or RIGS:
        if name in scenarios:
            jobs.append(_scenario_job(Path(name), configs))
        else:
            jobs += _jobs(name, full, count, only, experiments, seed, configs)
    folder = make_folder(out, seed)
    with CampaignProgress(len(jobs)) as progress:
        verdicts = run_cases(jobs, folder, configs, workers, progress.told, keeps=keep_all)
    rows = make_rows(verdicts)
    page = _keep(folder, f"Faults of {', '.join(rigs or RIGS)}, seed {seed}", verdicts)
    if as_json:
        print_json([verdict.as_json() for verdict in verdicts])
    else:
        print_tables(_tables(rows, verdicts))
    for one in verdicts if len(verdicts) <= _FEW else ():
        for hazard in one.uncounted():
            click.echo(f"not counted: {hazard}", err=True)
    if left := say_uncounted(verdicts):
        click.echo(left, err=True)
    click.echo(f"{page}", err=True)
    codes = {verdict.exit_code for verdict in verdicts}
    return min(codes - {0}, default=0)


def _tables(rows: Sequence[Row], verdicts: Sequence[Verdict]) -> list[Table]:
    """Return the campaign without the columns that say nothing, and a few cases one by one."""
    from rig.faults.table import CASE_HEADER, HEADER, case_cells, used_columns

    used, empty = used_columns(rows)
    cells = [tuple(row.cells()[k] for k in used) for row in rows]
    none = f" (none: {', '.join(empty)})" if empty else ""
    tables = [Table(f"faults{none}", tuple(HEADER[k] for k in used), cells)]
    if len(verdicts) <= _FEW:
        tables.append(Table("cases", CASE_HEADER, [case_cells(one) for one in verdicts]))
    return tables


def _is_file(name: str) -> bool:
    return name.endswith((".yaml", ".yml"))


def make_folder(out: Path, seed: int) -> Path:
    """Make the folder of a campaign: ``seed-N``, or ``seed-N-2`` beside an earlier one.

    Raises
    ------
    ConfigurationError
        It cannot be made.
    """
    from rig.hal import ConfigurationError
    from rig.run_folder import make_unique

    try:
        return make_unique(out, f"seed-{seed}")
    except OSError as error:
        raise ConfigurationError(
            f"cannot make {out / f'seed-{seed}'}: {error.strerror or error}; "
            "choose another place with --out"
        ) from error


def _be_quiet(runs: list[QuietRun], folder: Path, workers: int, as_json: bool) -> int:
    """Run rigs without a fault; see `rig.faults.quiet`."""
    from rig.faults.progress import QuietProgress
    from rig.faults.quiet import HOUR, run_quietly
    from rig.json_file import write_json

    with QuietProgress(len(runs)) as progress:
        endings = run_quietly(runs, folder, workers, progress.told)
    if as_json:
        print_json([ending.as_json() for ending in endings])
    else:
        rows = []
        for name in (*dict.fromkeys(run.rig for run in runs), "all"):
            own = [ending for ending in endings if name in (ending.run.rig, "all")]
            spent = sum(ending.duration for ending in own) / HOUR
            trips, right = sum(e.is_trip for e in own), sum(e.is_right for e in own)
            rows.append((name, str(len(own)), f"{spent:.3g}", str(trips), str(right)))
        head = ("rig", "runs", "hours", "false trips", "stopped for their friction")
        print_tables([Table("quiet", head, rows)])
    kept = folder / "quiet.json"
    write_json(kept, {"runs": [ending.as_json() for ending in endings]})
    click.echo(f"{kept}", err=True)
    return 1 if any(ending.is_trip for ending in endings) else 0


def _survey(rig: str, experiments: tuple[str, ...], configs: Path | None) -> Subject:
    from rig.faults.fitting import check_chosen, experiments_for
    from rig.faults.survey import survey

    click.echo(f"{rig}: looking at what it has …", err=True)
    check_chosen(experiments, rig, configs)
    among = experiments or experiments_for(rig, configs, partial(click.echo, err=True))
    return survey(rig, among, configs, chosen=bool(experiments))


def _jobs(
    rig: str,
    full: bool,
    count: int | None,
    only: str | None,
    experiments: tuple[str, ...],
    seed: int,
    configs: Path | None,
) -> list[Job]:
    from rig.faults.campaign import draw_each, draw_once, draw_random

    subject = _survey(rig, experiments, configs)
    if only is not None:
        cases = draw_once(subject, tuple(only.split("+")), seed, count or 1)
    elif count is not None:
        cases = draw_random(subject, seed, count)
    else:
        cases = draw_each(subject, seed, FULL if full else 1)
    return [(case, subject) for case in cases]


def _scenario_job(path: Path, configs: Path | None) -> Job:
    from rig.config.names import find_configs
    from rig.faults.case import Moment
    from rig.faults.scenario_file import case_of, load_scenario
    from rig.faults.survey import experiments_of, survey

    located = load_scenario(path, find_configs(configs))
    scenario = located.scenario
    calibrates = scenario.when.phase is Moment.CALIBRATION
    among = experiments_of(scenario.rig, configs)[:1] if calibrates else (scenario.experiment,)
    subject = survey(scenario.rig, among, configs)
    return case_of(located, subject, str(path)), subject


def _keep(folder: Path, title: str, verdicts: Sequence[Verdict]) -> Path:
    """Write what a campaign came to beside the folders of its failures."""
    from rig.faults.page import write_page
    from rig.faults.table import make_rows

    rows = make_rows(verdicts)
    content = {
        "title": title,
        "rows": [row.as_json() for row in rows],
        "cases": [verdict.as_json() for verdict in verdicts],
    }
    (folder / "campaign.json").write_text(json.dumps(content, indent=2), encoding="utf-8")
    page = folder / "campaign.html"
    write_page(page, title, rows, verdicts)
    return page
