"""The names that profiles and experiments may use, and what is behind them.

Each mechanism, driver and bus protocol is one row here, the path of its `rig.hal.parts`; other
packages add theirs by entry points (``rig.mechanisms``, ``rig.drivers``, ``rig.protocols``,
``rig.additions``). No import has a side effect: a row is loaded when somebody asks for it.
"""

import functools
import importlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NamedTuple, TypeVar

from rig.config.named_settings import Kind
from rig.hal import ConfigurationError
from rig.hal.parts import Additions, DriverParts, MechanismParts, ProtocolParts

Row = TypeVar("Row", Additions, DriverParts, ProtocolParts)

MECHANISMS = {
    "cylinder": "rig.mechanisms.cylinder.parts:PARTS",
    "joint": "rig.mechanisms.joint.parts:PARTS",
    "legs": "rig.mechanisms.legs.parts:PARTS",
    "arm": "rig.mechanisms.arm.parts:PARTS",
}
DRIVERS = {
    "cia401": "drivers.cia401.parts:PARTS",
    "cia406": "drivers.cia406.parts:PARTS",
    "cia402": "drivers.cia402.parts:PARTS",
    "odrive": "drivers.odrive.parts:PARTS",
    "dynamixel": "drivers.dynamixel.parts:PARTS",
    "marker-camera": "drivers.marker_camera.parts:PARTS",
}
PROTOCOLS = {
    "canopen": "drivers.canopen.parts:PROTOCOL",
    "cansimple": "drivers.odrive.parts:PROTOCOL",
    "dynamixel": "drivers.dynamixel.parts:PROTOCOL",
}


def load(path: str) -> Any:
    """Import what a path names, ``"module:name"``.

    Raises
    ------
    ConfigurationError
        There is no such module or no such name in it.
    """
    module, _, name = path.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(f"{path} cannot be imported: {error}") from error
    return found


class InstalledParts:
    """Everything that a profile or experiment may name; implements `rig.config.Registry`."""

    # Rows -----------------------------------------------------------------------------

    def mechanism(self, name: str) -> MechanismParts:
        """Return the row of a mechanism; KeyError if there is none."""
        found: MechanismParts = _find(_mechanisms(), name)
        return found

    def driver(self, name: str) -> DriverParts:
        """Return the row of a driver; KeyError if there is none."""
        found: DriverParts = _find(_drivers(), name)
        return found

    def protocol(self, name: str) -> ProtocolParts:
        """Return the row of what is spoken on a bus; KeyError if there is none."""
        found: ProtocolParts = _find(_protocols(), name)
        return found

    # Names ----------------------------------------------------------------------------

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted."""
        return tuple(sorted(_code(kind)))

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name; KeyError if there is none."""
        code = _code_of(kind, name)
        if code.settings is not None:
            found: type[Any] = load(code.settings)
            return found
        thing = load(code.path)
        try:
            found = thing.Settings
        except AttributeError:
            raise ConfigurationError(
                f"{kind} {name}: {code.path} has no Settings, the dataclass of its section"
            ) from None
        return found

    def load(self, kind: Kind, name: str) -> Any:
        """Return the class behind a name; KeyError if there is none."""
        return load(_code_of(kind, name).path)

    # What mechanisms add to the frameworks ----------------------------------------------

    def measures(self) -> Mapping[str, Any]:
        """Return every `rig.experiment.measure.Measure` by name."""
        return _merged("measure", lambda row: row.measures)

    def figures(self) -> Mapping[str, Any]:
        """Return every mechanism's `rig.report.figure.FigureKind` by name."""
        return _merged("figure", lambda row: row.figures)

    def comparisons(self) -> tuple[Any, ...]:
        """Return every `rig.report.comparison.Comparison`, the most particular first."""
        return tuple(load(path) for row in reversed(_additions()) for path in row.comparisons)

    def procedures(self, mechanism: str) -> tuple[Any, ...]:
        """Return a mechanism's procedures, in the order in which they build on each other."""
        return tuple(
            load(path)()
            for row in _additions()
            if row.mechanism == mechanism
            for path in row.procedures
        )


# Rows -----------------------------------------------------------------------------------


class _Rows(NamedTuple):
    """Rows of one kind by name, and why others that are installed cannot be used."""

    rows: dict[str, Any]
    broken: dict[str, str]


def _find(found: _Rows, name: str) -> Any:
    if name in found.broken:
        raise ConfigurationError(found.broken[name])
    return found.rows[name]


