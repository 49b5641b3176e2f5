"""Whether a value is of the type that the contract declares: anybody's code may have made it."""

import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass
from functools import cache
from numbers import Real
from typing import ClassVar, Union, get_args, get_origin, get_type_hints

from rig.hal.offers import members_of

_LONGEST = 60
"""Characters of a value that a message shows."""
OWN = ("rig", "drivers", "controllers")
"""Packages of this program."""


def is_ours(thing: object) -> bool:
    """Return whether a class, function or instance is of this program."""
    module: str = getattr(thing, "__module__", "")
    return module.partition(".")[0] in OWN


def is_number(value: object) -> bool:
    """Return whether a value is a real number: no text, no truth value, no array."""
    return isinstance(value, Real) and not isinstance(value, bool)


def where(code: object) -> str:
    """Return the module and name of a class or function; of anything else, of its type."""
    named = code if hasattr(code, "__qualname__") else type(code)
    return f"{named.__module__}.{named.__qualname__}"


def shown(value: object) -> str:
    """Return a value as a message shows it."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def misfits(thing: object, protocol: type) -> tuple[str, ...]:
    """Return which attributes of a thing are not of the types that a protocol declares.

    Returns
    -------
    tuple of str
        For each of them its name, what it is and what it must be.
    """
    return tuple(
        f"{name} is {shown(getattr(thing, name))}, and no {plain(hint)}"
        for name, hint in _declared(protocol).items()
        if hasattr(thing, name) and not fits(getattr(thing, name), hint)
    )


def plain(hint: object) -> str:
    """Return an annotation as people read it."""
    if isinstance(hint, type) and not get_args(hint):
        return hint.__name__
    text = str(hint).replace("collections.abc.", "").replace("typing.", "")
    for package in (*OWN, "numbers"):
        text = text.replace(f"{package}.hal.", "")
    return text


def fits(value: object, hint: object) -> bool:
    """Return whether a value is of an annotated type, down to what it holds.

    What an annotation leaves open (a type variable, a protocol) takes any value.
    """
    origin, parts = get_origin(hint), get_args(hint)
    if origin is ClassVar:
        return fits(value, parts[0])
    if origin in (types.UnionType, Union):
        return any(fits(value, part) for part in parts)
    if origin in (Mapping, dict):
        return isinstance(value, Mapping) and all(
            fits(key, parts[0]) and fits(entry, parts[1]) for key, entry in value.items()
        )
    if origin is Sequence:
        is_text = isinstance(value, str | bytes)
        return isinstance(value, Sequence) and not is_text and _all_fit(value, parts[0])
    if origin is tuple:
        return isinstance(value, tuple) and (
            _all_fit(value, parts[0])
            if parts[-1] is ...
            else len(value) == len(parts) and all(map(fits, value, parts))
        )
    if origin is Callable:
        return callable(value)
    if isinstance(origin, type) and issubclass(origin, tuple):  # a generic named tuple
        given = dict(zip(origin.__parameters__, parts, strict=True))  # type: ignore[attr-defined]
        return isinstance(value, origin) and _fields_fit(value, origin, given)
    return _is_a(value, type if origin is type else hint)


def _all_fit(values: Sequence[object], hint: object) -> bool:
    return all(fits(value, hint) for value in values)


def _is_a(value: object, hint: object) -> bool:
    """Return whether a value is of a plain type."""
    if hint is None:
        return value is None
    if not isinstance(hint, type) or getattr(hint, "_is_protocol", False):
        return True
    if hint is float:
        return is_number(value)
    if not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        return False
    has_fields = is_dataclass(hint) or (issubclass(hint, tuple) and hasattr(hint, "_fields"))
    return not has_fields or _fields_fit(value, hint, {})


def _fields_fit(value: object, kind: type, given: Mapping[object, object]) -> bool:
    return all(
        fits(getattr(value, name), given.get(hint, hint)) for name, hint in _hints(kind).items()
    )


@cache
def _hints(kind: type) -> Mapping[str, object]:
    try:
        return get_type_hints(kind)
    except NameError:  # of a library that is imported only where it is used
        return {}


@cache
def _declared(protocol: type) -> Mapping[str, object]:
    """Return the types of the attributes that a protocol asks for."""
    found: dict[str, object] = {}
    hints = get_type_hints(protocol)
    for name, _ in members_of(protocol):
        member = getattr(protocol, name, None)
        if isinstance(member, property):
            found[name] = get_type_hints(member.fget).get("return")
        elif name in hints:
            found[name] = hints[name]
    return found
