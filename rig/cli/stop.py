"""`rig stop`: what Ctrl-C does, from another terminal."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import complete_run, json_option, runs_option
from rig.cli.number_option import NumberWithin
from rig.cli.tables import print_json
from rig.run_names import find_run, list_runs


@click.command()
@click.argument("run", required=False, shell_complete=complete_run)
@click.option("--all", "every", is_flag=True, help="Every run that goes on in RUNS.")
@click.option("--at-once", is_flag=True, help="As Ctrl-C twice: without braking under control.")
@click.option(
    "--wait", type=NumberWithin(min=0), default=30.0, show_default=True, metavar="SECONDS",
    help="For how long at most the end is waited for.",
)  # fmt: skip
@runs_option
@json_option
def stop(
    run: str | None, every: bool, at_once: bool, wait: float, runs: Path, as_json: bool
) -> int:
    """Stop RUN, the one that goes on, or all of them; orderly, as Ctrl-C in its terminal does.

    This is not the emergency stop. It asks a program, which must be able to hear it.
    """
    from rig.run_facts import RunStatus
    from rig.run_folder import RunFolder
    from rig.stopping import CannotStop, request_stop, wait_for_end

    if run is not None and every:
        raise click.UsageError("either a RUN or --all")
    going_on = [find_run(run, runs)] if run is not None else live_runs(runs)
    if not going_on and as_json:
        print_json([])
    if not going_on:
        click.echo(f"no run goes on in {runs}", err=True)
        return 1
    if len(going_on) > 1 and not every:
        names = ", ".join(path.name for path in going_on)
        raise click.UsageError(f"{len(going_on)} runs go on ({names}): name one, or --all")
    failed = False
    ended: dict[Path, str | None] = dict.fromkeys(going_on)
    for path in going_on:
        try:
            process = request_stop(path, at_once=at_once)
        except CannotStop as error:
            click.echo(f"error: {error}", err=True)
            failed = True
            continue
        how = "at once" if at_once else "in an orderly way"
        click.echo(f"{path.name}: process {process} was asked to stop {how}", err=True)
    for path in () if wait == 0.0 else going_on:
        if not wait_for_end(path, wait):
            click.echo(f"{path.name}: it still goes on after {wait:g} s", err=True)
            failed = True
            continue
        folder = RunFolder.open(path)
        ended[path] = folder.status.value
        if folder.status is not RunStatus.OK:
            click.echo(f"{path.name}: {folder.manifest.get('message')}", err=True)
    if as_json:
        print_json([{"run": path, "status": status} for path, status in ended.items()])
    return 1 if failed else 0


def live_runs(runs: Path) -> list[Path]:
    """Return the folders of the runs that go on, newest first."""
    from rig.run_facts import EVENTS
    from rig.runtime.file_lock import is_locked

    return [path for path in list_runs(runs) if is_locked(path / EVENTS)]
