"""What is offered by name: rows of our own and of other packages, and the code behind each name.

Each mechanism, driver and bus protocol is one row here, the path of its `rig.hal.parts`; other
packages add theirs by entry points (``rig.mechanisms``, ``rig.drivers``, ``rig.protocols``,
``rig.additions``). A row of another package is imported only when a file names it: a mechanism,
driver or protocol by using it, additions by the profile's ``additions``.
"""

import contextlib
import functools
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from rig.assembly.rows import InstalledRows
from rig.config.named_settings import Kind
from rig.hal import ConfigurationError
from rig.hal.parts import Additions, DriverParts, MechanismParts, ProtocolParts

MECHANISMS = {
    "cylinder": "rig.mechanisms.cylinder.parts:PARTS",
    "joint": "rig.mechanisms.joint.parts:PARTS",
    "legs": "rig.mechanisms.legs.parts:PARTS",
    "arm": "rig.mechanisms.arm.parts:PARTS",
}
DRIVERS = {
    "cia401": "drivers.cia401.parts:PARTS",
    "cia401-valves": "drivers.cia401.parts:VALVES",
    "cia406": "drivers.cia406.parts:PARTS",
    "cia402": "drivers.cia402.parts:PARTS",
    "cia410": "drivers.cia410.parts:PARTS",
    "load-cells": "drivers.load_cells.parts:PARTS",
    "odrive": "drivers.odrive.parts:PARTS",
    "dynamixel": "drivers.dynamixel.parts:PARTS",
    "marker-camera": "drivers.marker_camera.parts:PARTS",
}
PROTOCOLS = {
    "canopen": "drivers.canopen.parts:PROTOCOL",
    "cansimple": "drivers.odrive.parts:PROTOCOL",
    "dynamixel": "drivers.dynamixel.parts:PROTOCOL",
}


# Looked up once: what is installed does not change while a program runs.
@functools.cache
def mechanisms() -> InstalledRows[MechanismParts]:
    """Return the rows of mechanisms."""
    return InstalledRows(MECHANISMS, "rig.mechanisms", MechanismParts)


@functools.cache
def drivers() -> InstalledRows[DriverParts]:
    """Return the rows of drivers."""
    return InstalledRows(DRIVERS, "rig.drivers", DriverParts)


@functools.cache
def protocols() -> InstalledRows[ProtocolParts]:
    """Return the rows of protocols."""
    return InstalledRows(PROTOCOLS, "rig.protocols", ProtocolParts)


@functools.cache
def foreign_additions() -> InstalledRows[Additions]:
    """Return the rows of what packages add to mechanisms of others."""
    return InstalledRows({}, "rig.additions", Additions)


def additions() -> tuple[Additions, ...]:
    """Return what is known of every mechanism: its own row first, then what others add to it."""
    return (*mechanisms().imported().values(), *foreign_additions().imported().values())


def additions_to(mechanism: str) -> tuple[Additions, ...]:
    """Return what is known of one mechanism, whose name is reason enough to import its row."""
    with contextlib.suppress(KeyError, ConfigurationError):
        mechanisms().find(mechanism)
    return tuple(row for row in additions() if row.mechanism == mechanism)


# Code behind names ----------------------------------------------------------------------


class Code(NamedTuple):
    """The place of the code behind a name, and of its settings where they are apart from it."""

    path: str
    settings: str | None


def installed_names(kind: Kind) -> tuple[str, ...]:
    """Return the names of a kind, sorted; also those of packages that no file has named."""
    installed = _ROWS_OF[kind]().names() if kind in _ROWS_OF else ()
    return tuple(sorted({*codes(kind), *installed}))


def code_of(kind: Kind, name: str) -> Code:
    """Return what is behind a name; KeyError if there is none.

    Raises
    ------
    ConfigurationError
        It cannot be imported, or two packages took the name.
    """
    if kind in _ROWS_OF:
        _ROWS_OF[kind]().find(name)  # which imports it, or says why that is not possible
    first, *others = codes(kind)[name]
    for other in others:  # said where the name is used: it is no concern of other rigs
        raise ConfigurationError(
            f"two packages have a {kind} {name!r}: {first.path} and {other.path}"
        )
    return first


def codes(kind: Kind) -> Mapping[str, list[Code]]:
    """Return what is behind each name; it is one thing, if no two packages took the name."""
    found: dict[str, list[Code]] = {}
    for name, code in _CODE_OF[kind]():
        if code not in found.setdefault(name, []):
            found[name].append(code)
    return found


def _controllers() -> Iterator[tuple[str, Code]]:
    for row in additions():
        for name, path in row.controllers.items():
            yield f"{row.mechanism}/{name}", Code(path, None)


def _plants() -> Iterator[tuple[str, Code]]:
    for row in additions():
        for name, model in row.plants.items():
            yield name, Code(model.plant, model.settings)


def _references() -> Iterator[tuple[str, Code]]:
    for row in additions():
        for name, path in row.references.items():
            yield name, Code(path, path)


_ROWS_OF: dict[Kind, Callable[[], InstalledRows[Any]]] = {
    "mechanism": mechanisms,
    "driver": drivers,
    "bus": protocols,
}
_CODE_OF: dict[Kind, Callable[[], Iterator[tuple[str, Code]]]] = {
    "mechanism": lambda: (
        (name, Code(row.view, row.settings)) for name, row in mechanisms().imported().items()
    ),
    "driver": lambda: (
        (name, Code(row.device, row.settings)) for name, row in drivers().imported().items()
    ),
    "bus": lambda: (
        (name, Code(row.bus, row.settings)) for name, row in protocols().imported().items()
    ),
    "controller": _controllers,
    "plant": _plants,
    "reference": _references,
}
