"""`rig report`: a run's metrics, figures and report.html, made again from its log."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import complete_run, json_option, runs_option
from rig.cli.tables import print_data, print_json, visible
from rig.run_names import find_run


@click.command()
@click.argument("run", shell_complete=complete_run)
@runs_option
@json_option
def report(run: str, runs: Path, as_json: bool) -> int:
    """Make the figures and the report of RUN again, and print the report's path.

    RUN is a run folder, the name of one, or "latest". A run that crashed is reported as far as
    its log goes.
    """
    path = find_run(run, runs)
    from rig.hal import ConfigurationError
    from rig.report.regenerate import write_report

    try:
        made = write_report(path)
    except OSError as error:
        raise ConfigurationError(
            f"cannot write the report of {path}: {error.strerror or error}"
        ) from error
    for sentence in made.failures:
        click.echo(visible(sentence), err=True)
    if as_json:
        print_json({"page": made.page, "failures": made.failures})
    else:
        print_data(str(made.page))
    return 0
