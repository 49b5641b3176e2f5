"""`rig export`: a run's log for other programs."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import OneOf, json_option, run_argument, runs_beside_out_option
from rig.cli.patience import told_of_log
from rig.cli.tables import print_data, print_json, visible
from rig.run_names import find_run

TORN = 1


@click.command()
@run_argument("run")
@click.option(
    "--format",
    "format",
    type=OneOf(["csv", "npz", "mat", "parquet", "mcap"]),
    required=True,
    help="csv: text. npz: numpy. mat: MATLAB. parquet: pandas and others. mcap: in chunks with an "
    "index, for viewers that want one.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="File to write; default: log.FORMAT in the run folder, log-indexed.mcap for mcap.",
)
@runs_beside_out_option
@json_option
def export(run: str, format: str, out: Path | None, runs: Path, as_json: bool) -> int:
    """Write the log of RUN in another format, and print the file's path.

    RUN is a run folder, the name of one, or "latest". A run that crashed exports as far as its
    log goes. So does a log that was cut off after its run, with a sentence and exit code 1.
    """
    path = find_run(run, runs)
    from rig.export import export_run
    from rig.run_facts import LOG
    from rig.runtime.ending_signals import all_as_ctrl_c

    # What was begun is taken away.
    with all_as_ctrl_c(), told_of_log(f"writing the log as {format}", path / LOG):
        made = export_run(path, format, out)
    if as_json:
        print_json({"path": made.path, "missing": made.missing})
    else:
        print_data(str(made.path))
    if made.missing is None:
        return 0
    click.echo(visible(f"{made.missing}: what was left of it is exported"), err=True)
    return TORN
