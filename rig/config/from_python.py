"""Hold settings that Python code made against what a file may say.

What a file says has passed `rig.config.settings` before anybody computes with it. An instance
that a script made has not: a whole number where kernels expect a float, a list, a joint too few.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import cast

from pydantic import ValidationError

from rig.config.diagnostics import Problems
from rig.config.located import Mark, Node, Plain, Source
from rig.config.pydantic_errors import report
from rig.config.settings import adapter, closed_mapping, entries_of
from rig.config.type_hints import hints


def as_from_a_file(instance: object, name: str) -> None:
    """Give an instance the values that a file with the same numbers would have given it.

    It is changed in place, as a class of a script's own may hold more than its settings: whole
    numbers and numpy's become floats, lists tuples, texts with a unit numbers in SI. What is no
    settings dataclass stays as it is, and so is what a script's own class adds.

    Parameters
    ----------
    instance : object
        An instance of a settings dataclass, or of a class that inherits one.
    name : str
        What a message calls it.

    Raises
    ------
    ProfileError
        With every value that a file could not say.
    """
    settings = next(_described(type(instance)), None)
    if settings is None:
        return
    given = {f.name: _plain(getattr(instance, f.name)) for f in fields(settings) if f.init}
    kind = closed_mapping(settings.__name__, entries_of(settings))
    try:
        values = cast("dict[str, object]", adapter(kind).validate_python(given))
    except ValidationError as error:
        problems, place = Problems(), _located(cast("Plain", given), name)
        for details in error.errors(include_url=False):
            report(settings, place, details, problems, ())
        raise problems.error() from error
    for key, value in values.items():
        object.__setattr__(instance, key, value)


def _described(kind: type) -> "Iterator[type]":
    """Yield the settings dataclasses that a class is or inherits, the nearest first."""
    for base in kind.__mro__:
        if "__dataclass_fields__" not in vars(base):
            continue
        try:
            hints(base)
        except NameError:  # a script's own class, in words that only the script knows
            continue
        yield base


def _plain(value: object) -> object:
    """Return a value as the loader of a file would give it."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value) if f.init}
    if hasattr(value, "tolist"):  # numpy's arrays and scalars
        return _plain(value.tolist())
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value


def _located(value: Plain, name: str) -> Node:
    """Return a value whose places are all called by one name."""
    mark = Mark(Source(name, "", is_whole=True), 1, 1)

    def node(of: Plain) -> Node:
        if isinstance(of, dict):
            return Node({key: node(entry) for key, entry in of.items()}, mark)
        if isinstance(of, list):
            return Node([node(entry) for entry in of], mark)
        return Node(of, mark)

    return node(value)
