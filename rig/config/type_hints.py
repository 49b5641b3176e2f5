"""Looking into the annotations of settings dataclasses."""

from dataclasses import is_dataclass
from functools import lru_cache
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from annotated_types import Unit


@lru_cache(maxsize=256)
def hints(settings: type) -> dict[str, Any]:
    """Return the annotations of a settings dataclass, metadata included."""
    return get_type_hints(settings, include_extras=True)


def split_annotated(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """Split an annotation into its bare type and its metadata."""
    if get_origin(hint) is Annotated:
        bare, *metadata = get_args(hint)
        return bare, tuple(metadata)
    return hint, ()


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
