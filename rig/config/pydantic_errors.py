"""Translate errors of pydantic into the words, units and places of the file."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import get_args

from pydantic_core import ErrorDetails

from rig.config.broken_rules import report_rule
from rig.config.diagnostics import Problems, nearest, shown
from rig.config.located import BROKEN, Node
from rig.config.quantities import usual_units
from rig.config.type_hints import hint_at, is_union, split_annotated, unit_of
from rig.hal.formats import format_quantity
from rig.hal.rules import told_by

_SCALARS = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}


def report(
    settings: type, node: Node, details: ErrorDetails, problems: Problems, also: tuple[str, ...]
) -> None:
    """Add one error of pydantic, in the words and at the place of the file."""
    place, path = node.descend(details["loc"])
    kind, context = details["type"], details.get("ctx", {})
    if place.value is BROKEN:
        return
    # Pydantic counts valid items only; each invalid one has an error of its own.
    sized = place.value if isinstance(place.value, list | dict) else ()
    if kind == "too_short" and len(sized) >= context.get("min_length", 1):
        return
    if kind == "string_type" and isinstance(place.value, dict) and _may_map(settings, path):
        return  # a text would do as well, but what is wrong is within the mapping
    name = ".".join(map(str, path)) or "this"
    if kind == "missing":
        missing = details["loc"][-1]
        if isinstance(missing, int):
            problems.add(place.mark, f"{name} has {missing} values, which is too few")
        else:
            problems.add(
                place.heading, f"key {missing!r} is missing", _wanted(settings, path, missing)
            )
    elif kind == "extra_forbidden":
        valid = [
            f.name
            for owner in _owners(hint_at(settings, path[:-1]))
            for f in fields(owner)
            if f.init
        ]
        if len(path) == 1:
            valid.extend(also)
        hint = None if problems.are_many else nearest(str(path[-1]), valid)
        problems.add(place.heading, f"unknown key {str(path[-1])[:80]!r}", hint)
    elif kind in ("value_error", "assertion_error"):
        error = context.get("error")
        told = told_by(error) if isinstance(error, BaseException) else (details["msg"],)
        for message in told:
            report_rule(settings, place, path, message, problems)
    elif kind == "quantity":
        problems.add(place.mark, f"{name}: {details['msg']}")
    else:
        expected = _expected(kind, context, hint_at(settings, path))
        message = f"{name} is {shown(place.plain())}, expected {expected}"
        problems.add(place.mark, message, _choice(place, context, kind))


def _owners(hint: object) -> list[type]:
    """Return the dataclasses whose keys a mapping may have: those of all arms of a choice."""
    bare, _ = split_annotated(hint)
    arms = get_args(bare) if is_union(bare) else (bare,)
    return [arm for arm in arms if isinstance(arm, type) and is_dataclass(arm)]


def _may_map(settings: type, path: tuple[str | int, ...]) -> bool:
    """Return whether settings may stand at a place instead of what else it takes."""
    bare, _ = split_annotated(hint_at(settings, path))
    return is_union(bare) and any(is_dataclass(arm) for arm in get_args(bare))


def _wanted(settings: type, path: tuple[str | int, ...], key: str) -> str | None:
    """Describe the value of a missing key."""
    hint = hint_at(settings, (*path, key))
    unit = unit_of(hint)
    if unit is not None:
        return f"it takes a number in {unit or '1'} or a text with a unit"
    bare, _ = split_annotated(hint)
    return f"it takes {_SCALARS[bare]}" if bare in _SCALARS else None


def _expected(kind: str, context: Mapping[str, object], hint: object) -> str:
    """Say what pydantic expected, with the bound in the field's unit."""
    unit = unit_of(hint)
    if unit is not None and kind in ("float_type", "int_type"):
        units = ", ".join(usual_units(unit))
        return f"{_WORDS[kind]} in {unit or '1'} or a text with a unit: {units}"
    if kind in _BOUNDS:
        words, key = _BOUNDS[kind]
        return f"{words} {_bound(context[key], unit)}"
    if kind in _WORDS:
        return _WORDS[kind].format(**context)
    return f"something else ({kind.replace('_', ' ')})"


_BOUNDS = {
    "greater_than": ("more than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}

_WORDS = {
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "path_type": "the path of a file",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping",
    "none_required": "nothing",
    "literal_error": "{expected}",
    "enum": "{expected}",
    "too_short": "at least {min_length} values",
    "too_long": "at most {max_length} values",
    "string_too_short": "at least {min_length} characters",
    "string_too_long": "at most {max_length} characters",
    "string_pattern_mismatch": "text like {pattern}",
}


def _bound(bound: object, unit: str | None) -> str:
    if not unit or unit == "1" or not isinstance(bound, int | float):
        return f"{bound:g}" if isinstance(bound, float) else str(bound)
    si, people = f"{bound:g} {unit}", format_quantity(bound, unit)
    return si if si == people or bound == 0 else f"{people} ({si})"


def _choice(place: Node, context: Mapping[str, object], kind: str) -> str | None:
    if kind not in ("literal_error", "enum") or not isinstance(place.value, str):
        return None
    text = str(context.get("expected", ""))
    return nearest(place.value, [part for part in text.split("'") if part.strip(" ,or")])
