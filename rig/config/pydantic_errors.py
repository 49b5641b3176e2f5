"""What pydantic found, in the words, units and places of the file."""

from dataclasses import fields, is_dataclass
from typing import Any

from pydantic_core import ErrorDetails

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.formats import format_quantity
from rig.config.located import BROKEN, Node
from rig.config.quantities import usual_units
from rig.config.type_hints import hint_at, split_annotated, unit_of

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
    sized = isinstance(place.value, list | dict) and kind == "too_short"
    if sized and len(place.plain()) >= context.get("min_length", 0):
        return
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
        owner = hint_at(settings, path[:-1])
        valid = [f.name for f in fields(owner)] if is_dataclass(owner) else []
        if len(path) == 1:
            valid.extend(also)
        problems.add(place.heading, f"unknown key {path[-1]!r}", nearest(str(path[-1]), valid))
    elif kind in ("value_error", "assertion_error"):
        problems.add(place.heading, str(context.get("error", details["msg"])))
    elif kind == "quantity":
        problems.add(place.mark, f"{name}: {details['msg']}")
    else:
        value = shown(place.plain())
        hint = hint_at(settings, path)
        expected = _expected(kind, context, hint)
        problems.add(
            place.mark, f"{name} is {value}, expected {expected}", _choice(place, context, kind)
        )


def _wanted(settings: type, path: tuple[str | int, ...], key: str) -> str | None:
    """Describe the value of a missing key."""
    hint = hint_at(settings, (*path, key))
    unit = unit_of(hint)
    if unit is not None:
        return f"it takes a number in {unit or '1'} or a text with a unit"
    bare, _ = split_annotated(hint)
    return f"it takes {_SCALARS[bare]}" if bare in _SCALARS else None


_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
    "multiple_of": ("multiple_of", "a multiple of"),
}


def _expected(kind: str, context: dict[str, Any], hint: Any) -> str:
    """Say what pydantic expected, with the bound in the field's unit."""
    unit = unit_of(hint)
    if kind in _BOUNDS:
        key, words = _BOUNDS[kind]
        bound = context[key]
        return f"{words} {_bound(bound, unit)}"
    if unit is not None and kind in ("float_type", "int_type"):
        number = "a number" if kind == "float_type" else "a whole number"
        return f"{number} in {unit or '1'} or a text with a unit: {', '.join(usual_units(unit))}"
    words_of = {
        "finite_number": "a finite number",
        "float_type": "a number",
        "int_type": "a whole number",
        "int_from_float": "a whole number",
        "bool_type": "true or false",
        "string_type": "text",
        "tuple_type": "a list",
        "list_type": "a list",
        "dict_type": "a mapping",
        "none_required": "nothing",
    }
    if kind in words_of:
        return words_of[kind]
    if kind == "literal_error":
        return str(context.get("expected", "another value"))
    if kind in ("too_short", "too_long"):
        limit = context.get("min_length" if kind == "too_short" else "max_length")
        return f"{'at least' if kind == 'too_short' else 'at most'} {limit} values"
    if kind in ("string_too_short", "string_too_long"):
        limit = context.get("min_length", context.get("max_length"))
        return f"{'at least' if kind == 'string_too_short' else 'at most'} {limit} characters"
    if kind == "string_pattern_mismatch":
        return f"text like {context.get('pattern')}"
    return f"something else ({kind.replace('_', ' ')})"


def _bound(bound: Any, unit: str | None) -> str:
    if unit in (None, "", "1") or not isinstance(bound, int | float):
        return f"{bound:g}" if isinstance(bound, float) else str(bound)
    assert unit is not None
    si, people = f"{bound:g} {unit}", format_quantity(bound, unit)
    return si if si == people or bound == 0 else f"{people} ({si})"


def _choice(place: Node, context: dict[str, Any], kind: str) -> str | None:
    if kind != "literal_error" or not isinstance(place.value, str):
        return None
    text = str(context.get("expected", ""))
    return nearest(place.value, [part for part in text.split("'") if part.strip(" ,or")])
