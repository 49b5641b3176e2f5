"""From a located mapping to an instance of a settings dataclass, strictly.

A settings dataclass knows nothing of files: it carries types, `annotated_types` bounds and SI
units. Here it becomes a pydantic type in which

- an unknown key is an error, and so is a missing one without a default;
- a field with a `Unit` also takes a text with a unit of the same dimension;
- a number is a number: no booleans, no texts, finite; whole numbers where the type is int;
- a nested mapping changes the default of its field: what it leaves out stays as it is there;
- a `ValueError` of ``__post_init__`` is an error at the mapping.
"""

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass, replace
from functools import lru_cache, reduce
from operator import or_
from types import GenericAlias, NoneType, UnionType
from typing import Annotated, Any, NotRequired, Required, TypeVar, Union, get_args, get_origin

from annotated_types import Unit
from pydantic import AfterValidator, ConfigDict, Strict, TypeAdapter, ValidationError
from pydantic import Field as PydanticField
from pydantic_core import PydanticCustomError, core_schema
from typing_extensions import TypedDict

from rig.config.diagnostics import Problems
from rig.config.docstrings import parameter_texts
from rig.config.located import Node
from rig.config.pydantic_errors import report
from rig.config.quantities import UnitError, parse_quantity, usual_units
from rig.config.type_hints import hints, split_annotated

T = TypeVar("T")

_JSON_SCALARS = (str, int, float, bool, NoneType)


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
    key: Any = settings  # a class is hashable, though mypy doubts it of a generic one
    try:
        instance: T = adapter(key).validate_python(node.plain())
    except ValidationError as error:
        for details in error.errors(include_url=False):
            report(settings, node, details, problems, also)
        return None
    return instance


@lru_cache(maxsize=256)
def adapter(settings: Hashable) -> TypeAdapter[Any]:
    """Return the pydantic validation of a settings dataclass."""
    return TypeAdapter(annotation(settings))


def annotation(hint: Any, base: Any = None) -> Any:
    """Return the strict pydantic annotation for that of a settings field and its default."""
    bare, metadata = split_annotated(hint)
    if is_dataclass(bare):
        assert isinstance(bare, type)
        default = base if type(base) is bare else None
        mapping = closed_mapping(bare.__name__, entries_of(bare, default))
        return Annotated[mapping, AfterValidator(_Constructor(bare, default))]
    arms = tuple(arm for arm in get_args(bare) if arm is not NoneType)
    # The bounds of an optional or of a tuple of numbers are those of the number.
    if get_origin(bare) in (Union, UnionType):
        inner = [annotation(Annotated[(arm, *metadata)] if metadata else arm, base) for arm in arms]
        return reduce(or_, [*inner, *([None] if NoneType in get_args(bare) else [])])
    unit = next((item for item in metadata if isinstance(item, Unit)), None)
    if get_origin(bare) is tuple:
        own = [item for item in metadata if item is not unit]
        if unit is not None:
            arms = tuple(arm if arm is Ellipsis else Annotated[arm, unit] for arm in arms)
        elements = tuple(arm if arm is Ellipsis else annotation(arm) for arm in arms)
        return _annotated(GenericAlias(tuple, elements), own)
    if get_origin(bare) is dict:
        own = [item for item in metadata if item is not unit]
        value = arms[1] if unit is None else Annotated[arms[1], unit]
        return _annotated(GenericAlias(dict, (Annotated[str, Strict()], annotation(value))), own)
    if bare is float:
        finite = PydanticField(allow_inf_nan=False)
        return _annotated(float, [Strict(), finite, *_quantity(metadata)])
    if bare in (int, bool, str):
        return _annotated(bare, [Strict(), *_quantity(metadata)])
    return _annotated(bare, metadata)


def entries_of(settings: type, base: Any = None) -> dict[str, Any]:
    """Return the keys of a settings dataclass with their pydantic annotations.

    Parameters
    ----------
    settings : type
        The dataclass.
    base : instance, optional
        Has the values of the keys that are left out, in place of the dataclass's own defaults.
    """
    texts = parameter_texts(settings)
    entries: dict[str, Any] = {}
    for field in fields(settings):
        if not field.init:
            continue
        default = _default_of(field) if base is None else getattr(base, field.name)
        schema: Any = {"default": default} if isinstance(default, _JSON_SCALARS) else None
        info = PydanticField(description=texts.get(field.name), json_schema_extra=schema)
        made = _annotated(annotation(hints(settings)[field.name], default), [info])
        entries[field.name] = Required[made] if default is MISSING else NotRequired[made]
    return entries


def _default_of(field: Field[Any]) -> Any:
    return field.default if field.default_factory is MISSING else field.default_factory()


def closed_mapping(name: str, entries: dict[str, Any]) -> Any:
    """Return a `TypedDict` that takes no other keys."""
    make: Any = TypedDict  # its keys are known at run time only
    made = make(name, entries)
    made.__pydantic_config__ = ConfigDict(extra="forbid")
    return made


def _annotated(bare: Any, metadata: Iterable[Any]) -> Any:
    items = tuple(metadata)
    return Annotated[(bare, *items)] if items else bare


class _Constructor:
    """Makes the instance from checked values; one per class keeps error messages short."""

    def __init__(self, settings: type, base: Any = None) -> None:
        self._settings = settings
        self._base = base

    def __call__(self, values: dict[str, Any]) -> Any:
        try:
            return self._settings(**values) if self._base is None else replace(self._base, **values)
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
