"""What a calibration has found: as a table, and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rig.cli.tables import Table, print_tables

if TYPE_CHECKING:
    from rig.calibration.procedure import AnyProcedure
    from rig.calibration.session import Calibrated
    from rig.hal.closed_loop import ClosedLoop


def as_data(
    procedure: AnyProcedure, done: Calibrated, loops: dict[str, ClosedLoop]
) -> dict[str, object]:
    """Return what was found as plain data, SI."""
    return {
        "procedure": procedure.name,
        "title": procedure.title,
        "found": [
            {
                "of": finding.target,
                "estimates": [estimate._asdict() for estimate in finding.estimates],
                "not_found": list(finding.notes),
            }
            for finding in done.findings
        ],
        "files": list(done.files),
        "figures": list(done.figures),
        "loops": {name: loop._asdict() for name, loop in loops.items()},
    }


def show_found(procedure: AnyProcedure, done: Calibrated, *, quiet: bool) -> None:
    """Show what was found, what was not, and the files that were written."""
    from rig.config import format_to

    rows = []
    for finding in done.findings:
        for e in finding.estimates:
            value, low, high = format_to(e.value, e.std, e.unit, (e.low, e.high))
            (std,) = format_to(e.std, e.std, e.unit)
            rows.append((finding.target, e.name, value, std, f"{low} … {high}"))
    if not quiet:
        print_tables([Table(procedure.title, ("of", "quantity", "value", "std", "95 %"), rows)])
    for note in dict.fromkeys(note for finding in done.findings for note in finding.notes):
        click.echo(f"not found: {note}", err=True)
    for path in (*done.files, *done.figures):
        click.echo(str(path), err=True)
