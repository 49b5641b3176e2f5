"""`rig margins`: how far a rig's loop is from instability, measured on it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    complete_rig,
    configs_option,
    json_option,
    law_option,
    out_option,
    seed_option,
    set_option,
    uncommissioned_option,
    with_seed,
    yes_option,
)
from rig.cli.on_option import OnBackend
from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from rig.experiment.plan import Plan
    from rig.experiment.run import Result
    from rig.hal.closed_loop import ClosedLoop
    from rig.hal.measured_loop import MeasuredLoop
    from rig.tuning.measured import LoopsBeside

_FAR = 3.0
"""So many times the crossover a loop should be known."""
_SHAKE, _LITTLE = "reference.shake", 0.15
"""The key of the shake, and one with which pairs glide on that stick with the usual one."""
_UNITS = {"crossover": "rad/s", "phase": "rad", "delay": "s", "sensitivity": "1"}


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@law_option
@click.option(
    "--on", "on", type=OnBackend(), default="virtual", show_default=True,
    help="As for `rig run`.",
)  # fmt: skip
@click.option(
    "--leave", is_flag=True,
    help="Leave tuned gains in force, though the loop be nearer to instability than before.",
)  # fmt: skip
@out_option
@set_option
@seed_option
@configs_option
@uncommissioned_option
@yes_option
@json_option
def margins(
    rig: str,
    controller: str,
    on: str,
    leave: bool,
    out: Path,
    overrides: tuple[str, ...],
    seed: int | None,
    configs: Path | None,
    uncommissioned: str | None,
    yes: str | None,
    as_json: bool,
) -> int:
    """Measure on RIG how far the loop of its law is from instability.

    The rig runs an experiment that shakes it a little while it moves, less than a minute long.
    From its log come the crossover, the phase and delay margins and the greatest sensitivity,
    with their 95 % intervals, beside those of the linear model. Gains that `rig tune` has put in
    force are compared with those before them, on the same recording: if they are worse, and miss
    the bound of 1.7, those before them are put in force again (exit 1). A loop that the recording
    does not tell is exit 1, too.

    The run folder gets margins.json and a figure. Hardware moves only when the rig's name was
    typed, or given by --yes.
    """
    from rig.assembly import REGISTRY
    from rig.cli.announce import may_move
    from rig.config import load_profile
    from rig.config.names import find_configs
    from rig.experiment.ending import EXIT_MISSED, EXIT_OK, EXIT_USAGE
    from rig.experiment.plan import load_plan, split_overrides
    from rig.hal.measured_loop import LoopUntold
    from rig.tuning.measured import loop_teller, measured_beside

    search = find_configs(configs)
    given = with_seed(overrides, seed)
    of_rig = split_overrides(given, rig, search)[1]
    profile = load_profile(rig, REGISTRY, of_rig, search)
    loop_teller(profile)
    given.append(f"controller={controller}")
    plan = load_plan(f"{profile.mechanism}-margins", given, rig=rig, configs=configs)
    if not may_move(plan, on, yes, uncommissioned):
        return EXIT_USAGE
    result = _run(plan, on, out, [*given, f"rig={rig}"], uncommissioned)
    if result.exit_code not in (EXIT_OK, EXIT_MISSED):
        _tell_ended(result)
        return result.exit_code
    of = ["rig", "margins", rig, "--controller", controller, "--on", on]
    try:
        loops = measured_beside(result.path, plan.profile, controller, search, of_rig)
    except LoopUntold as untold:
        _tell_untold(result.path, untold, with_smaller_shake(of, overrides), as_json)
        return EXIT_MISSED
    figures = _keep(result.path, loops, overrides)
    back = None
    if loops.is_worse and not leave:
        back = _put_back(plan, controller, loops, search)
    if as_json:
        print_json({"run": result.path, **_as_data(loops), "put_back": back})
    else:
        softer = with_smaller_shake(of, overrides)
        _show(plan.profile.name, controller, loops, softer)
    for path in figures:
        click.echo(str(path), err=True)
    return EXIT_MISSED if loops.is_worse else EXIT_OK


def _run(
    plan: Plan, on: str, out: Path, given: Sequence[str], uncommissioned: str | None
) -> Result:
    from rig.assembly import Backend, backend_of
    from rig.cli.progress import ProgressLine
    from rig.experiment.run import run_experiment

    with ProgressLine(plan.experiment.name, on) as line:
        return run_experiment(
            plan, backend_of(on), out,
            on=None if on in list(Backend) else on, overrides=given, watcher=line,
            report=False, is_permitted=True, uncommissioned=uncommissioned,
        )  # fmt: skip


def _tell_ended(result: Result) -> None:
    if result.message is not None:
        click.echo(f"{result.status}: {result.message}", err=True)
    click.echo(f"what it means, and what to check: rig explain {result.path}", err=True)


def with_smaller_shake(words: Sequence[str], overrides: Sequence[str]) -> str:
    """Return the command that shakes less; empty: it was shaken as little already."""
    sets, shaken = [], math.inf
    for one in overrides:
        key, _, value = one.partition("=")
        if key.strip() == _SHAKE:
            shaken = float(value)  # that it is a number was seen when it was run
        else:
            sets += ["--set", one]
    if shaken <= _LITTLE:
        return ""
    return shlex.join([*words, *sets, "--set", f"{_SHAKE}={_LITTLE:g}"])


def _tell_untold(run: Path, untold: Exception, softer: str, as_json: bool) -> None:
    """Say that a recording tells no loop, and what may; `rig explain` of the run finds it."""
    from rig.json_file import write_json
    from rig.run_facts import MARGINS, UNTOLD
    from rig.run_folder import RunFolder

    write_json(RunFolder.open(run).place(MARGINS), {UNTOLD: str(untold)})
    click.echo(str(untold), err=True)
    if softer:
        click.echo(f"with a smaller shake a pair that sticks may glide on: {softer}", err=True)
    click.echo("what else there is to do: rig explain unknown_loop", err=True)
    if as_json:
        print_json({"run": run, UNTOLD: str(untold)})


def _keep(run: Path, loops: LoopsBeside, overrides: Sequence[str]) -> list[Path]:
    """Write what was measured into the run folder; return the figure's files."""
    from rig.json_file import write_json
    from rig.report.data import imprint_of
    from rig.report.loop_figure import draw_loops
    from rig.report.style import paper_style, save
    from rig.run_facts import FIGURES, MARGINS
    from rig.run_folder import RunFolder

    folder = RunFolder.open(run)
    write_json(folder.place(MARGINS), {**_as_data(loops), "set": list(overrides)})
    shown = {"in force": loops.now}
    if loops.before is not None:
        shown["before"] = loops.before
    with paper_style():
        figure = draw_loops(shown)
        return save(figure, folder.place(FIGURES), Path(MARGINS).stem, imprint_of([folder]))[:1]


