"""From a located mapping to an instance of a settings dataclass, strictly.

A settings dataclass knows nothing of files: it carries types, `annotated_types` bounds and SI
units. Here it becomes a pydantic type in which

- an unknown key is an error, and so is a missing one without a default;
- a field with a `Unit` also takes a text with a unit of the same dimension;
- a number is a number: no booleans, no texts, finite; whole numbers where the type is int;
- a `ValueError` of ``__post_init__`` is an error at the mapping.
"""

from collections.abc import Iterator
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from functools import lru_cache
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

from annotated_types import Unit
from pydantic import AfterValidator, ConfigDict, Strict, TypeAdapter, ValidationError
from pydantic import Field as PydanticField
from pydantic_core import ErrorDetails, PydanticCustomError, core_schema
from typing_extensions import NotRequired, Required, TypedDict

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.docstrings import parameter_texts
from rig.config.quantities import UnitError, format_quantity, parse_quantity, usual_units
from rig.config.source import BROKEN, Node

T = TypeVar("T")

_SCALARS = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}


def build(
    settings: type[T], node: Node, problems: Problems, *, also: tuple[str, ...] = ()
) -> T | None:
    """Turn a located mapping into an instance of a settings dataclass.

    Parameters
    ----------
    settings : type
        A frozen dataclass as in this module's description.
    node : Node
        The mapping.
    problems : Problems
        Takes every error found.
    also : tuple of str
        Keys that were taken out of the mapping before; offered when a key is unknown.

    Returns
    -------
    instance or None
        None if there were errors.
    """
    try:
        instance: T = adapter(settings).validate_python(node.plain())
    except ValidationError as error:
        for details in error.errors(include_url=False):
            _report(settings, node, details, problems, also)
        return None
    return instance


@lru_cache(maxsize=256)
def adapter(settings: type) -> TypeAdapter[Any]:
    """Return the pydantic validation of a settings dataclass."""
    return TypeAdapter(annotation(settings))


@lru_cache(maxsize=256)
def hints(settings: type) -> dict[str, Any]:
    """Return the annotations of a settings dataclass, metadata included."""
    return get_type_hints(settings, include_extras=True)


def annotation(hint: Any) -> Any:
    """Return the strict pydantic annotation for the annotation of a settings field."""
    bare, metadata = split_annotated(hint)
    if is_dataclass(bare):
        assert isinstance(bare, type)
        return Annotated[typed_dict(bare), AfterValidator(_Constructor(bare))]
    # The bounds of an optional or of a tuple of numbers are those of the number.
    arms = [arm for arm in get_args(bare) if arm is not NoneType]
    if get_origin(bare) in (Union, UnionType):
        inner = [annotation(Annotated[(arm, *metadata)] if metadata else arm) for arm in arms]
        return Union[tuple(inner) + ((None,) if NoneType in get_args(bare) else ())]
    unit = next((item for item in metadata if isinstance(item, Unit)), None)
    if get_origin(bare) is tuple:
        own = [item for item in metadata if item is not unit]
        arms = [a if a is Ellipsis or unit is None else Annotated[a, unit] for a in arms]
        made = tuple[tuple(a if a is Ellipsis else annotation(a) for a in arms)]  # type: ignore[misc]
        return Annotated[(made, *own)] if own else made
    if get_origin(bare) is dict:
        own = [item for item in metadata if item is not unit]
        value = arms[1] if unit is None else Annotated[arms[1], unit]
        made_dict = dict[Annotated[str, Strict()], annotation(value)]  # type: ignore[misc]
        return Annotated[(made_dict, *own)] if own else made_dict
    if bare is float:
        return Annotated[(float, Strict(), PydanticField(allow_inf_nan=False), *_quantity(metadata))]
    if bare in _SCALARS:
        return Annotated[(bare, Strict(), *_quantity(metadata))]
    return Annotated[(bare, *metadata)] if metadata else bare


def typed_dict(settings: type, extra: dict[str, Any] | None = None, name: str = "") -> Any:
    """Return the mapping that describes a settings dataclass, with further keys before its own."""
    texts = parameter_texts(settings)
    entries: dict[str, Any] = dict(extra or {})
    for field in fields(settings):
        if not field.init or field.name in entries:
            continue
        schema: dict[str, Any] = {}
        if field.default is not MISSING and isinstance(
            field.default, str | int | float | bool | NoneType
        ):
            schema["default"] = field.default
        info = PydanticField(description=texts.get(field.name), json_schema_extra=schema or None)
        made = Annotated[annotation(hints(settings)[field.name]), info]
        entries[field.name] = Required[made] if _required(field) else NotRequired[made]
    return closed_mapping(name or settings.__name__, entries)


