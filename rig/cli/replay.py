"""`rig replay`: a run's log through the code at hand."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import complete_run, find_run, runs_option


@click.command()
@click.argument("run", shell_complete=complete_run)
@click.option("--verify", "verifies", is_flag=True, help="Compare every command, bit for bit.")
@runs_option
def replay(run: str, verifies: bool, runs: Path) -> int:
    """Feed the readings in RUN's log to the controllers of the code at hand."""
    path = find_run(run, runs)
    from rig.replaying.recorded import open_recorded
    from rig.replaying.verify import verify

    verdict = verify(open_recorded(path))
    click.echo(str(verdict))
    return 0 if verdict.same else 1
