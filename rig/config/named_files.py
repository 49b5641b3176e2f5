"""Files that a key names: found from the file that says it on, wherever the program is run."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import NoneType
from typing import get_args

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.located import Node
from rig.config.names import is_path
from rig.config.type_hints import hint_at, hints, is_union, split_annotated
from rig.hal.files import is_file, is_folder

Keys = tuple[str, ...]


def beside(node: Node) -> Path:
    """Return the folder of the file that a value stands in; of an option where the user is."""
    written_in = Path(node.mark.source.name)
    return written_in.parent if is_file(written_in) else Path()


def with_path_beside(node: Node | None) -> Node | None:
    """Return a value that is a name or the path of a file, with the path made one from here."""
    if node is None or not isinstance(node.value, str) or not is_path(node.value):
        return node
    return replace(node, value=str(beside(node) / node.value))


def with_files_beside(settings: object, node: Node, problems: Problems) -> Node:
    """Return a mapping with every file that it names made an absolute path.

    Parameters
    ----------
    settings : annotation
        Of what is built from it: a key names a file if its type is `Path`. A number, as cameras
        have it, is no file; an empty text is none where there need not be one.
    node : Node
        The mapping.
    problems : Problems
        Takes empty names.
    """
    bare, _ = split_annotated(settings)
    if isinstance(bare, type) and is_dataclass(bare) and not _name_files(bare):
        return node
    if isinstance(node.value, dict):
        return node.with_items(
            {key: _below(settings, key, item, problems) for key, item in node.value.items()}
        )
    if isinstance(node.value, list):
        items = [_below(settings, index, item, problems) for index, item in enumerate(node.value)]
        return replace(node, value=items)
    if not isinstance(node.value, str) or not _is_of_file(settings):
        return node
    if not node.value:
        if _may_be_none(settings):
            return replace(node, value=None)
        problems.add(node.mark, "this is an empty text, expected the path of a file")
        return node
    if node.value.isdecimal():
        return node
    return replace(node, value=str((beside(node) / node.value).absolute()))


@lru_cache(maxsize=256)
def _name_files(settings: type) -> bool:
    """Return whether any key of a settings dataclass, however deep, names a file."""

    def anywhere(hint: object) -> bool:
        bare, _ = split_annotated(hint)
        if isinstance(bare, type) and is_dataclass(bare):
            return _name_files(bare)
        return bare is Path or any(map(anywhere, get_args(bare)))

    return any(map(anywhere, hints(settings).values()))


def _below(settings: object, key: str | int, node: Node, problems: Problems) -> Node:
    hint = hint_at(settings, (key,))
    return node if hint is None else with_files_beside(hint, node, problems)


def _is_of_file(hint: object) -> bool:
    bare, _ = split_annotated(hint)
    return bare is Path or (is_union(bare) and Path in get_args(bare))


def _may_be_none(hint: object) -> bool:
    bare, _ = split_annotated(hint)
    return is_union(bare) and NoneType in get_args(bare)


def check_files(settings: object, node: Node, name: str, problems: Problems) -> None:
    """Note every file that settings name and that is not there.

    Parameters
    ----------
    settings : dataclass
        As built.
    node : Node
        What they were built from.
    name : str
        Of the mapping, for the message.
    problems : Problems
        Takes what is missing, and the nearest name beside it.
    """
    for keys, path in files_in(settings):
        if is_file(path):
            continue
        place, taken = node.descend(keys)
        if not taken:  # a default names it
            place = node
        said = f"{'.'.join((name, *keys))} is {shown(place.plain())}"
        if is_folder(path):
            problems.add(place.mark, f"{said}, and {path} is a folder, no file")
        else:
            problems.add(place.mark, f"{said}, but there is no file {path}", _near(path))


def _near(path: Path) -> str | None:
    """Return what else there is beside a missing file, if it is of its kind."""
    if not is_folder(path.parent):
        return f"there is no folder {path.parent} either"
    try:
        others = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix and is_file(p)]
    except OSError:
        return None
    return nearest(path.name, others)


def files_in(settings: object, keys: Keys = ()) -> Iterator[tuple[Keys, Path]]:
    """Yield the keys and the path of every file that settings name."""
    if isinstance(settings, Path):
        yield keys, settings
    elif is_dataclass(settings):
        for field in fields(settings):
            if field.init:
                yield from files_in(getattr(settings, field.name), (*keys, field.name))
    elif isinstance(settings, dict):
        for key, item in settings.items():
            yield from files_in(item, (*keys, str(key)))


def copies_of(settings: object, folder: str) -> dict[Keys, str]:
    """Return where a run folder keeps each file that settings name.

    Parameters
    ----------
    settings : dataclass
        As built.
    folder : str
        The folder in it.
    """
    return {keys: f"{folder}/{'.'.join(keys)}{path.suffix}" for keys, path in files_in(settings)}
