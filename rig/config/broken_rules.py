"""Tell a rule that a mapping does not keep: where its keys stand, and how a base is taken back."""

import re
from collections.abc import Mapping
from types import NoneType
from typing import get_args, get_origin

from rig.config.diagnostics import Problems
from rig.config.located import Node
from rig.config.type_hints import hint_at, is_union, split_annotated


def report_rule(
    settings: type, place: Node, path: tuple[str | int, ...], message: str, problems: Problems
) -> None:
    """Add a rule that a mapping does not keep, and where the keys stand that it names.

    Parameters
    ----------
    settings : type
        The dataclass of the whole.
    place : Node
        The mapping.
    path : tuple
        The keys that lead to it.
    message : str
        The rule.
    problems : Problems
        Takes it.
    """
    items = place.value if isinstance(place.value, dict) else {}
    named = {
        key: node for key, node in items.items() if re.search(rf"\b{re.escape(key)}\b", message)
    }
    problems.add(place.heading, message, _others(settings, place, path, named))


def _others(
    settings: type, place: Node, path: tuple[str | int, ...], named: Mapping[str, Node]
) -> str | None:
    """Say where the keys stand that a rule names: a base may have given one of them."""
    if len(named) < 2:
        return None
    told = ", ".join(f"{key} in {node.heading.told}" for key, node in named.items())
    options = [key for key, node in named.items() if node.heading.source.option]
    uppermost = options or [
        key for key, node in named.items() if node.heading.source == place.heading.source
    ]
    nothing = {
        key: word
        for key in named
        if key not in uppermost and (word := _nothing(hint_at(settings, (*path, key)))) is not None
    }
    if not uppermost or not nothing:
        return told
    if options:
        option = named[options[0]].heading.source.option
        line = option.partition("=")[0].rpartition(".")[0]
        added = " ".join(f"{line}.{key}={word}" for key, word in nothing.items())
        return f"{told}; to take back what the file gives, add {added}"
    added = " and ".join(f"`{key}: {word}`" for key, word in nothing.items())
    where = f"beside {' and '.join(uppermost)} in {named[uppermost[0]].heading.told}"
    return f"{told}; to take back what the base gives, add {added} {where}"


def _nothing(hint: object) -> str | None:
    """Return what a key takes in the place of a value, None if it must have one."""
    bare, _ = split_annotated(hint)
    arms = [split_annotated(arm)[0] for arm in get_args(bare)] if is_union(bare) else [bare]
    if NoneType in arms:
        return "null"
    return "[]" if any(get_origin(arm) is tuple and ... in get_args(arm) for arm in arms) else None
