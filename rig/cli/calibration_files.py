"""What `rig calibrate` does with kept files: show them, compare two, put one in force again."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from rig.cli.tables import Table, print_data, print_json, print_tables, visible

if TYPE_CHECKING:
    from rig.config import Profile

Keys = tuple[str | int, ...]

PROFILE: Final = "profile"
"""In the place of a date: the profile's own values, without any calibration."""


def show_history(search: Sequence[Path], rig: str, target: str, *, as_json: bool) -> int:
    """Show every kept calibration of a device, also those that cannot be used."""
    from rig.calibration.store import history, load
    from rig.config import rig_name
    from rig.config.calibration import find_calibration
    from rig.hal import ConfigurationError

    name = rig_name(rig, search)
    kept = history(search, name, target)
    if not kept:
        raise ConfigurationError(f"no calibration of {target} of the rig {name} is kept")
    rows = []
    found: list[dict[str, object]] = []
    in_force = find_calibration(name, target, search)
    date_in_force = None if in_force is None else _date_of(in_force[0])
    for path in kept:
        try:
            of = load(path)["provenance"]
        except ConfigurationError as error:  # one that is damaged hides no other
            click.echo(visible(f"{path} cannot be used: {error}"), err=True)
            rows.append(("-",) * 7 + (str(path),))
            found.append({"file": path, "provenance": None, "in_force": False})
            continue
        is_used = str(of["date"]) == date_in_force
        plain = {key: _plain(of[key]) for key in of}
        found.append({"file": path, "provenance": plain, "in_force": is_used})
        residual = f"{of.get('residual_rms', '-')} {of.get('unit', '')}"
        rows.append(
            (str(of["date"]), of["operator"], of.get("procedure", "-"),
             of.get("backend", "-"), residual, str(of.get("valid_until", "-")),
             "yes" if is_used else "-", str(path))
        )  # fmt: skip
    if as_json:
        print_json(found)
        return 0
    own = "yes" if in_force is None else "-"
    rows.append((PROFILE, *("-",) * 5, own, "the profile's own values"))
    head = (
        "date", "operator", "procedure", "measured on", "residual rms", "valid until", "in force",
        "file",
    )  # fmt: skip
    print_tables([Table(f"calibrations of {target}", head, rows)])
    return 0


def _check_target(search: Sequence[Path], rig: str, target: str) -> None:
    """Refuse a name that nothing of a rig has, and of which nothing is kept; say the nearest."""
    from rig.assembly import REGISTRY
    from rig.calibration.store import kept_targets
    from rig.config import load_profile, rig_name
    from rig.config.diagnostics import nearest
    from rig.config.laid_over import TUNED
    from rig.config.names import is_path, list_files
    from rig.hal import ConfigurationError

    names = set(kept_targets(search, rig_name(rig, search)))
    if is_path(rig) or rig in list_files("rigs", search):
        with contextlib.suppress(ConfigurationError):  # what is wrong with it is said elsewhere
            profile = load_profile(rig, REGISTRY, (), search)
            laws = [f"{TUNED}{law}" for law in profile.controllers]
            names |= {*profile.devices, profile.mechanism, *laws}
    if names and target not in names:
        raise ConfigurationError(
            f"no part of the rig {rig} that could be calibrated is called {target}; "
            f"{nearest(target, names)}"
        )


def restore(search: Sequence[Path], rig: str, name: str, *, as_json: bool) -> int:
    """Put a kept calibration in force again, as this rig's; without a date, show what is kept."""
    from rig.calibration import put_back
    from rig.config import rig_name
    from rig.config.names import find_file, is_path, list_files
    from rig.config.ownership import owner_label

    target, slash, day = name.rpartition("/")
    _check_target(search, rig, target or name)
    if not slash:
        show_history(search, rig, name, as_json=as_json)
        click.echo(
            f"put one in force again with: rig calibrate {rig} --restore {name}/DATE, and the "
            f"profile's own values with {name}/{PROFILE}",
            err=True,
        )
        return 0
    if day == PROFILE:
        path = put_back.take_back(search, rig_name(rig, search), target)
        click.echo(f"in force again: the profile's own values; {path} is kept", err=True)
        if as_json:
            print_json({"in_force": None})
        return 0
    known = is_path(rig) or rig in list_files("rigs", search)
    owner = owner_label([find_file(rig, "rigs", search)], search) if known else None
    path = put_back.restore(search, rig_name(rig, search), target, day, owner)
    click.echo(f"in force again: {path}", err=True)
    if as_json:
        print_json({"in_force": path})
    return 0


