"""`rig report`: a run's metrics, figures and report.html, made again from its log."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import complete_run, json_option, run_argument, runs_option
from rig.cli.patience import told_of_log
from rig.cli.tables import Table, print_data, print_json, print_tables, visible
from rig.run_names import find_run

if TYPE_CHECKING:
    from rig.report.beside_figure import Beside, Residual
    from rig.report.regenerate import RunReport


@click.command()
@run_argument("run")
@click.option("--beside", metavar="RUN", shell_complete=complete_run,
              help="Draw another run over it, and what is between them.")  # fmt: skip
@click.option(
    "--rehearse", is_flag=True, help="Go through RUN in simulation, and draw that over it."
)
@runs_option
@json_option
def report(run: str, beside: str | None, rehearse: bool, runs: Path, as_json: bool) -> int:
    """Make the figures and the report of RUN again, and print the report's path.

    RUN is a run folder, the name of one, or "latest". A run that crashed is reported as far as
    its log goes. With --beside or --rehearse it is also said how far the two runs are apart, and
    the figure `beside` shows it: a run of the rig, and its twin in simulation. Exit code 1 if
    there are figures to draw and none could be.
    """
    if rehearse and beside is not None:
        raise click.UsageError("either --rehearse or --beside: one run is drawn over the other")
    path = find_run(run, runs)
    other = None if beside is None else find_run(beside, runs)
    from rig.runtime.ending_signals import all_as_ctrl_c

    with all_as_ctrl_c():  # what draws ends with it
        compared, made = _written(path, other, rehearse)
    for sentence in (*made.failures, *made.notes):
        click.echo(visible(sentence), err=True)
    residuals = [] if compared is None else compared.residuals
    if as_json:
        content = {"page": made.page, "failures": made.failures, "notes": made.notes}
        print_json({**content, "residuals": [one._asdict() for one in residuals]})
    else:
        print_tables([_table(residuals)])
        print_data(str(made.page))
    return int(made.is_bare)


def _written(path: Path, other: Path | None, rehearse: bool) -> tuple[Beside | None, RunReport]:
    """Write the report; return what was drawn over the run, and the page."""
    from rig.hal import ConfigurationError
    from rig.report.regenerate import write_report
    from rig.run_facts import LOG
    from rig.run_folder import RunFolderError

    try:
        compared = _compare(path, other, rehearse)
        figures = () if compared is None else tuple(compared.files[:1])
        with told_of_log("measuring, and drawing figures", path / LOG):
            return compared, write_report(path, figures)
    except (OSError, RunFolderError) as error:
        why = str(error)
        if isinstance(error, OSError):
            why = f"cannot write the report of {path}: {error.strerror or error}"
        if isinstance(error.__cause__ or error, PermissionError):  # it lies with its run
            name = shlex.quote(path.name)
            why += f"; or report a copy: cp -r {shlex.quote(str(path))} . && rig report ./{name}"
        raise ConfigurationError(why) from error


def _compare(path: Path, other: Path | None, rehearse: bool) -> Beside | None:
    """Draw another run, or the simulation of this one, over it; None: nobody asked for it."""
    if other is None and not rehearse:
        return None
    from rig.report.beside_figure import draw_beside

    if other is not None:
        return draw_beside(path, other)
    import tempfile

    from rig.cli.rehearse import gone_through_again

    with tempfile.TemporaryDirectory(prefix="rig-rehearsal-") as kept:
        twin = gone_through_again(path, Path(kept))
        return None if twin is None else draw_beside(path, twin)


def _table(residuals: Sequence[Residual]) -> Table:
    from rig.hal.formats import format_quantity

    rows = [
        (one.name, *(format_quantity(value, one.unit) for value in (one.rms, one.greatest)))
        for one in residuals
    ]
    return Table("one run less the other", ("what", "rms", "greatest"), rows)
