"""Rows of `rig.hal.parts`: those of this program, and those that other packages have installed."""

import importlib
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from typing import Any, Generic, TypeVar

from rig.assembly.contract_check import check_row
from rig.hal import ConfigurationError
from rig.hal.parts import Additions, DriverParts, ProtocolParts
from rig.installation import missing_package
from rig.plug_ins import entry_points, note_import

Row = TypeVar("Row", bound=Additions | DriverParts | ProtocolParts)


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
    note_import(module)
    try:
        found: object = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:  # anything may happen in the code of others
        why = missing_package(error) or error
        raise ConfigurationError(f"{what}{path} cannot be imported: {why}") from error
    return found


class InstalledRows(Generic[Row]):
    """Rows of one kind: our own, and those of other packages, whose code runs when it is named.

    What is installed is read off the packages' metadata, which runs nothing.

    Parameters
    ----------
    own : mapping of str to str
        Paths of our own rows by name.
    group : str
        Of the entry points by which other packages offer theirs.
    kind : type
        What a row must be.
    """

    def __init__(self, own: Mapping[str, str], group: str, kind: type[Row]) -> None:
        self._own, self._kind = own, kind
        self._points: dict[str, list[EntryPoint]] = {}
        self._named: dict[str, Row] = {}
        self.broken: dict[str, str] = {}
        """Why what is installed and was asked for cannot be used, by name."""
        try:
            points = tuple(entry_points(group=group))
        except Exception as error:  # a file of some package that is none
            points = ()
            why = f"the entry points of an installed package cannot be read: {error}"
            self.broken[group] = why
        for point in points:
            self._points.setdefault(point.name, []).append(point)

    def names(self) -> tuple[str, ...]:
        """Return every name, also of what nobody has named yet; not those that two have taken."""
        names = dict.fromkeys((*self._own, *self._points))
        return tuple(name for name in names if len(self._takers(name)) == 1)

    def find(self, name: str) -> Row:
        """Return a row, which is imported if it is the first time that it is asked for.

        Raises
        ------
        KeyError
            There is none of that name.
        ConfigurationError
            It cannot be imported or is none; or two packages took the name, which is nobody's.
        """
        if name in self.broken:
            raise ConfigurationError(self.broken[name])
        if name not in self._named:
            self._named[name] = self._imported(name)
        return self._named[name]

    def imported(self) -> Mapping[str, Row]:
        """Return our own rows, and those of others that were asked for."""
        for name in self._own:
            if len(self._takers(name)) == 1:
                self.find(name)
        return {name: row for name, row in self._named.items() if name not in self.broken}

    def unnamed(self) -> tuple[str, ...]:
        """Return what other packages offer and nobody has asked for: each name, and whose it is."""
        return tuple(
            f"{name} of {_package(points[0])}"
            for name, points in sorted(self._points.items())
            if name not in self._named
        )

    def _takers(self, name: str) -> list[str]:
        own = [f"this program ({self._own[name]})"] if name in self._own else []
        return [*own, *map(_whose, self._points.get(name, ()))]

    def _imported(self, name: str) -> Row:
        takers = self._takers(name)
        if not takers:
            raise KeyError(name)
        try:
            if len(takers) > 1:
                who = ", and by ".join(takers)
                raise ConfigurationError(f"the name {name!r} is taken twice: by {who}")
            if name in self._own:
                row: Row = load(self._own[name])
                return row
            return _loaded(self._points[name][0], self._kind)
        except ConfigurationError as error:
            self.broken[name] = str(error)
            raise


def _loaded(point: EntryPoint, kind: type[Row]) -> Row:
    try:
        row = point.load()
    except (Exception, SystemExit) as error:  # anything may happen in the code of others
        why = missing_package(error) or error
        raise ConfigurationError(f"{_whose(point)} cannot be loaded: {why}") from error
    if not isinstance(row, kind):
        raise ConfigurationError(
            f"{_whose(point)}: {point.value} is a {type(row).__name__}, not a {kind.__name__}"
        )
    check_row(_whose(point), row)
    return row


def _whose(point: EntryPoint) -> str:
    return f"{_package(point)} (entry point {point.name!r} of {point.group})"


def _package(point: EntryPoint) -> str:
    return "a package" if point.dist is None else f"the package {point.dist.name}"
