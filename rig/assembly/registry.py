"""The names that profiles and experiments may use, and what is behind them.

Each mechanism, driver and bus protocol is one row here, the path of its `rig.hal.parts`; other
packages add theirs by entry points (``rig.mechanisms``, ``rig.drivers``, ``rig.protocols``,
``rig.additions``). No import has a side effect: a row is loaded when somebody asks for it.
"""

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar, cast

from rig.assembly.contract_check import (
    check_class,
    check_kind,
    check_offers,
    check_settings,
    check_table,
)
from rig.assembly.rows import InstalledRows, collect, find_row, load
from rig.config.named_settings import Kind
from rig.config.settings import adapter
from rig.hal import (
    ConfigurationError,
    ContractBroken,
    CyclicBus,
    Device,
    DriverSettings,
    Mechanism,
    Plant,
)
from rig.hal.bench import TuningBench
from rig.hal.controller import Law
from rig.hal.driver import BusSettings
from rig.hal.hazards import Hazard
from rig.hal.parts import Additions, DriverParts, MechanismParts, ProtocolParts
from rig.hal.plant import PhysicsSettings
from rig.hal.scene import Scene

Thing = TypeVar("Thing")

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


class InstalledParts:
    """Everything that a profile or experiment may name; implements `rig.config.Registry`."""

    # Rows -----------------------------------------------------------------------------

    def mechanism(self, name: str) -> MechanismParts:
        """Return the row of a mechanism; KeyError if there is none."""
        found: MechanismParts = find_row(_mechanisms(), name)
        return found

    def driver(self, name: str) -> DriverParts:
        """Return the row of a driver; KeyError if there is none."""
        found: DriverParts = find_row(_drivers(), name)
        return found

    def protocol(self, name: str) -> ProtocolParts:
        """Return the row of what is spoken on a bus; KeyError if there is none."""
        found: ProtocolParts = find_row(_protocols(), name)
        return found

    def broken(self) -> tuple[str, ...]:
        """Return why what is installed cannot be used, a sentence each: its names are missing."""
        found = (_mechanisms(), _drivers(), _protocols(), _foreign_additions())
        return (*(why for rows in found for why in rows.broken.values()), *_TWICE.values())

    # Names ----------------------------------------------------------------------------

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted."""
        return tuple(sorted(_code(kind)))

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name; KeyError if there is none."""
        code = _code_of(kind, name)
        path = code.settings or f"{code.path}.Settings"
        found: type[Any] = load(path, f"{kind} {name}: ")
        what = f"{kind} {name}: {path}"
        check_settings(what, found, _SETTINGS_OF.get(kind, object))
        try:
            adapter(cast("type", found))
        except Exception as error:  # of the types that somebody has annotated
            raise ContractBroken(f"{what}: {error}") from error
        return found

    def load(self, kind: Kind, name: str) -> Any:
        """Return the class behind a name; KeyError if there is none.

        Raises
        ------
        ConfigurationError
            It is not what the contract says.
        """
        path = _code_of(kind, name).path
        found = load(path, f"{kind} {name}: ")
        protocols = _PROTOCOLS_OF.get(kind, ())
        if kind == "controller":
            protocols = (*protocols, load(self.mechanism(name.partition("/")[0]).view).law)
        for protocol in protocols:
            check_class(f"{kind} {name}: {path}", found, protocol)
        return found

    def hazards(self, plant: str) -> Callable[[Any], tuple[Hazard, ...]] | None:
        """Return what makes the hazards of a plant of a mechanism's settings, if anything does."""
        for row in _additions():
            if plant in row.plants and (path := row.plants[plant].hazards) is not None:
                found: Callable[[Any], tuple[Hazard, ...]] = load(path)
                if not callable(found):
                    raise ConfigurationError(f"plant {plant}: {path} is no function of settings")
                return found
        return None

    def plants(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the plants of a mechanism."""
        rows = (row for row in _additions() if row.mechanism == mechanism)
        return tuple(name for row in rows for name in row.plants)

    def references(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the references that a mechanism follows."""
        rows = (row for row in _additions() if row.mechanism == mechanism)
        return tuple(name for row in rows for name in row.references)

    def is_restorable(self, plant: str) -> bool:
        """Return whether a plant can be taken back to where it was."""
        rows = [row.plants[plant] for row in _additions() if plant in row.plants]
        return any(row.is_restorable for row in rows)

    def lends_kernel(self, plant: str) -> bool:
        """Return whether a plant lends its kernel to loops that are compiled as a whole."""
        rows = [row.plants[plant] for row in _additions() if plant in row.plants]
        return any(row.lends_kernel for row in rows)

    def bench(self, mechanism: str) -> type[TuningBench] | None:
        """Return what `rig tune` tries gains of a mechanism on; None: there is nothing."""
        path = self.mechanism(mechanism).bench
        if path is None:
            return None
        found: type[TuningBench] = load(path, f"mechanism {mechanism}: ")
        check_offers(f"mechanism {mechanism}: {path}", found, TuningBench)
        return found

    def commissioning(self, mechanism: str, protocol: type[Thing]) -> Sequence[Thing]:
        """Return the steps of a mechanism's acceptance test; empty if it has none.

        Parameters
        ----------
        mechanism : str
            Its name.
        protocol : type
            `rig.commissioning.step.AcceptanceStep`.
        """
        path = self.mechanism(mechanism).commissioning
        if path is None:
            return ()
        steps: Sequence[Thing] = load(path, f"mechanism {mechanism}: ")()
        for step in steps:
            check_offers(f"mechanism {mechanism}: {path}", step, protocol)
        return steps

    def scene(self, mechanism: str) -> type[Scene] | None:
        """Return what `rig watch` draws of a mechanism; None: it gives no picture of itself."""
        path = self.mechanism(mechanism).scene
        if path is None:
            return None
        found: type[Scene] = load(path, f"mechanism {mechanism}: ")
        check_class(f"mechanism {mechanism}: {path}", found, Scene)
        return found

    # What mechanisms add to the frameworks ----------------------------------------------

    def measures(self, mechanism: str | None, kind: type[Thing]) -> Mapping[str, Thing]:
        """Return every measure by name.

        Parameters
        ----------
        mechanism : str, optional
            Whose own go before those of others.
        kind : type
            `rig.experiment.measure.Measure`.
        """
        return _merged("measure", lambda row: row.measures, mechanism, kind)

    def own_measures(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of one mechanism's measures."""
        rows = [row for row in _additions() if row.mechanism == mechanism]
        return tuple(name for row in rows for path in row.measures for name in load(path))

    def reported(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the measures that every run of a mechanism reports."""
        return tuple(n for row in _additions() if row.mechanism == mechanism for n in row.reported)

    def figures(self, mechanism: str | None, kind: type[Thing]) -> Mapping[str, Thing]:
        """Return every mechanism's figures by name, which are `rig.report.figure.FigureKind`."""
        return _merged("figure", lambda row: row.figures, mechanism, kind)

    def own_figures(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of one mechanism's figures."""
        rows = [row for row in _additions() if row.mechanism == mechanism]
        return tuple(name for row in rows for path in row.figures for name in load(path))

    def comparisons(self, mechanism: str | None, kind: type[Thing]) -> tuple[Thing, ...]:
        """Return a mechanism's comparisons, or everybody's; the most particular first."""
        return tuple(
            check_kind(f"comparison: {path}", load(path), kind)
            for row in reversed(_additions())
            if mechanism is None or row.mechanism == mechanism
            for path in row.comparisons
        )

    def procedures(self, mechanism: str, protocol: type[Thing]) -> Mapping[str, Thing]:
        """Return a mechanism's procedures by path, in the order they build on each other."""
        return {
            path: _made_procedure(path, protocol)
            for row in _additions()
            if row.mechanism == mechanism
            for path in row.procedures
        }


# Rows -----------------------------------------------------------------------------------


_TWICE: dict[str, str] = {}
"""Measures and figures that two packages have for one mechanism, and which they are."""


# Looked up once: what is installed does not change while a program runs.
@functools.cache
def _mechanisms() -> InstalledRows:
    return collect(MECHANISMS, "rig.mechanisms", MechanismParts)


@functools.cache
def _drivers() -> InstalledRows:
    return collect(DRIVERS, "rig.drivers", DriverParts)


@functools.cache
def _protocols() -> InstalledRows:
    return collect(PROTOCOLS, "rig.protocols", ProtocolParts)


@functools.cache
def _additions() -> tuple[Additions, ...]:
    """Return what is known of every mechanism: its own row first, then what others add to it."""
    return (*_mechanisms().rows.values(), *_foreign_additions().rows.values())


@functools.cache
def _foreign_additions() -> InstalledRows:
    return collect({}, "rig.additions", Additions)


# Code behind names ----------------------------------------------------------------------


class _Code(NamedTuple):
    """The place of the code behind a name, and of its settings where they are apart from it."""

    path: str
    settings: str | None


def _code_of(kind: Kind, name: str) -> _Code:
    try:
        first, *others = _code(kind)[name]
    except KeyError:
        for found in _ROWS_OF.get(kind, ()):
            find_row(found(), name)  # an installed row that is broken says why
        raise
    for other in others:  # said where the name is used: it is no concern of other rigs
        raise ConfigurationError(
            f"two packages have a {kind} {name!r}: {first.path} and {other.path}"
        )
    return first


@functools.cache
def _code(kind: Kind) -> Mapping[str, list[_Code]]:
    """Return what is behind each name; it is one thing, if no two packages took the name."""
    found: dict[str, list[_Code]] = {}
    for name, code in _CODE_OF[kind]():
        if code not in found.setdefault(name, []):
            found[name].append(code)
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


_PROTOCOLS_OF: dict[Kind, tuple[type, ...]] = {
    "mechanism": (Mechanism,),
    "driver": (Device,),
    "bus": (CyclicBus,),
    "plant": (Plant,),
    "controller": (Law,),
}
_SETTINGS_OF: dict[Kind, type] = {
    "driver": DriverSettings,
    "bus": BusSettings,
    "plant": PhysicsSettings,
}
_ROWS_OF: dict[Kind, Sequence[Callable[[], InstalledRows]]] = {
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


def _merged(
    kind: str,
    paths_of: Callable[[Additions], tuple[str, ...]],
    mechanism: str | None,
    type_of: type[Thing],
) -> Mapping[str, Thing]:
    """Return the union of the mappings that rows name, in the order of the rows.

    What others call by the same name as a mechanism's own does not concern it, or a package could
    break the rigs of all others. A name that two packages have for one mechanism is left out: only
    who uses it has to know why.
    """
    found: dict[str, Thing] = {}
    own: dict[str, str] = {}
    for row in _additions():
        for path in paths_of(row):
            for name, thing in check_table(f"{kind}s: {path}", load(path), type_of).items():
                if row.mechanism != mechanism:
                    found.setdefault(name, thing)
                elif own.setdefault(name, path) == path:
                    found[name] = thing
                else:
                    _TWICE[name] = f"two packages have a {kind} {name!r}: {own[name]} and {path}"
    return {name: thing for name, thing in found.items() if name not in _TWICE}


def _made_procedure(path: str, protocol: type[Thing]) -> Thing:
    make = load(path)
    if isinstance(make, type):  # else something that calls one
        check_class(f"procedure: {path}", make, protocol)
    made: Thing = make()
    check_offers(f"procedure: {path}", made, protocol)
    return made


REGISTRY = InstalledParts()
