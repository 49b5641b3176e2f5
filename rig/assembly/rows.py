"""Rows of `rig.hal.parts`: those of this program, and those that other packages have installed."""

import importlib
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NamedTuple, TypeVar

from rig.assembly.contract_check import check_row
from rig.hal import ConfigurationError
from rig.hal.parts import Additions, DriverParts, ProtocolParts

Row = TypeVar("Row", Additions, DriverParts, ProtocolParts)


def load(path: object, what: str = "") -> Any:
    """Import what a path names, ``"module:name"``; `what` says in messages whose it is.

    Raises
    ------
    ConfigurationError
        There is no such module or no such name in it, its import fails, or it is no path.
    """
    if not isinstance(path, str):
        raise ConfigurationError(f"{path!r} stands in a row where a path, 'module:name', belongs")
    module, _, name = path.partition(":")
    try:
        found: object = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:  # anything may happen in the code of others
        raise ConfigurationError(f"{what}{path} cannot be imported: {error}") from error
    return found


class InstalledRows(NamedTuple):
    """Rows of one kind by name, and why others that are installed cannot be used."""

    rows: dict[str, Any]
    broken: dict[str, str]


def find_row(found: InstalledRows, name: str) -> Any:
    """Return a row; a name that two packages took is nobody's, and fails where it is used."""
    if name in found.broken:
        raise ConfigurationError(found.broken[name])
    return found.rows[name]


def collect(own: Mapping[str, str], group: str, kind: type[Row]) -> InstalledRows:
    """Return the rows of a kind: our own, and those of the entry points of a group."""
    found = InstalledRows({name: load(path) for name, path in own.items()}, {})
    takers = {name: f"this program ({path})" for name, path in own.items()}
    try:
        points = tuple(entry_points(group=group))
    except Exception as error:  # a file of some package that is none
        found.broken[group] = f"the entry points of an installed package cannot be read: {error}"
        return found
    for point in points:
        # Nobody uses the name of an addition: two packages may well have the same.
        name = f"{point.name} ({point.value})" if kind is Additions else point.name
        try:
            row = _loaded(point, kind)
        except ConfigurationError as error:
            found.broken[name] = str(error)
            continue
        if name in takers:
            found.rows.pop(name, None)
            found.broken[name] = (
                f"the name {name!r} is taken twice: by {takers[name]}, and by {_whose(point)}"
            )
        else:
            found.rows[name], takers[name] = row, _whose(point)
    return found


def _loaded(point: EntryPoint, kind: type[Row]) -> Row:
    try:
        row = point.load()
    except (Exception, SystemExit) as error:  # anything may happen in the code of others
        raise ConfigurationError(f"{_whose(point)} cannot be loaded: {error}") from error
    if not isinstance(row, kind):
        raise ConfigurationError(
            f"{_whose(point)}: {point.value} is a {type(row).__name__}, not a {kind.__name__}"
        )
    check_row(_whose(point), row)
    return row


def _whose(point: EntryPoint) -> str:
    package = "a package" if point.dist is None else f"the package {point.dist.name}"
    return f"{package} (entry point {point.name!r} of {point.group})"
