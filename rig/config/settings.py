"""Build settings dataclasses from located mappings, strictly.

A settings dataclass knows nothing of files: it carries types, `annotated_types` bounds and SI
units. Here it becomes a pydantic type in which

- an unknown key is an error, and so is a missing one without a default;
- a field with a `Unit` also takes a text with a unit of the same dimension;
- a number is a number: no booleans, no texts, finite; whole numbers where the type is int;
- a nested mapping changes the default of its field: what it leaves out stays as it is there;
- a pair that is `Rising` rises;
- a `Path` is that of a file, from the folder of the file that says it on;
- a `ValueError` of ``__post_init__`` is an error at the mapping.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import lru_cache, partial, reduce
from operator import or_
from pathlib import Path
from types import GenericAlias, MappingProxyType, NoneType
from typing import (
    Annotated,
    Final,
    NotRequired,
    Required,
    TypeAlias,
    TypeVar,
    cast,
    get_args,
    get_origin,
)

import pydantic
from annotated_types import Ge, Gt, Le, Lt, Unit
from pydantic import AfterValidator, BeforeValidator, Strict, TypeAdapter, ValidationError
from pydantic.config import JsonDict
from pydantic_core import CoreSchema, PydanticCustomError, SchemaValidator, core_schema
from typing_extensions import TypedDict

from rig.config.broken_rules import report_rule
from rig.config.diagnostics import Problems
from rig.config.docstrings import parameter_texts
from rig.config.located import Node
from rig.config.magnitudes import bounded
from rig.config.named_files import with_files_beside
from rig.config.pydantic_errors import report
from rig.config.quantities import UnitError, parse_quantity, parse_unit, usual_units
from rig.config.repair import rules_besides
from rig.config.type_hints import hints, is_union, members, split_annotated
from rig.config.unitless import find_unitless
from rig.hal.rising import Rising

T = TypeVar("T")
Entries: TypeAlias = Mapping[str, object]
"""The keys of a mapping with their pydantic annotations."""

_BOUNDS: Final[Mapping[type, str]] = {Ge: "ge", Gt: "gt", Le: "le", Lt: "lt"}

_BARE = r"(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
NUMBER = rf"[-+]?{_BARE}"
_UNIT = r"\s*(1/)?([A-DF-Za-df-z°%µμΩ(]|[eE][A-Za-z]).*$"
NUMBER_AND_UNIT = rf"^\s*{NUMBER}{_UNIT}"
_NO_LESS_THAN_0 = rf"^\s*(\+?{_BARE}|-0+(\.0*)?){_UNIT}"


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
    node = with_files_beside(settings, node, problems)
    try:
        instance = validator(settings).validate_python(node.plain())
    except ValidationError as error:
        found = error.errors(include_url=False)
        for details in found:
            report(settings, node, details, problems, also)
        if not problems.are_many:
            for path, message in rules_besides(settings, node.plain(), found, validated):
                report_rule(settings, *node.descend(path), message, problems)
        return None
    assert isinstance(instance, settings)
    problems.unitless |= dict.fromkeys(find_unitless(settings, node))
    return instance


def validated(hint: object, value: object) -> object:
    """Return what a settings dataclass, or any annotation in one, makes of plain data.

    Raises
    ------
    ValidationError
        Something is wrong with them.
    """
    return validator(hint).validate_python(value)


def validator(hint: object) -> SchemaValidator:
    """Return what validates a settings dataclass, or any annotation in one."""
    return _validator(hint)


@lru_cache(maxsize=512)
def _validator(hint: object) -> SchemaValidator:
    return SchemaValidator(_core_schema(hint))


@lru_cache(maxsize=512)
def adapter(settings: type) -> TypeAdapter[object]:
    """Return a settings dataclass, or any annotation in one, as pydantic describes it."""
    return TypeAdapter(cast("type", annotation(settings)))


def _core_schema(hint: object, base: object = None) -> CoreSchema:
    """Return what pydantic makes of `annotation`, in a fraction of its time.

    It takes each of hundreds of numbers for another one, and reads what only people are told: here
    the mappings are laid around the few dozen kinds of numbers that there are.
    """
    bare, metadata = split_annotated(hint)
    if isinstance(bare, type) and is_dataclass(bare):
        kept = _kept(bare, base)
        entries: dict[str, core_schema.TypedDictField] = {}
        for field, default in _entries(bare, kept):
            try:
                made = _core_schema(hints(bare)[field.name], default)
            except UnitError as error:
                raise UnitError(f"{bare.__name__}.{field.name}: {error}") from error
            entries[field.name] = core_schema.typed_dict_field(made, required=default is MISSING)
        mapping = core_schema.typed_dict_schema(
            entries, cls_name=bare.__name__, extra_behavior="forbid"
        )
        return core_schema.no_info_after_validator_function(_constructor(bare, kept), mapping)
    if is_union(bare):
        arms = [
            _core_schema(_annotated(arm, metadata), base)
            for arm in get_args(bare)
            if arm is not NoneType
        ]
        made = arms[0] if len(arms) == 1 else core_schema.union_schema([*arms])
        return core_schema.nullable_schema(made) if NoneType in get_args(bare) else made
    try:
        return _single_schema(hint)
    except TypeError:  # what somebody has annotated it with has no hash
        return _single_schema.__wrapped__(hint)


@lru_cache(maxsize=512)
def _single_schema(hint: object) -> CoreSchema:
    bare, metadata = split_annotated(hint)
    others, unit = _constraints(bare, metadata)
    bounds = {_BOUNDS[type(item)]: item for item in others if type(item) in _BOUNDS}
    if bare not in (float, int) or len(bounds) < len(others):
        return TypeAdapter(cast("type", annotation(hint))).core_schema
    limits = {name: getattr(item, name) for name, item in bounds.items()}
    number: CoreSchema = (
        core_schema.float_schema(strict=True, allow_inf_nan=False, **limits)
        if bare is float
        else core_schema.int_schema(strict=True, **limits)
    )
    if unit is None:
        return number
    parse_unit(unit)  # one that does not exist is told before a value is written in it
    return core_schema.no_info_before_validator_function(partial(_parse, unit), number)


def annotation(hint: object, base: object = None) -> object:
    """Return the strict pydantic annotation for that of a settings field and its default."""
    bare, metadata = split_annotated(hint)
    if isinstance(bare, type) and is_dataclass(bare):
        return _mapping(bare, base)
    if is_union(bare):
        # The bounds of an optional number are those of the number.
        arms = [arm for arm in get_args(bare) if arm is not NoneType]
        made = [annotation(_annotated(arm, metadata), base) for arm in arms]
        return reduce(or_, made + [None] * (NoneType in get_args(bare)))
    others, unit = _constraints(bare, metadata)
    container = get_origin(bare)
    if container in (tuple, dict):
        checks = [AfterValidator(o.check) if isinstance(o, Rising) else o for o in others]
        return _annotated(GenericAlias(container, tuple(map(annotation, members(hint)))), checks)
    if bare not in (float, int, bool, str):
        return _annotated(bare, metadata)
    finite = [pydantic.Field(allow_inf_nan=False)] if bare is float else []
    scalar = _annotated(bare, [Strict(), *finite, *others])
    if unit is None:
        return scalar
    bounds = [item.ge for item in others if isinstance(item, Ge)]
    is_signed = not any(isinstance(least, int | float) and least >= 0 for least in bounds)
    # Below 0 degC is above 0 K: of a temperature its sign says nothing.
    return _quantity(scalar, unit, is_signed or unit == "K")


def _constraints(bare: object, metadata: Sequence[object]) -> tuple[list[object], str | None]:
    """Return what a value is held to, and its unit."""
    unit = next((item.unit for item in metadata if isinstance(item, Unit)), None)
    others = [item for item in metadata if not isinstance(item, Unit)]
    return bounded(others, unit) if bare is float else others, unit


def _mapping(settings: type, base: object) -> object:
    """Return the annotation of a settings dataclass: a closed mapping, then an instance."""
    kept = _kept(settings, base)
    made = closed_mapping(settings.__name__, entries_of(settings, kept))
    return Annotated[made, AfterValidator(_constructor(settings, kept))]


def _kept(settings: type, base: object) -> dict[str, object]:
    """Return what a nested mapping leaves as it is, where its field's default is one."""
    is_one = type(base) is settings
    return {f.name: getattr(base, f.name) for f in fields(settings) if f.init} if is_one else {}


