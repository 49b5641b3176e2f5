"""Rules that are broken beside a value that cannot be read: both are told in one pass.

A dataclass is only made of readable values, so its rules are not asked while one is wrong. Here the
wrong ones are replaced by right ones, three times and differently: what is broken each time in the
same words is broken whatever stands in their place. A key that there is not is left out the first
time, and taken for the one most like it then. Of what was made up here no rule is told.
"""

import difflib
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import MISSING, fields, is_dataclass
from typing import Final, Literal, get_args, get_origin

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from rig.config.type_hints import hint_at, hints, is_union, split_annotated
from rig.hal.rules import told_by

_TIMES: Final = (0, -1, 1)
"""Which of the right values is taken each time: the first, the last, another one."""
_ROUNDS: Final = 3
"""A right value may show the next wrong one: of a mapping that was missing."""

_RIGHT: Final[tuple[object, ...]] = (
    1.0, 0.5, 2, 10.0, 60.0, 300.0, 1e3, 2e4, 1e5, 1e6, 0.1, 0.02, 1e-3, 1e-6, 0, -1, "x", "y",
    True, False, [0.0, 1.0], [0.01, 0.02], [-1.0, 1.0], [1e3, 2e5], [0, 0, 0], [1, 0, 0], [], {},
)  # fmt: skip
"""Values of which nearly any setting takes some."""

_Path = tuple[str | int, ...]
Validate = Callable[[object, object], object]
"""``validate(hint, value)``, which raises a `ValidationError`."""


def rules_besides(
    settings: type, plain: object, found: Sequence[ErrorDetails], validate: Validate
) -> Iterator[tuple[_Path, str]]:
    """Yield the rules that are broken beside the errors that were found: where, and the message.

    Parameters
    ----------
    settings : type
        The dataclass.
    plain : object
        The mapping.
    found : sequence of ErrorDetails
        What pydantic found.
    validate : callable
        As `Validate`.
    """
    first, *again = (_rules(settings, plain, found, validate, which) for which in _TIMES)
    yield from (broken for broken in first if all(broken in other for other in again))


def _rules(
    settings: type, plain: object, found: Sequence[ErrorDetails], validate: Validate, which: int
) -> list[tuple[_Path, str]]:
    content = deepcopy(plain)
    broken: list[tuple[_Path, str]] = []
    made: list[_Path] = []
    for _ in range(_ROUNDS):
        if not all(_mend(settings, content, details, validate, which, made) for details in found):
            break
        try:
            validate(settings, content)
            break
        except ValidationError as error:
            found = error.errors(include_url=False)
        for details in found:
            loc = details["loc"]
            if details["type"] == "value_error" and not any(loc[: len(p)] == p for p in made):
                told = told_by(details["ctx"]["error"])
                broken.extend((loc, message) for message in told)
    return broken


def _mend(
    settings: type,
    content: object,
    details: ErrorDetails,
    validate: Validate,
    which: int,
    made: list[_Path],
) -> bool:
    """Put something right in the place of what is wrong; return whether there is such a thing.

    A mapping that is put there whole is added to `made`.
    """
    path: list[str | int] = []
    holder, below = content, content
    for part in details["loc"]:
        is_key = isinstance(below, dict) and part in below
        is_position = isinstance(below, list) and isinstance(part, int) and part < len(below)
        if is_key or is_position:
            holder, below = below, below[part]  # type: ignore[index]
            path.append(part)
    if details["type"] == "missing" and isinstance(below, dict):
        path.append(details["loc"][-1])
        holder = below
    if not path or not isinstance(holder, dict | list):
        return False
    if isinstance(holder, dict) and _may_be_left_out(settings, tuple(path), details, which):
        holder.pop(path[-1], None)
        meant = _meant_key(settings, tuple(path), holder) if which != 0 else None
        if details["type"] != "extra_forbidden" or meant is None:
            return True
        path[-1] = meant
    right = _right_values(hint_at(settings, tuple(path)), validate)
    if not right:
        return False
    taken = right[min(which, len(right) - 1)]
    holder[path[-1]] = taken  # type: ignore[index] # a dict by keys, a list by positions
    if isinstance(taken, dict):
        made.append(tuple(path))
    return True


def _meant_key(settings: type, path: _Path, holder: dict[object, object]) -> str | None:
    """Return the key that is most like one that there is not, if it is not given beside it."""
    owner = hint_at(settings, path[:-1]) if len(path) > 1 else settings
    if not is_dataclass(owner):
        return None
    free = [field.name for field in fields(owner) if field.init and holder.get(field.name) is None]
    return next(iter(difflib.get_close_matches(str(path[-1]), free, n=1)), None)


def _may_be_left_out(settings: type, path: _Path, details: ErrorDetails, which: int) -> bool:
    if details["type"] == "extra_forbidden":
        return True
    owner = hint_at(settings, path[:-1]) if len(path) > 1 else settings
    if which != 0 or not is_dataclass(owner):
        return False
    named = (f for f in fields(owner) if f.name == path[-1])
    return any(f.default is not MISSING or f.default_factory is not MISSING for f in named)


def _right_values(hint: object, validate: Validate) -> list[object]:
    """Return values that a setting takes, no two alike."""
    bare, metadata = split_annotated(hint)
    if is_union(bare):
        return [value for arm in get_args(bare) for value in _right_values(arm, validate)] or [None]
    if get_origin(bare) is Literal:
        return list(get_args(bare))
    if isinstance(bare, type) and is_dataclass(bare):
        return [_right_mapping(bare, validate, which) for which in _TIMES]
    right: list[object] = []
    names = ("ge", "le", "gt", "lt")
    bounds = [getattr(item, name, None) for item in metadata for name in names]
    for value in (*_RIGHT, *bounds):
        try:
            validate(hint, value)
        except ValidationError:
            continue
        if not any(value == other and type(value) is type(other) for other in right):
            right.append(value)
    return right


def _right_mapping(settings: type, validate: Validate, which: int) -> dict[str, object]:
    made: dict[str, object] = {}
    for field in fields(settings):
        is_needed = field.default is MISSING and field.default_factory is MISSING
        values = _right_values(hints(settings)[field.name], validate) if is_needed else []
        if values:
            made[field.name] = values[min(which, len(values) - 1)]
    return made
