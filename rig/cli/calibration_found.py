"""What a calibration has found: as a table, and as plain data."""

from __future__ import annotations

from collections.abc import Mapping
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
                "reasons": dict(finding.reasons),
            }
            for finding in done.findings
        ],
        "files": list(done.files),
        "figures": list(done.figures),
        "loops": {name: loop._asdict() for name, loop in loops.items()},
    }


def show_found(procedure: AnyProcedure, done: Calibrated, *, quiet: bool) -> None:
    """Show what was found, what of it is in force and why, what was not found, and the files."""
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
            said = f"{name} {_value_under(name, finding.values)}"
            click.echo(f"put in force: {said}: {reason}", err=True)
    for note in dict.fromkeys(note for finding in done.findings for note in finding.notes):
        click.echo(f"not found: {note}", err=True)
    for path in (*done.files, *done.figures):
        click.echo(str(path), err=True)


def _value_under(name: str, values: object) -> object:
    """Return the value of a dotted name."""
    for key in name.split("."):
        values = values[key] if isinstance(values, Mapping) else None
    return values
