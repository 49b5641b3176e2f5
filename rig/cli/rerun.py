"""`rig rerun`: a run once more, from its folder alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    json_option,
    out_beside_runs_option,
    run_argument,
    runs_beside_out_option,
    uncommissioned_option,
    yes_option,
)
from rig.cli.tables import print_data, print_json, visible
from rig.run_names import find_run

if TYPE_CHECKING:
    from rig.faults.case import Case
    from rig.run_folder import RunFolder


@click.command()
@run_argument("run")
@runs_beside_out_option
@out_beside_runs_option
@click.option("--no-report", is_flag=True, help="Leave out figures and report.html.")
@uncommissioned_option
@yes_option
@json_option
def rerun(
    run: str,
    runs: Path,
    out: Path,
    no_report: bool,
    uncommissioned: str | None,
    yes: str | None,
    as_json: bool,
) -> int:
    """Run RUN again from its folder alone, and say whether the same came of it.

    Profile, calibrations and experiment are those in the folder. In simulation, with the same
    versions, every number of the log but wall-clock times is the same, and so are the metrics.
    What `rig faults run` broke is broken again.
    """
    path = find_run(run, runs)
    from rig.faults.kept_case import load_case

    case = load_case(path)
    if case is not None:
        return _break_again(case, path, out, as_json)
    from rig.cli.announce import may_move
    from rig.cli.progress import ProgressLine
    from rig.cli.run import as_data, show
    from rig.replaying.difference import first_difference
    from rig.replaying.rerun import Repeat
    from rig.run_folder import RunFolder

    repeat = Repeat(path)
    on = repeat.on or repeat.backend.value
    if not may_move(repeat.plan, on, yes, uncommissioned):
        return 2
    line = ProgressLine(repeat.plan.experiment.name, on)
    with line:
        result = repeat.run(out, line, report=not no_report, uncommissioned=uncommissioned)
    made = difference = None
    if repeat.backend.is_simulated and result.path.joinpath("log.mcap").exists():
        made = RunFolder.open(result.path)
        difference = first_difference(repeat.folder, made)
    if as_json:
        told = None if difference is None else str(difference)
        print_json({**as_data(result), "compared": made is not None, "difference": told})
        return result.exit_code
    show(result)
    if made is not None:
        _tell_difference(repeat.folder, made, difference)
    return result.exit_code


def _break_again(case: Case, path: Path, out: Path, as_json: bool) -> int:
    """Repeat a run of `rig faults run` with what was broken in it; exit as that would."""
    from rig.faults.again import perform_again
    from rig.replaying.difference import first_difference
    from rig.run_folder import RunFolder

    click.echo(f"{case.awaited}, as in {path.name}", err=True)
    verdict = perform_again(case, path, out)
    made = difference = None
    if verdict.folder and Path(verdict.folder, "log.mcap").exists():
        then, made = RunFolder.open(path), RunFolder.open(verdict.folder)
        difference = first_difference(then, made)
    if as_json:
        print_json({**verdict.as_json(), "compared": made is not None, "difference": difference})
    else:
        for sentence in list(verdict.wrongs()) or [verdict.outcome]:
            print_data(sentence)
        if made is not None:
            _tell_difference(then, made, difference)
        click.echo(verdict.folder, err=True)
    return verdict.exit_code


def _tell_difference(then: RunFolder, made: RunFolder, difference: str | None) -> None:
    """Say whether two runs are the same, and whose code is not where they are not."""
    from rig.replaying.difference import differing_code

    if difference is None:
        print_data("every cycle is as it was")
        return
    print_data(f"it differs first at {difference}")
    for change in differing_code(then, made):
        click.echo(visible(f"{change.what}: {change.first} then, {change.second} now"), err=True)
