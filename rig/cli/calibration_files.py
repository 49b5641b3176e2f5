"""What `rig calibrate` does with kept files: show them, compare two, put one in force again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path

import click

from rig.cli.tables import Table, print_data, print_json, print_tables, visible


def show_history(search: Sequence[Path], rig: str, target: str, *, as_json: bool) -> int:
    """Show every kept calibration of a device, also those that cannot be used."""
    from rig.calibration.store import history, load
    from rig.config import rig_name
    from rig.hal import ConfigurationError

    name = rig_name(rig, search)
    kept = history(search, name, target)
    if not kept:
        raise ConfigurationError(f"no calibration of {target} of the rig {name} is kept")
    rows = []
    found: list[dict[str, object]] = []
    for path in kept:
        try:
            of = load(path)["provenance"]
        except ConfigurationError as error:  # one that is damaged hides no other
            click.echo(visible(f"{path} cannot be used: {error}"), err=True)
            rows.append(("-",) * 6 + (str(path),))
            found.append({"file": path, "provenance": None})
            continue
        found.append({"file": path, "provenance": {key: _plain(of[key]) for key in of}})
        residual = f"{of.get('residual_rms', '-')} {of.get('unit', '')}"
        rows.append(
            (str(of["date"]), of["operator"], of.get("procedure", "-"),
             of.get("backend", "-"), residual, str(of.get("valid_until", "-")), str(path))
        )  # fmt: skip
    if as_json:
        print_json(found)
        return 0
    head = ("date", "operator", "procedure", "measured on", "residual rms", "valid until", "file")
    print_tables([Table(f"calibrations of {target}", head, rows)])
    return 0


def restore(search: Sequence[Path], rig: str, name: str, *, as_json: bool) -> int:
    """Put a kept calibration in force again, as this rig's; without a date, show what is kept."""
    from rig.calibration import store
    from rig.config import rig_name
    from rig.config.names import find_file, is_path, list_files
    from rig.config.ownership import owner_label

    target, slash, day = name.rpartition("/")
    if not slash:
        show_history(search, rig, name, as_json=as_json)
        click.echo(
            f"put one in force again with: rig calibrate {rig} --restore {name}/DATE", err=True
        )
        return 0
    known = is_path(rig) or rig in list_files("rigs", search)
    owner = owner_label([find_file(rig, "rigs", search)], search) if known else None
    path = store.restore(search, rig_name(rig, search), target, day, owner)
    click.echo(f"in force again: {path}", err=True)
    if as_json:
        print_json({"in_force": path})
    return 0


def show_difference(
    search: Sequence[Path], rig: str, one: str, other: str, *, as_json: bool
) -> int:
    """Show what two calibrations measured differently, and whether that is more than chance."""
    from rig.calibration.store import find, load
    from rig.config import format_quantity, rig_name

    of = rig_name(rig, search)
    paths = [find(search, of, name) for name in (one, other)]
    a, b = ({m["name"]: m for m in load(path)["measured"]} for path in paths)
    rows, found = [], []
    for name in [*a, *(name for name in b if name not in a)]:
        old, new = a.get(name), b.get(name)
        texts = ["-" if m is None else format_quantity(m["value"], m["unit"]) for m in (old, new)]
        found.append({"name": name, "a": _estimate(old), "b": _estimate(new)})
        if old is None or new is None:
            rows.append((name, *texts, "-", "-"))
            continue
        change = new["value"] - old["value"]
        spread = (old["std"] ** 2 + new["std"] ** 2) ** 0.5
        sigmas = f"{abs(change) / spread:.1f}" if spread else "-"
        rows.append((name, *texts, format_quantity(change, new["unit"]), sigmas))
    if as_json:
        print_json({"a": paths[0], "b": paths[1], "quantities": found})
        return 0
    print_data(f"A: {paths[0]}\nB: {paths[1]}")
    head = ("quantity", "A", "B", "change", "in its std")
    print_tables([Table("difference", head, rows)])
    return 0


def _plain(value: object) -> object:
    """Return a value of a file as JSON knows it: its dates as text."""
    return value.isoformat() if isinstance(value, date) else value


def _estimate(measured: Mapping[str, object] | None) -> dict[str, object] | None:
    return None if measured is None else {key: _plain(measured[key]) for key in measured}
