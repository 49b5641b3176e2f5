"""Whether what was loaded is what the contract says: what it lacks is a sentence with its name.

Anybody's code may be behind a name. It is asked once, when it is loaded; what nobody asked shows as
an error from deep inside, which is then told from a bug of this program by whose code raised it.
"""

import traceback
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
from types import FrameType
from typing import TypeVar, get_type_hints

from rig.hal import ContractBroken
from rig.hal.fits import OWN, fits, is_ours, misfits, plain, shown, where
from rig.hal.offers import lacking
from rig.plug_ins import GROUPS, entry_points

Thing = TypeVar("Thing")

_GIVEN: set[str] = set()
"""Modules of objects that this process was given in Python, of no package that is installed."""


def check_offers(what: str, thing: object, protocol: type) -> None:
    """Refuse a class, or an instance of one, that has not all that a protocol asks for.

    Of an instance, what the protocol annotates must be of that type.

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
    ContractBroken
        With what it lacks.
    """
    missing = lacking(thing, protocol)
    if missing:
        raise ContractBroken(
            f"{what} is no {protocol.__module__}.{protocol.__name__}: it has no "
            f"{', '.join(missing)}"
        )
    if not isinstance(thing, type):
        for misfit in misfits(thing, protocol):
            raise ContractBroken(
                f"{what}: {type(thing).__module__}.{type(thing).__name__}.{misfit}"
            )


def check_row(what: str, row: object) -> None:
    """Refuse a row of `rig.hal.parts` whose entries are not of the types that it declares.

    Raises
    ------
    ContractBroken
        With the entry, what it is and what it must be.
    """
    for name, hint in get_type_hints(type(row)).items():
        value = getattr(row, name)
        if not fits(value, hint) or value == "":
            raise ContractBroken(f"{what}: {name} is {value!r}, and no {plain(hint)}")


def check_settings(what: str, settings: object, protocol: type) -> None:
    """Refuse what is no dataclass, which a section of a file becomes, or lacks what is asked of it.

    Raises
    ------
    ContractBroken
        With what it lacks.
    """
    if not (isinstance(settings, type) and is_dataclass(settings)):
        raise ContractBroken(f"{what} is no dataclass, which the settings of a section must be")
    check_offers(what, settings, protocol)


def check_class(what: str, thing: object, protocol: type) -> None:
    """Refuse what is no class, or one that has not all that a protocol asks for.

    Raises
    ------
    ContractBroken
        With what it lacks.
    """
    if not isinstance(thing, type):
        raise ContractBroken(f"{what} is a {type(thing).__name__}, and no class")
    check_offers(what, thing, protocol)


def check_table(what: str, table: object, kind: type[Thing]) -> Mapping[str, Thing]:
    """Return a table of names, if it is one of the right things.

    Raises
    ------
    ContractBroken
        It is no mapping, or something in it is of another type.
    """
    if not isinstance(table, Mapping):
        raise ContractBroken(
            f"{what} is a {type(table).__name__}, and no mapping of names to {kind.__name__}"
        )
    for name, thing in table.items():
        if not fits(check_kind(f"{what}: {name!r}", thing, kind), kind):
            raise ContractBroken(f"{what}: {name!r} is {shown(thing)}, and no {kind.__name__}")
    return table


def check_kind(what: str, thing: object, kind: type[Thing]) -> Thing:
    """Return a thing, if it is of the right type.

    Raises
    ------
    ContractBroken
        It is of another.
    """
    if not isinstance(thing, kind):
        raise ContractBroken(f"{what} is a {type(thing).__name__}, and no {kind.__name__}")
    return thing


def ask(what: str, protocol: type, method: str, thing: object, *arguments: object) -> object:
    """Return what a method of somebody's class or instance returns, if it is what it must be.

    Parameters
    ----------
    what : str
        What is asked, for messages.
    protocol : type
        Of `rig.hal`, which declares the method.
    method : str
        Its name.
    thing : object
        The class or instance.
    *arguments : object
        The method's.

    Raises
    ------
    ContractBroken
        It returns something of another type than the protocol says.
    """
    found: object = getattr(thing, method)(*arguments)
    hint = _promised(protocol, method)
    if not fits(found, hint):
        raise ContractBroken(f"{what}: {method} returned {shown(found)}, and no {plain(hint)}")
    return found


