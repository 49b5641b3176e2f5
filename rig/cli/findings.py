"""What a calibration has found, on a screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from rig.cli.tables import Table, print_tables

if TYPE_CHECKING:
    from rig.calibration.procedure import AnyProcedure
    from rig.calibration.session import Calibrated


def show_findings(procedure: AnyProcedure, done: Calibrated, *, quiet: bool) -> None:
    """Show what a procedure has found, what of it is in force and why, and what was not found."""
    from rig.config import format_to

    rows = []
    for finding in done.findings:
        for e in finding.estimates:
            value, low, high = format_to(e.value, e.std, e.unit, (e.low, e.high))
            (std,) = format_to(e.std, e.std, e.unit)
            rows.append((finding.target, e.name, value, std, f"{low} … {high}"))
    if not quiet:
        print_tables([Table(procedure.title, ("of", "quantity", "value", "std", "95 %"), rows)])
    for finding in done.findings:
        for name, reason in finding.reasons.items():
            click.echo(
                f"put in force: {name} {_value_under(name, finding.values)}: {reason}", err=True
            )
    for note in dict.fromkeys(note for finding in done.findings for note in finding.notes):
        click.echo(f"not found: {note}", err=True)
    for path in (*done.files, *done.figures):
        click.echo(str(path), err=True)


def _value_under(name: str, values: object) -> object:
    """Return the value of a dotted name."""
    for key in name.split("."):
        values = values[key] if isinstance(values, Mapping) else None
    return values