def _put_back(plan: Plan, controller: str, loops: LoopsBeside, search: Sequence[Path]) -> Path:
    from rig.tuning.measured import put_back

    assert loops.former is not None
    assert loops.before is not None
    now, before = loops.now.margins.sensitivity, loops.before.margins.sensitivity
    path = put_back(plan.profile, controller, loops.former, search)
    click.echo(
        f"the tuned gains are nearer to instability on this rig (sensitivity measured {now:.3g}, "
        f"before {before:.3g}): {loops.former.what} are in force again; --leave would have left "
        "them",
        err=True,
    )
    click.echo(str(path), err=True)
    return path


def _as_data(loops: LoopsBeside) -> dict[str, object]:
    """Return what was measured as plain data, SI."""

    def one(loop: MeasuredLoop) -> dict[str, object]:
        measured, model = loop.margins, _modelled(loop)
        return {
            **{
                name: {
                    "measured": _known(getattr(measured, name)),
                    "interval": [_known(bound) for bound in loop.interval(name)],
                    "model": _known(getattr(model, name)),
                }
                for name in _UNITS
            },
            "partial": loop.is_partial,
            "frequencies": loop.frequencies.tolist(),
            "gain": abs(loop.response).tolist(),
        }

    data: dict[str, object] = {"now": one(loops.now)}
    if loops.before is not None and loops.former is not None:
        data["before"] = {"gains": loops.former.what, **one(loops.before)}
    return data


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _modelled(loop: MeasuredLoop) -> ClosedLoop:
    from rig.hal.measured_loop import margins_of

    return margins_of(loop.frequencies, loop.model)