def show_difference(
    search: Sequence[Path], rig: str, one: str, other: str, *, as_json: bool
) -> int:
    """Show what two calibrations measured differently, and whether that is more than chance.

    One of them may be the profile's own values.
    """
    from rig.calibration.store import find, load
    from rig.config import format_quantity, rig_name

    if PROFILE in (one, other):
        return _show_beside_profile(search, rig, one, other, as_json=as_json)
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


def _show_beside_profile(
    search: Sequence[Path], rig: str, one: str, other: str, *, as_json: bool
) -> int:
    """Show what a calibration lays over the profile beside the profile's own values."""
    from rig.assembly import REGISTRY
    from rig.calibration.store import find, load
    from rig.config import load_profile
    from rig.config.calibration import HISTORY

    own = load_profile(rig, REGISTRY, ["calibration=false"], search)
    path = find(search, own.name, other if one == PROFILE else one)
    target = path.parent.name if path.parent.parent.name == HISTORY else path.stem
    settings = _settings_of(own, target)
    rows, found = [], []
    for keys, value in _leaves(load(path)["values"]):
        pair = [_said(settings, keys, value), _said(settings, keys, _own_value(settings, keys))]
        a, b = reversed(pair) if one == PROFILE else pair
        name = ".".join(map(str, keys))
        rows.append((name, a, b))
        found.append({"name": name, "a": a, "b": b})
    a_file, b_file = (PROFILE, path) if one == PROFILE else (path, PROFILE)
    if as_json:
        print_json({"a": a_file, "b": b_file, "quantities": found})
        return 0
    print_data(f"A: {a_file}\nB: {b_file}")
    print_tables([Table("difference", ("setting", "A", "B"), rows)])
    return 0


def _settings_of(profile: Profile, target: str) -> object:
    """Return the settings that a calibration of a target is laid over."""
    from rig.config.laid_over import TUNED
    from rig.hal import ConfigurationError

    known: dict[str, object] = {
        profile.mechanism: profile.mechanism_settings,
        **{name: entry.settings for name, entry in profile.devices.items()},
        **{f"{TUNED}{law}": settings for law, settings in profile.controllers.items()},
    }
    if target not in known:
        raise ConfigurationError(
            f"the profile {profile.name} has nothing that is called {target}: {', '.join(known)}"
        )
    return known[target]


def _leaves(values: object, keys: Keys = ()) -> Iterator[tuple[Keys, object]]:
    if isinstance(values, Mapping):
        for key, below in values.items():
            yield from _leaves(below, (*keys, str(key)))
    else:
        yield keys, values


def _own_value(settings: object, keys: Keys) -> object:
    for key in keys:
        settings = (
            settings.get(key) if isinstance(settings, dict) else getattr(settings, str(key), None)
        )
    return settings


def _said(settings: object, keys: Keys, value: object) -> str:
    """Return a value with its unit: of the file, where it may be text, or of the settings."""
    from rig.config.basis import say
    from rig.config.quantities import UnitError, parse_quantity
    from rig.config.type_hints import hint_at, unit_of

    hint = hint_at(type(settings), keys)
    unit = unit_of(hint)
    if isinstance(value, list | tuple):
        return ", ".join(_said(settings, (*keys, n), item) for n, item in enumerate(value))
    if isinstance(value, str) and unit is not None:
        with contextlib.suppress(UnitError):  # a file of another version is shown as it is
            value = parse_quantity(value, unit)
    return say(value, hint)


def _date_of(path: Path) -> str | None:
    from rig.calibration.store import load
    from rig.hal import ConfigurationError

    try:
        return str(load(path)["provenance"]["date"])
    except ConfigurationError:
        return None


def _plain(value: object) -> object:
    """Return a value of a file as JSON knows it: its dates as text."""
    return value.isoformat() if isinstance(value, date) else value


def _estimate(measured: Mapping[str, object] | None) -> dict[str, object] | None:
    return None if measured is None else {key: _plain(measured[key]) for key in measured}