@cache
def _promised(protocol: type, method: str) -> object:
    """Return the type of what a method of a protocol returns."""
    return get_type_hints(getattr(protocol, method))["return"]


def make(what: str, kind: Callable[..., Thing], *arguments: object, **named: object) -> Thing:
    """Make an instance of somebody's class.

    Raises
    ------
    ContractBroken
        It does not take what the contract hands over.
    """
    try:
        return kind(*arguments, **named)
    except TypeError as error:
        trace = error.__traceback__
        if is_ours(kind) or trace is None or trace.tb_next is not None:
            raise
        raise ContractBroken(f"{what}: {where(kind)} cannot be made: {error}") from error


def note_given(thing: object) -> None:
    """Take note of an object that was given in Python: what its code raises is no bug of ours.

    Parameters
    ----------
    thing : object
        An instance, a class or a function.
    """
    named = thing if hasattr(thing, "__qualname__") else type(thing)
    for part in named.__mro__ if isinstance(named, type) else (named,):
        module = str(getattr(part, "__module__", ""))
        if module != "builtins" and not is_ours(part):
            _GIVEN.add(module)


def whose_bug(error: BaseException) -> str | None:
    """Say which other code raised an error, and where; None if it was none of theirs.

    It was theirs if, of all that took part, the last of our code and of theirs is theirs: what a
    library refuses is the fault of who called it. Theirs is also what their class has inherited of
    ours: it works with what the class has made of the rest. Of what was given in Python the
    function that we called is named; a Ctrl-C that came while it ran is nobody's bug.
    """
    names = _packages_of_others()
    given = set() if isinstance(error, KeyboardInterrupt) else _GIVEN
    called: FrameType | None = None
    last: tuple[FrameType, int] | None = None
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        package = module.partition(".")[0]
        if package in names:
            return f"{module}, line {line}"
        if module in given:
            called, last = frame, last or (frame, line)
        elif package in OWN and not frame.f_code.co_name.startswith("<"):  # else it is part of one
            if called is not None:
                break
            of = _class_of(frame)
            is_theirs = of is not None and (
                of.__module__.partition(".")[0] in names or of.__module__ in given
            )
            return f"{where(of)}.{frame.f_code.co_name}" if is_theirs else None
    if called is None or last is None:
        return None
    return f"{called.f_code.co_qualname} ({last[0].f_code.co_filename}, line {last[1]})"


def _packages_of_others() -> set[str]:
    return {
        point.value.partition(":")[0].partition(".")[0]
        for group in GROUPS
        for point in entry_points(group=group)
    }


def lines_of_others(error: BaseException) -> list[traceback.FrameSummary]:
    """Return the lines of other people's code that led to an error; none: it was all of ours."""
    names = _packages_of_others()
    theirs = []
    for frame, line in traceback.walk_tb(error.__traceback__):
        module = str(frame.f_globals.get("__name__", ""))
        if module.partition(".")[0] in names or module in _GIVEN:
            code = frame.f_code
            theirs.append(traceback.FrameSummary(code.co_filename, line, code.co_name))
    return theirs


def said(error: BaseException) -> str:
    """Return the kind of an error and what it says, with what there is where a name is missing."""
    told = f"{type(error).__name__}: {error}"
    of = error.obj if isinstance(error, AttributeError) else None
    if isinstance(of, type) or not _is_record(of):
        return told
    kind = type(of)
    names = [
        name
        for name in dir(of)
        if not name.startswith("_") and not callable(getattr(kind, name, None))
    ]
    return f"{told}; it has: {', '.join(names)}"


def _is_record(thing: object) -> bool:
    """Return whether a thing is a named tuple, or a dataclass of ours."""
    is_named = isinstance(thing, tuple) and hasattr(thing, "_fields")
    return is_named or (is_dataclass(thing) and is_ours(type(thing)))


def _class_of(frame: FrameType) -> type | None:
    """Return the class whose method a frame runs; None if it runs none."""
    first = frame.f_code.co_varnames[:1]
    if first not in (("self",), ("cls",)) or first[0] not in frame.f_locals:
        return None
    of = frame.f_locals[first[0]]
    return of if isinstance(of, type) else type(of)
