"""`rig replay`: a run's log through the code at hand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import json_option, run_argument, runs_beside_out_option, set_option
from rig.cli.tables import Table, print_data, print_json, print_tables, visible
from rig.run_names import find_run

if TYPE_CHECKING:
    from rig.replaying.recorded import RecordedRun

DIFFERS = 1


@click.command()
@run_argument("run")
@click.option(
    "--verify", "verifies", is_flag=True,
    help="Compare every command with the log, bit for bit; the default without --controller.",
)  # fmt: skip
@click.option(
    "--frames", "from_frames", is_flag=True,
    help="Have the drivers read the run's frames anew, in the place of the log's readings.",
)  # fmt: skip
@click.option("--explain", "explains", is_flag=True, help="Show the inputs around a difference.")
@click.option("--controller", help="Ask another law what it would have commanded: in open loop.")
@set_option
@click.option(
    "--out", type=click.Path(path_type=Path),
    help="Folder for the figure of another law; default: replay in the run folder.",
)  # fmt: skip
@runs_beside_out_option
@json_option
def replay(
    run: str,
    verifies: bool,
    from_frames: bool,
    explains: bool,
    controller: str | None,
    overrides: tuple[str, ...],
    out: Path | None,
    runs: Path,
    as_json: bool,
) -> int:
    """Feed the readings in RUN's log to the controllers of the code at hand.

    With --verify it exits with 0 if every number is the log's, and with 1 at the first that is
    not. With --controller or --set it shows what another law would have commanded on the same
    readings: in open loop, since the rig did not follow it.
    """
    path = find_run(run, runs)
    from rig.config.setting import Setting
    from rig.replaying.recorded import open_recorded, other_version
    from rig.run_folder import RunFolder

    versions = other_version(RunFolder.open(path))
    if versions is not None:
        click.echo(visible(versions), err=True)
    options = list(overrides)
    if controller is not None:
        options.append(Setting(f"controller={controller}", f"--controller {controller}"))
    if not options:
        return _verify(open_recorded(path), explains, from_frames, as_json)
    if verifies or explains or from_frames:
        raise click.UsageError(
            "--verify, --explain and --frames are for the law of the run itself."
        )
    return _ask(path, options, path / "replay" if out is None else out, as_json)


def _verify(recorded: RecordedRun, explains: bool, from_frames: bool, as_json: bool) -> int:
    from rig.replaying.explain import explain
    from rig.replaying.frames import FramesRig
    from rig.replaying.verify import verify

    if from_frames:
        rig = FramesRig(recorded)
        try:
            found = verify(recorded, rig)
        finally:
            rig.close()
    else:
        found = verify(recorded)
    if found.unknown:
        click.echo(f"{found.unknown} cycles after a fault are not compared", err=True)
    if as_json:
        told = found.difference or found.stopped
        print_json(
            {
                "cycles": found.cycles,
                "unknown": found.unknown,
                "same": found.same,
                "difference": None if told is None else str(told),
            }
        )
        return 0 if found.same else DIFFERS
    if found.same:
        print_data(f"{found.cycles} cycles, every number the same")
        return 0
    print_data(f"the same for {found.cycles} cycles; then {found.difference or found.stopped}")
    if explains and found.difference is not None:
        header, rows = explain(recorded, found.difference)
        print_tables([Table("inputs", header, [tuple(row) for row in rows])])
    return DIFFERS


def _ask(path: Path, options: list[str], out: Path, as_json: bool) -> int:
    from rig.hal.formats import format_quantity
    from rig.replaying.open_loop import answer, draw
    from rig.replaying.recorded import open_recorded, plan_of
    from rig.report.data import imprint_of
    from rig.report.style import paper_style, save

    recorded = open_recorded(path, options)
    found = answer(recorded)
    names = plan_of(recorded.folder).experiment.controller, recorded.plan.experiment.controller
    rows = [
        (column.name, format_quantity(rms, column.unit), format_quantity(most, column.unit))
        for column, rms, most in zip(found.columns, found.rms, found.most, strict=True)
    ]
    if not as_json:
        print_tables([Table("commands", ("command", "rms difference", "greatest"), rows)])
    click.echo(
        f"open loop: {names[1]} ({', '.join(options)}) was asked on the readings of {names[0]}, "
        "which it did not cause",
        err=True,
    )
    if found.stopped is not None:
        click.echo(visible(found.stopped), err=True)
    with paper_style():
        figure = draw(found, names)
        made = save(figure, out, "commands", f"open loop; {imprint_of([recorded.folder])}")
    if as_json:
        commands = [
            {"command": column.name, "unit": column.unit, "rms": rms, "max": most}
            for column, rms, most in zip(found.columns, found.rms, found.most, strict=True)
        ]
        told = None if found.stopped is None else str(found.stopped)
        print_json({"commands": commands, "stopped": told, "figure": made[0]})
    else:
        click.echo(str(made[0]))
    return 0