def closed_mapping(name: str, entries: dict[str, Any]) -> Any:
    """Return a `TypedDict` that takes no other keys."""
    made = TypedDict(name, entries)  # type: ignore[misc, operator]  # its keys are known at run time
    made.__pydantic_config__ = ConfigDict(extra="forbid")
    return made


def split_annotated(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """Split an annotation into its bare type and its metadata."""
    if get_origin(hint) is Annotated:
        bare, *metadata = get_args(hint)
        return bare, tuple(metadata)
    return hint, ()


class _Constructor:
    """Makes the instance from checked values; one per class keeps error messages short."""

    def __init__(self, settings: type) -> None:
        self._settings = settings

    def __call__(self, values: dict[str, Any]) -> Any:
        try:
            return self._settings(**values)
        except ArithmeticError as error:
            raise ValueError(f"these values cannot be used together: {error}") from error


@dataclass(frozen=True, slots=True)
class _Quantity:
    """Pydantic metadata: the number may be a text with a unit."""

    unit: str

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(self._parse, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        number = handler(schema)
        text = {
            "type": "string",
            "pattern": r"^\s*[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\s*\S.*$",
            "description": f"a quantity in {', '.join(usual_units(self.unit))}",
        }
        return {"anyOf": [number, text]}

    def _parse(self, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        try:
            number = parse_quantity(value, self.unit)
        except UnitError as error:
            raise PydanticCustomError("quantity", "{message}", {"message": str(error)}) from error
        # A whole number may fill an int field; any other is left for pydantic to refuse.
        return int(number) if number.is_integer() and abs(number) < 2**53 else number


def _quantity(metadata: tuple[Any, ...]) -> Iterator[Any]:
    """Yield metadata for pydantic: the quantity last, since it must see the value first."""
    unit = None
    for item in metadata:
        if isinstance(item, Unit):
            unit = item.unit
        else:
            yield item
    if unit is not None:
        yield _Quantity(unit)


def _required(field: "Field[Any]") -> bool:
    return field.default is MISSING and field.default_factory is MISSING


def _report(
    settings: type, node: Node, details: ErrorDetails, problems: Problems, also: tuple[str, ...]
) -> None:
    """Add one error of pydantic, in the words and at the place of the file."""
    place, path = node.descend(details["loc"])
    kind, context = details["type"], details.get("ctx", {})
    if place.value is BROKEN:
        return
    name = ".".join(map(str, path)) or "this"
    if kind == "missing":
        missing = details["loc"][-1]
        if isinstance(missing, int):
            problems.add(place.mark, f"{name} has {missing} values, which is too few")
        else:
            problems.add(place.heading, f"key {missing!r} is missing", _wanted(settings, path, missing))
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
        problems.add(place.mark, f"{name} is {value}, expected {expected}", _choice(place, context, kind))


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
    bare, _ = split_annotated(hint)
    if unit is not None and kind in ("float_type", "int_type"):
        return f"a number in {unit or '1'} or a text with a unit: {', '.join(usual_units(unit))}"
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


def hint_at(hint: Any, path: tuple[str | int, ...]) -> Any:
    """Return the annotation that a path leads to, None if it leads nowhere."""
    bare, metadata = split_annotated(hint)
    if not path:
        return bare if is_dataclass(bare) else hint
    if get_origin(bare) in (Union, UnionType):
        found = (hint_at(arm, path) for arm in get_args(bare))
        return next((item for item in found if item is not None), None)
    unit = next((item for item in metadata if isinstance(item, Unit)), None)
    part, rest = path[0], path[1:]
    below = None
    if is_dataclass(bare) and isinstance(bare, type):
        below = hints(bare).get(str(part))
    elif get_origin(bare) is tuple and isinstance(part, int):
        elements = get_args(bare)
        if elements[-1] is Ellipsis:
            below = elements[0]
        elif part < len(elements):
            below = elements[part]
    elif get_origin(bare) is dict:
        below = get_args(bare)[1]
    if below is not None and unit is not None:
        below = Annotated[below, unit]
    return None if below is None else hint_at(below, rest)


def unit_of(hint: Any) -> str | None:
    """Return the SI unit of an annotation, None if it has none."""
    bare, metadata = split_annotated(hint)
    for item in metadata:
        if isinstance(item, Unit):
            return item.unit
    if get_origin(bare) in (Union, UnionType):
        return next((u for arm in get_args(bare) if (u := unit_of(arm)) is not None), None)
    return None


__all__ = ["adapter", "annotation", "build", "closed_mapping", "typed_dict", "unit_of"]
