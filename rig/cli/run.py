"""`rig run`: an experiment, with a progress line and a run folder."""

from __future__ import annotations

import contextlib
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    complete_run,
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
from rig.cli.number_option import NumberWithin
from rig.cli.on_option import FrameFormat, OnBackend
from rig.cli.patience import told_if_long
from rig.cli.tables import print_data, print_json

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.run import Result


_FEW = 3
"""So many segments are told by their names."""
_VERDICTS = {True: "ok", False: "MISSED", None: "not to be told without the true state"}


@click.command()
@experiment_argument
@click.option(
    "--on",
    "on",
    type=OnBackend(),
    default="virtual",
    show_default=True,
    help="sim: devices on the plant. virtual: production drivers on emulated CANopen nodes. "
    "vcan: SocketCAN vcan0. hardware: what the profile names. An INTERFACE such as vcan1, "
    "vcan0,vcan1, socketcan:can0 or slcan:/dev/ttyACM0: this one, see `rig simulate`.",
)
@rig_option
@click.option("--controller", help="Another controller than the experiment's.")
@set_option
@seed_option
@out_option
@configs_option
@click.option(
    "--frames", is_flag=False, flag_value="log", type=FrameFormat(), metavar="[FORMAT]",
    help="Record the CAN buses: frames.log as candump writes it, or --frames=asc, --frames=blf.",
)  # fmt: skip
@click.option("--no-report", is_flag=True, help="Leave out figures and report.html.")
@json_option
@click.option("--watch", is_flag=True, help="Serve a page on which the run can be watched.")
@click.option(
    "--rehearse", is_flag=True,
    help="With --watch: go through it on sim first, and lay that under it in thin lines.",
)  # fmt: skip
@click.option(
    "--beside", metavar="RUN", shell_complete=complete_run,
    help="With --watch: another run, laid under it in thin lines.",
)  # fmt: skip
@click.option("--steer", is_flag=True, help="With --watch: gains may be changed on that page.")
@click.option(
    "--pace", type=NumberWithin(min=0.01), metavar="FACTOR",
    help="Times real time that a simulation runs at most; 1 with --watch or a gamepad.",
)  # fmt: skip
@uncommissioned_option
@yes_option
def run(
    experiment: str,
    on: str,
    rig_name: str | None,
    controller: str | None,
    overrides: tuple[str, ...],
    seed: int | None,
    out: Path,
    configs: Path | None,
    frames: str | None,
    no_report: bool,
    as_json: bool,
    watch: bool,
    rehearse: bool,
    beside: str | None,
    steer: bool,
    pace: float | None,
    uncommissioned: str | None,
    yes: str | None,
) -> int:
    """Run EXPERIMENT and leave a run folder with log, metrics, figures and report.

    Hardware moves only when the rig's name was typed, or given by --yes.

    EXPERIMENT is a name from `rig list` or the path of a YAML file. Ctrl-C stops the rig in an
    orderly way, a second Ctrl-C at once; both leave it safe.
    """
    from rig.assembly import Backend, backend_of
    from rig.cli.announce import may_move
    from rig.cli.file_kinds import refuse_rig
    from rig.cli.loops import warn_unstable
    from rig.cli.watched_run import WatchedRun
    from rig.config.names import find_configs
    from rig.config.setting import Setting
    from rig.experiment.ending import EXIT_MISSED, EXIT_OK, EXIT_PREFLIGHT, EXIT_USAGE
    from rig.experiment.plan import load_plan, simulated_otherwise
    from rig.experiment.run import run_experiment
    from rig.run_names import find_run

    if watch:
        from rig.cli.watch import check_page

        check_page()
    else:
        asked = {"--rehearse": rehearse, "--beside": beside, "--steer": steer}
        for option in (name for name, value in asked.items() if value):
            raise click.UsageError(f"{option} is for a page: give --watch as well")
    if rehearse and beside is not None:
        raise click.UsageError("either --rehearse or --beside: one run is laid under the other")
    options = with_seed(overrides, seed)
    if controller is not None:
        options.append(Setting(f"controller={controller}", f"--controller {controller}"))
    refuse_rig(
        experiment,
        find_configs(configs),
        f"run an experiment on it: rig run EXPERIMENT --rig {experiment}",
    )
    with told_if_long("planning the motion"):
        plan = load_plan(experiment, options, rig=rig_name, configs=configs)
    if rig_name is not None:
        options.append(f"rig={rig_name}")
    under = None if beside is None else find_run(beside, out)
    if rehearse:
        from rig.cli.rehearse import gone_through

        under = gone_through(load_plan(experiment, options, configs=configs), out)
        if under is None:
            click.echo("nothing was moved; without --rehearse it is run all the same", err=True)
            return EXIT_PREFLIGHT
    if not may_move(plan, on, yes, uncommissioned):
        return EXIT_USAGE
    simulated = backend_of(on).is_simulated
    for told in simulated_otherwise(plan) if simulated else ():
        click.echo(f"note: {told}", err=True)
    if simulated:  # on hardware such a loop is refused
        warn_unstable(plan, experiment, rig_name, options)
    pace = pace or (1.0 if watch or plan.motion.real_time else None)
    line = WatchedRun(
        plan,
        on,
        needs_hold=backend_of(on) is Backend.HARDWARE,
        pace=pace if simulated else None,
        watch=watch,
        steer=steer,
        beside=under,
    )
    with line:
        result = run_experiment(
            plan,
            backend_of(on),
            out,
            on=None if on in list(Backend) else on,
            overrides=options,
            watcher=line,
            report=not no_report,
            frames=frames,
            is_permitted=True,
            uncommissioned=uncommissioned,
        )
        line.keep_gains()
    if as_json:
        print_json(as_data(result))
    else:
        show(result)
        if rig_name is not None and any(metric.passed is False for metric in result.metrics):
            click.echo(
                f"with --rig {rig_name} the bounds stay those that {plan.experiment.name} has for "
                "the rig it names; set others, such as --set metrics.NAME.max=VALUE",
                err=True,
            )
    if (
        result.exit_code == EXIT_PREFLIGHT
        and not simulated
        and _names_a_device(result.message, plan.profile.devices)
    ):
        asking = f"rig check {plan.profile.argument} --on {on}"
        click.echo(f"who answers on the bus is told by: {asking}", err=True)
    if not as_json and result.exit_code in (EXIT_OK, EXIT_MISSED):
        _tell_next(plan.profile, simulated=simulated, passed=result.exit_code == 0)
    return result.exit_code