def _constructor(settings: type, kept: Mapping[str, object]) -> Callable[[Entries], object]:
    def construct(values: Entries) -> object:
        try:
            return settings(**{**kept, **values})
        except ArithmeticError as error:
            raise ValueError(f"these values cannot be used together: {error}") from error

    return construct


def _entries(
    settings: type, defaults: Mapping[str, object]
) -> Iterator[tuple[Field[object], object]]:
    """Yield the fields that are keys, each with its default; MISSING: it has none."""
    for field in fields(settings):
        if field.init:
            yield field, defaults.get(field.name, _default_of(field))


def entries_of(settings: type, defaults: Mapping[str, object] = MappingProxyType({})) -> Entries:
    """Return the keys of a settings dataclass with their pydantic annotations.

    Parameters
    ----------
    settings : type
        The dataclass.
    defaults : mapping
        Values of keys that are left out, in place of the dataclass's own defaults.
    """
    texts, types = parameter_texts(settings), hints(settings)
    entries: dict[str, object] = {}
    for field, default in _entries(settings, defaults):
        schema: JsonDict = {}
        if isinstance(default, str | int | float | NoneType):
            schema["default"] = default
        elif isinstance(default, tuple) and default and all(isinstance(n, float) for n in default):
            schema["default"] = list(default)
        elif isinstance(default, Path):
            schema["default"] = str(default)
        info = pydantic.Field(description=texts.get(field.name), json_schema_extra=schema)
        try:
            made = _annotated(annotation(types[field.name], default), [info])
        except UnitError as error:
            raise UnitError(f"{settings.__name__}.{field.name}: {error}") from error
        entries[field.name] = Required[made] if default is MISSING else NotRequired[made]
    return entries


