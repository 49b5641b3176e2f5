"""JSON that somebody else may have written, checked against a type where it is read."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Final, TypeVar, Union, cast, get_args, get_origin, get_type_hints, is_typeddict

from rig.hal import ConfigurationError
from rig.hal.files import read_regular

MOST: Final = 64 << 20
"""Bytes of the longest file that is read: the events of a day."""
_SHOWN: Final = 60
"""Characters of a wrong value that an error quotes."""
_LARGEST: Final = 1 << 63
"""No whole number here is as large; it fits into a float, too."""

Kind = TypeVar("Kind")


def read_json(path: Path, kind: type[Kind]) -> Kind:
    """Return what a file of JSON holds.

    Parameters
    ----------
    path : Path
        A regular file.
    kind : type
        A TypedDict.

    Raises
    ------
    ConfigurationError
        It cannot be read, is not JSON, or holds something else; with the place in it.
    """
    try:
        content = parse(read_regular(path, MOST).decode())
    except (ValueError, RecursionError) as error:
        raise ConfigurationError(f"{path} is not JSON: {error}") from error
    return checked(content, kind, str(path))


def parse(text: str) -> object:
    """Return what a text of JSON holds.

    Raises
    ------
    ValueError, RecursionError
        It is none, or holds half a character, which no file and no terminal takes.
    """
    content: object = json.loads(text)
    if "\\ud" in text or "\\uD" in text:
        json.dumps(content, ensure_ascii=False).encode()
    return content


def checked(content: object, kind: type[Kind], name: str) -> Kind:
    """Return JSON's plain data as a type, if they are of it.

    Parameters
    ----------
    content : object
        The data.
    kind : type
        A TypedDict.
    name : str
        What an error calls the data.

    Raises
    ------
    ConfigurationError
        They are not; with the first value that is wrong.
    """
    try:
        _check(content, kind, "")
    except _Wrong as error:
        raise ConfigurationError(f"{name}: {error}") from None
    return cast("Kind", content)


class _Wrong(ValueError):
    """A value of another type than its place has."""

    def __init__(self, place: str, value: object, expected: str) -> None:
        told = repr(value)
        told = told if len(told) <= _SHOWN else f"{told[: _SHOWN - 1]}…"
        super().__init__(f"{place.lstrip('.') or 'it'} is {told}, expected {expected}")


def _check(value: object, kind: object, place: str) -> None:
    """Raise `_Wrong` unless a value is of a kind."""
    origin, arguments = get_origin(kind), get_args(kind)
    if is_typeddict(kind):
        _check_entries(value, cast("type", kind), place)
    elif origin in (Union, UnionType):
        if value is None and NoneType in arguments:
            return
        (only,) = (arm for arm in arguments if arm is not NoneType)
        _check(value, only, place)
    elif origin is list:
        if not isinstance(value, list):
            raise _Wrong(place, value, "a list")
        for number, item in enumerate(value):
            _check(item, arguments[0], f"{place}[{number}]")
    elif origin is dict:
        for key, item in _entries(value, place).items():
            _check(item, arguments[1], f"{place}.{key}")
    elif kind is float:
        if not _is_number(value, int | float):
            raise _Wrong(place, value, "a number")
    elif kind is int:
        if not _is_number(value, int):
            raise _Wrong(place, value, "a whole number")
    elif kind is not object and not isinstance(value, cast("type", kind)):
        raise _Wrong(place, value, {str: "text", bool: "true or false"}[cast("type", kind)])


def _entries(value: object, place: str) -> Mapping[str, object]:
    if not isinstance(value, dict):
        raise _Wrong(place, value, "a mapping")
    return value


def _check_entries(value: object, kind: type, place: str) -> None:
    entries = _entries(value, place)
    required: frozenset[str] = getattr(kind, "__required_keys__")  # noqa: B009 - of a TypedDict
    for key, hint in get_type_hints(kind).items():
        if key in entries:
            _check(entries[key], hint, f"{place}.{key}")
        elif key in required:
            raise _Wrong(place, value, f"a mapping with {key}")


def _is_number(value: object, kind: type | UnionType) -> bool:
    if isinstance(value, bool) or not isinstance(value, kind):
        return False
    return abs(value) < _LARGEST if isinstance(value, int) else math.isfinite(cast("float", value))