def _tell_next(profile: Profile, *, simulated: bool, passed: bool) -> None:
    """Say what comes next: of a rig of the user's own, and on hardware of any that did well."""
    from rig.cli.status import tell_next
    from rig.commissioning.permission import configs_of
    from rig.config.names import SHIPPED

    its = [path.resolve() for path in profile.files[:1]]
    is_own = any(SHIPPED not in path.parents for path in its)
    if not (is_own if simulated else passed):
        return
    # Procedures of others are asked what the rig lacks: nothing that is said of what comes next
    # may hide how the run has ended.
    with contextlib.suppress(Exception):
        tell_next(profile, configs_of(profile), simulated=simulated, has_run=True)


def _names_a_device(message: str | None, devices: Collection[str]) -> bool:
    """Return whether an error is a device's and not, say, the interface's own."""
    first = (message or "").partition(":")[0].partition(" ")[0]
    return first in devices


def as_data(result: Result) -> dict[str, object]:
    """Return a result as plain data."""
    return {
        "run": str(result.path),
        "status": result.status.value,
        "exit_code": result.exit_code,
        "message": result.message,
        "metrics": [metric.as_json() for metric in result.metrics],
    }


def _stretches(folder: Path, pattern: str) -> str:
    """Return the names of the segments that a pattern means; the pattern if they are many."""
    import json
    from fnmatch import fnmatchcase

    from rig.run_facts import EVALUATION

    try:
        known = json.loads((folder / EVALUATION).read_text(encoding="utf-8"))["segments"]
        names = [str(one["name"]) for one in known if fnmatchcase(one["name"], pattern)]
    except (OSError, ValueError, KeyError, TypeError):  # the folder is somebody else's by now
        names = []
    return " and ".join(names) if 0 < len(names) <= _FEW else pattern


def show(result: Result) -> None:
    """Print what a run came to: metrics on stdout, talk on stderr."""
    from rig.hal.formats import format_against
    from rig.run_facts import LOG, REPORT, RunStatus

    # A flaw was told when it was found.
    is_told = result.message is None or result.status is RunStatus.FAILED
    if not is_told:
        click.echo(f"{result.status}: {result.message}", err=True)
    if result.status is RunStatus.FAULTED:
        from rig.explaining.fault_time import fault_time

        when = fault_time(result.path)
        if when is not None:
            click.echo(f"when: {when}", err=True)
    width = max((len(metric.name) for metric in result.metrics), default=0)
    lines = []
    for metric in result.metrics:
        value, bound = format_against(metric.value, metric.bound, metric.unit)
        value = value if metric.is_seen else "-"
        if metric.bound is not None:
            sign = "<=" if metric.bound_kind == "max" else ">="
            bound = f"{sign} {bound}  {_VERDICTS[metric.passed]}"
        # Metrics of the same measure have names of their own; one name alone is of what it says.
        tells = metric.segments != "*" and metric.name == metric.measure
        over = f"  over {_stretches(result.path, metric.segments)}" if tells else ""
        lines.append(f"{metric.name:{width}}  {value:>12}  {bound}{over}".rstrip())
    if lines:
        print_data("\n".join(lines))
    report = result.path / REPORT
    made = report if report.exists() else result.path / LOG
    verdict = f"{result.status}: " if is_told else ""
    click.echo(f"{verdict}{made}", err=True)
    if result.status in (RunStatus.FAULTED, RunStatus.FAILED):
        click.echo(f"what it means, and what to check: rig explain {result.path}", err=True)
