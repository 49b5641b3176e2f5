"""`rig watch`: a page on which a run is seen, also while it goes on."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import tempfile
from pathlib import Path

import click

from rig.cli.names import complete_run, json_option, runs_option
from rig.cli.tables import print_json
from rig.run_names import LATEST, find_run


def check_page() -> None:
    """Raise a `ConfigurationError` if a page cannot be served here: before a run, not in it."""
    from rig.hal import ConfigurationError
    from rig.installation import installing

    if importlib.util.find_spec("aiohttp") is None:
        raise ConfigurationError(f"the page needs aiohttp: {installing('aiohttp')}")


@click.command()
@click.argument("run", required=False, shell_complete=complete_run)
@click.option("--beside", metavar="RUN", shell_complete=complete_run,
              help="Another run, laid under it in thin lines.")  # fmt: skip
@click.option("--rehearse", is_flag=True,
              help="Go through RUN in simulation, and lay that under it.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=8765, show_default=True,
              help="On loopback; another one if it is taken.")  # fmt: skip
@click.option("--steer", is_flag=True, help="Print a second address, from which gains change.")
@click.option("--open", "opens", is_flag=True, help="Open the page in this machine's browser.")
@click.option("--until-left", is_flag=True, hidden=True)
@runs_option
@json_option
def watch(
    run: str | None,
    beside: str | None,
    rehearse: bool,
    port: int,
    steer: bool,
    opens: bool,
    until_left: bool,
    runs: Path,
    as_json: bool,
) -> int:
    """Serve a page that shows RUN; without it the one that goes on, or the latest.

    It listens on this machine alone. From another one: ssh -L 8765:127.0.0.1:8765 HOST, and the
    address as it is printed.
    """
    if rehearse and beside is not None:
        raise click.UsageError("either --rehearse or --beside: one run is laid under the other")
    from rig.cli.stop import live_runs

    check_page()
    from rig.watching.server import serve_run

    going_on = live_runs(runs) if run is None else []
    path = going_on[0] if going_on else find_run(run or LATEST, runs)

    other = None if beside is None else find_run(beside, runs)

    def tell(look: str, steering: str | None) -> None:
        click.echo(f"watch {path.name}: {look}", err=True)
        if steering is not None:
            click.echo(f"steer it: {steering}", err=True)
        if as_json:  # now: who reads it wants the address while it is good for something
            print_json({"run": path, "look": look, "steer": steering})
        if opens:
            import webbrowser

            webbrowser.open(steering or look)

    with contextlib.suppress(KeyboardInterrupt), contextlib.ExitStack() as stack:
        if rehearse:
            from rig.cli.rehearse import gone_through_again

            os.nice(10)  # the run itself may go on
            kept = stack.enter_context(tempfile.TemporaryDirectory(prefix="rig-rehearsal-"))
            other = gone_through_again(path, Path(kept))
        serve_run(path, other, port, tell, steer=steer, leaves=until_left)
    return 0
