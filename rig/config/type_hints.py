"""Take the annotations of settings dataclasses apart: types, bounds and units."""

from dataclasses import is_dataclass
from functools import lru_cache
from types import UnionType
from typing import Annotated, Union, get_args, get_origin, get_type_hints

from annotated_types import Unit


@lru_cache(maxsize=256)
def hints(settings: type) -> dict[str, object]:
    """Return the annotations of a settings dataclass, metadata included."""
    return get_type_hints(settings, include_extras=True)


def split_annotated(hint: object) -> tuple[object, tuple[object, ...]]:
    """Split an annotation into its bare type and its metadata."""
    if get_origin(hint) is Annotated:
        bare, *metadata = get_args(hint)
        return bare, tuple(metadata)
    return hint, ()


def is_union(bare: object) -> bool:
    """Return whether a bare type is a choice of types."""
    return get_origin(bare) in (Union, UnionType)


def members(hint: object) -> tuple[object, ...]:
    """Return the annotations of what a tuple or dict holds; a unit of the whole is theirs."""
    bare, metadata = split_annotated(hint)
    unit = next((item for item in metadata if isinstance(item, Unit)), None)
    return tuple(
        arm if unit is None or arm in (Ellipsis, str) else Annotated[arm, unit]
        for arm in get_args(bare)
    )


def hint_at(hint: object, path: tuple[str | int, ...]) -> object:
    """Return the annotation that a path leads to, None if it leads nowhere."""
    bare, _ = split_annotated(hint)
    if not path:
        return bare if is_dataclass(bare) else hint
    if is_union(bare):
        found = (hint_at(arm, path) for arm in get_args(bare))
        return next((item for item in found if item is not None), None)
    below: object = None
    if isinstance(bare, type) and is_dataclass(bare):
        below = hints(bare).get(str(path[0]))
    elif get_origin(bare) is dict:
        below = members(hint)[1]
    elif get_origin(bare) is tuple and isinstance(path[0], int):
        below = dict(enumerate(members(hint))).get(0 if ... in get_args(bare) else path[0])
    return None if below is None else hint_at(below, path[1:])


def unit_of(hint: object) -> str | None:
    """Return the SI unit of an annotation, None if it has none."""
    bare, metadata = split_annotated(hint)
    units = [item.unit for item in metadata if isinstance(item, Unit)]
    if is_union(bare):
        units += [unit for arm in get_args(bare) if (unit := unit_of(arm)) is not None]
    return units[0] if units else None