def _default_of(field: Field[object]) -> object:
    return field.default if field.default_factory is MISSING else field.default_factory()


def closed_mapping(name: str, entries: Entries) -> type:
    """Return a `TypedDict` that takes no other keys."""
    make = cast("Callable[[str, Entries], type]", TypedDict)  # its keys are known at run time only
    return pydantic.with_config(pydantic.ConfigDict(extra="forbid"))(make(name, entries))


def _annotated(bare: object, metadata: Iterable[object]) -> object:
    items = tuple(metadata)
    return Annotated[(bare, *items)] if items else bare


def _quantity(number: object, unit: str, is_signed: bool) -> object:
    """Return the annotation of a number that may also be a text with a unit."""
    described = f"a quantity in {', '.join(usual_units(unit))}"
    pattern = NUMBER_AND_UNIT if is_signed else _NO_LESS_THAN_0
    text = Annotated[str, pydantic.Field(pattern=pattern, description=described)]
    parse = BeforeValidator(partial(_parse, unit), json_schema_input_type=or_(number, text))
    return Annotated[number, parse]


def _parse(unit: str, value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        number = parse_quantity(value, unit)
    except UnitError as error:
        raise PydanticCustomError("quantity", "{message}", {"message": str(error)}) from error
    # A whole number may fill an int field; any other is left for pydantic to refuse.
    return int(number) if number.is_integer() and abs(number) < 2**53 else number
