"""Whether what was loaded is what the contract says: what it lacks is a sentence with its name.

Anybody's code may be behind a name. It is asked once, when it is loaded; what nobody asked shows as
an error from deep inside, which is then told from a bug of this program by whose code raised it.
"""

import traceback
from collections.abc import Mapping
from dataclasses import is_dataclass
from importlib.metadata import entry_points
from types import UnionType
from typing import TypeVar, get_args, get_origin, get_type_hints

from rig.hal import ConfigurationError
from rig.hal.offers import lacking

Thing = TypeVar("Thing")

GROUPS = ("rig.mechanisms", "rig.drivers", "rig.protocols", "rig.additions")
"""Of the entry points by which other packages offer their rows."""


def check_offers(what: str, thing: object, protocol: type) -> None:
    """Refuse a class, or an instance of one, that has not all that a protocol asks for.

    Parameters
    ----------
    what : str
        What it is, for messages: its kind, its name and where it is.
    thing : object
        The class or the instance.
    protocol : type
        Of `rig.hal`, or a mechanism's own.

    Raises
    ------
    ConfigurationError
        With what it lacks.
    """
    missing = lacking(thing, protocol)
    if missing:
        raise ConfigurationError(
            f"{what} is no {protocol.__module__}.{protocol.__name__}: it has no "
            f"{', '.join(missing)}"
        )


def check_row(what: str, row: object) -> None:
    """Refuse a row of `rig.hal.parts` whose entries are not of the types that it declares.

    Raises
    ------
    ConfigurationError
        With the entry, what it is and what it must be.
    """
    for name, hint in get_type_hints(type(row)).items():
        value = getattr(row, name)
        if not _fits(value, hint):
            wanted = str(hint).replace("collections.abc.", "").replace("rig.hal.parts.", "")
            raise ConfigurationError(f"{what}: {name} is {value!r}, and no {_plain(wanted)}")


def _plain(hint: str) -> str:
    return hint.removeprefix("<class '").removesuffix("'>").replace("str | None", "path or None")


def _fits(value: object, hint: object) -> bool:
    """Return whether a value is of a type, down to what a mapping or tuple holds."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is UnionType:
        return any(_fits(value, part) for part in parts)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(
            _fits(key, parts[0]) and _fits(entry, parts[1]) for key, entry in value.items()
        )
    if origin is tuple:
        return isinstance(value, tuple) and all(_fits(entry, parts[0]) for entry in value)
    if hint is str:
        return isinstance(value, str) and bool(value)
    if not (isinstance(hint, type) and isinstance(value, hint)):
        return False
    return not is_dataclass(hint) or all(
        _fits(getattr(value, name), part) for name, part in get_type_hints(hint).items()
    )


def check_settings(what: str, settings: object, protocol: type) -> None:
    """Refuse what is no dataclass, which a section of a file becomes, or lacks what is asked of it.

    Raises
    ------
    ConfigurationError
        With what it lacks.
    """
    if not (isinstance(settings, type) and is_dataclass(settings)):
        raise ConfigurationError(f"{what} is no dataclass, which the settings of a section must be")
    check_offers(what, settings, protocol)


def check_class(what: str, thing: object, protocol: type) -> None:
    """Refuse what is no class, or one that has not all that a protocol asks for.

    Raises
    ------
    ConfigurationError
        With what it lacks.
    """
    if not isinstance(thing, type):
        raise ConfigurationError(f"{what} is a {type(thing).__name__}, and no class")
    check_offers(what, thing, protocol)


def check_table(what: str, table: object, kind: type[Thing]) -> Mapping[str, Thing]:
    """Return a table of names, if it is one of the right things.

    Raises
    ------
    ConfigurationError
        It is no mapping, or something in it is of another type.
    """
    if not isinstance(table, Mapping):
        raise ConfigurationError(
            f"{what} is a {type(table).__name__}, and no mapping of names to {kind.__name__}"
        )
    for name, thing in table.items():
        check_kind(f"{what}: {name!r}", thing, kind)
    return table


def check_kind(what: str, thing: object, kind: type[Thing]) -> Thing:
    """Return a thing, if it is of the right type.

    Raises
    ------
    ConfigurationError
        It is of another.
    """
    if not isinstance(thing, kind):
        raise ConfigurationError(f"{what} is a {type(thing).__name__}, and no {kind.__name__}")
    return thing


def whose_bug(error: BaseException) -> str | None:
    """Say which other package's code raised an error, and where; None if it was none of theirs.

    It was theirs if, of all that took part, the last of our code and of theirs is theirs: what a
    library refuses is the fault of who called it.
    """
    names = {
        point.value.partition(":")[0].partition(".")[0]
        for group in GROUPS
        for point in entry_points(group=group)
    }
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        package = module.partition(".")[0]
        if package in ("rig", "drivers", "controllers"):
            return None
        if package in names:
            return f"{module}, line {line}"
    return None