def _show(rig: str, controller: str, loops: LoopsBeside, softer: str) -> None:
    from rig.hal.closed_loop import SENSITIVITY

    first, last = _range(loops.now)
    within = f" from {first} to {last} alone" if loops.now.is_partial else ""
    names = {
        "crossover": "crossover", "phase": "phase margin", "delay": "bears further dead time of",
        "sensitivity": f"greatest sensitivity{within} (at most {SENSITIVITY:g})",
    }  # fmt: skip
    head = ["what", "linear model", "measured", "95 %"]
    if loops.before is not None:
        head += ["measured, before", "95 %"]
    rows = []
    for name, said in names.items():
        row = [said, _text(name, getattr(_modelled(loops.now), name))]
        for loop in (loops.now, loops.before):
            if loop is not None:
                low, high = loop.interval(name)
                between = "-" if math.isnan(low) else f"{_text(name, low)} to {_text(name, high)}"
                row += [_text(name, getattr(loop.margins, name)), between]
        rows.append(tuple(row))
    for doubt in doubts_about(loops.now, softer):
        click.echo(doubt, err=True)
    title = f"the loop that {controller} closes on {rig}, from {first} to {last}"
    print_tables([Table(title, tuple(head), rows)])


def doubts_about(loop: MeasuredLoop, softer: str = "") -> Iterator[str]:
    """Yield what is not known of a loop that was measured, a sentence each.

    Parameters
    ----------
    loop : MeasuredLoop
        As far as it is known.
    softer : str
        The command that shakes it less; empty: it was shaken as little.
    """
    first, last = _range(loop)
    if loop.is_partial and loop.shaken is not None:
        least, most = (f"{loop.shaken[k]:g} Hz" for k in (0, -1))
        more = f"; with a smaller shake more of it may be told: {softer}" if softer else ""
        yield (
            f"of a shake from {least} to {most} the loop is told from {first} to {last} alone, and "
            "what is printed is of that band: a greater sensitivity may lie outside, and without "
            f"what catches in the pair it may be smaller; the 95 % know of neither{more}"
        )
    if not loop.tells_crossover:
        yield (
            f"from {first} to {last}, where the loop is known, its gain is nowhere 1: it may be "
            "nearer to instability than what was measured says; the pair may stick while it glides"
        )
    elif loop.frequencies[-1] < _FAR * loop.margins.crossover / (2.0 * math.pi):
        yield (
            f"above {last} the loop could not be told from noise: the pair may stick, or swing by "
            "itself, while it glides"
        )


def _range(loop: MeasuredLoop) -> tuple[str, str]:
    """Return the least and the greatest frequency at which a loop is known."""
    first, last = (f"{loop.frequencies[k]:g} Hz" for k in (0, -1))
    return first, last


def _text(name: str, value: float) -> str:
    from rig.config import format_quantity

    if math.isnan(value):
        return "-"
    if name == "phase":
        return f"{math.degrees(value):.3g} deg"
    if name == "sensitivity":
        return f"{value:.3g}"
    return format_quantity(float(f"{value:.3g}"), _UNITS[name])
