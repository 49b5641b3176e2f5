"""`rig rerun`: a run once more, from its folder alone."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import (
    complete_run,
    json_option,
    out_beside_runs_option,
    runs_beside_out_option,
    uncommissioned_option,
    yes_option,
)
from rig.cli.tables import print_data, print_json, visible
from rig.run_names import find_run


@click.command()
@click.argument("run", shell_complete=complete_run)
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
    """
    path = find_run(run, runs)
    from rig.cli.announce import may_move
    from rig.cli.progress import ProgressLine
    from rig.cli.run import as_data, show
    from rig.replaying.difference import differing_code, first_difference
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
        if difference is None:
            print_data("every cycle is as it was")
        else:
            print_data(f"it differs first at {difference}")
            for change in differing_code(repeat.folder, made):
                click.echo(
                    visible(f"{change.what}: {change.first} then, {change.second} now"), err=True
                )
    return result.exit_code