def _collect(own: Mapping[str, str], group: str, kind: type[Row]) -> _Rows:
    found = _Rows({name: load(path) for name, path in own.items()}, {})
    for point in entry_points(group=group):
        try:
            row = _loaded(point, kind)
        except ConfigurationError as error:
            found.broken[point.name] = str(error)
            continue
        if point.name in found.rows:
            found.broken[point.name] = f"{_whose(point)}: the name {point.name!r} is taken"
        else:
            found.rows[point.name] = row
    return found


def _loaded(point: EntryPoint, kind: type[Row]) -> Row:
    try:
        row = point.load()
    except Exception as error:  # anything may happen in the code of others
        raise ConfigurationError(f"{_whose(point)} cannot be loaded: {error}") from error
    if not isinstance(row, kind):
        raise ConfigurationError(
            f"{_whose(point)}: {point.value} is a {type(row).__name__}, not a {kind.__name__}"
        )
    return row


def _whose(point: EntryPoint) -> str:
    package = "a package" if point.dist is None else f"the package {point.dist.name}"
    return f"{package} (entry point {point.name!r} of {point.group})"


# Looked up once: what is installed does not change while a program runs.
@functools.cache
def _mechanisms() -> _Rows:
    return _collect(MECHANISMS, "rig.mechanisms", MechanismParts)


@functools.cache
def _drivers() -> _Rows:
    return _collect(DRIVERS, "rig.drivers", DriverParts)


@functools.cache
def _protocols() -> _Rows:
    return _collect(PROTOCOLS, "rig.protocols", ProtocolParts)


@functools.cache
def _additions() -> tuple[Additions, ...]:
    """Return what is known of every mechanism: its own row first, then what others add to it."""
    others = _collect({}, "rig.additions", Additions)
    return (*_mechanisms().rows.values(), *others.rows.values())


# Code behind names ----------------------------------------------------------------------


class _Code(NamedTuple):
    """Where the code behind a name is, and its settings where they are apart from it."""

    path: str
    settings: str | None


def _code_of(kind: Kind, name: str) -> _Code:
    try:
        return _code(kind)[name]
    except KeyError:
        for found in _ROWS_OF.get(kind, ()):
            _find(found(), name)  # an installed row that is broken says why
        raise


@functools.cache
def _code(kind: Kind) -> Mapping[str, _Code]:
    found: dict[str, _Code] = {}
    for name, code in _CODE_OF[kind]():
        if found.setdefault(name, code) != code:
            raise ConfigurationError(
                f"two packages have a {kind} {name!r}: {found[name].path} and {code.path}"
            )
    return found


def _controllers() -> Iterator[tuple[str, _Code]]:
    for row in _additions():
        for name, path in row.controllers.items():
            yield f"{row.mechanism}/{name}", _Code(path, None)


def _plants() -> Iterator[tuple[str, _Code]]:
    for row in _additions():
        for name, model in row.plants.items():
            yield name, _Code(model.plant, model.settings)


def _references() -> Iterator[tuple[str, _Code]]:
    for row in _additions():
        for name, path in row.references.items():
            yield name, _Code(path, path)


_ROWS_OF: dict[Kind, Sequence[Callable[[], _Rows]]] = {
    "mechanism": (_mechanisms,),
    "driver": (_drivers,),
    "bus": (_protocols,),
}
_CODE_OF: dict[Kind, Callable[[], Iterator[tuple[str, _Code]]]] = {
    "mechanism": lambda: (
        (name, _Code(row.view, row.settings)) for name, row in _mechanisms().rows.items()
    ),
    "driver": lambda: (
        (name, _Code(row.device, row.settings)) for name, row in _drivers().rows.items()
    ),
    "bus": lambda: (
        (name, _Code(row.bus, row.settings)) for name, row in _protocols().rows.items()
    ),
    "controller": _controllers,
    "plant": _plants,
    "reference": _references,
}


def _merged(kind: str, paths_of: Callable[[Additions], tuple[str, ...]]) -> Mapping[str, Any]:
    """Return the union of the mappings that rows name, in the order of the rows."""
    found: dict[str, Any] = {}
    for row in _additions():
        for path in paths_of(row):
            for name, thing in load(path).items():
                if found.setdefault(name, thing) is not thing:
                    raise ConfigurationError(f"two packages have a {kind} {name!r}; one is {path}")
    return found


REGISTRY = InstalledParts()
