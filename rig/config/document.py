"""Merge a file, the files that it extends and the options over it into one tree."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from rig.config.diagnostics import Problems, ProfileError, nearest, shown
from rig.config.located import BROKEN, Mark, Node, Plain, Source
from rig.config.names import SUFFIXES, Folder, alone_in, find_file, is_path, list_files
from rig.config.quantities import UnitError, parse_any_quantity
from rig.config.setting import Setting
from rig.config.yaml_loader import MAX_DEPTH, parse, read_source
from rig.hal import ConfigurationError
from rig.hal.files import is_file

_OWN: Final = ("extends", "name", "description")
"""What a file says of itself and does not inherit."""

_SELECTORS: Final = ("driver", "model", "kind")
"""Keys that say what the keys beside them mean."""

_MAX_CHAIN: Final = 8


@dataclass(frozen=True, slots=True)
class Document:
    """A file with its bases.

    Parameters
    ----------
    root : Node
        The merged mapping.
    files : tuple of Path
        What was read, the file itself first.
    """

    root: Node
    files: tuple[Path, ...]


def load_document(
    path: Path, folder: Folder, search: Sequence[Path], problems: Problems
) -> Document:
    """Read a file and, base first, the chain of files that it extends.

    Raises
    ------
    ConfigurationError
        A file cannot be read, or is not YAML at all.
    """
    return _load(path, folder, search, problems, ())


def plain_under(key: str, source: str | Path, folder: Folder, search: Sequence[Path] = ()) -> Plain:
    """Return what a file says under a key, however wrong the rest of it is; None if nothing."""
    try:
        root = load_document(find_file(source, folder, search), folder, search, Problems()).root
    except ConfigurationError:
        return None
    node = root.get(key)
    return None if node is None else node.plain()


def name_under(
    key: str, source: str | Path, folder: Folder, search: Sequence[Path] = ()
) -> str | None:
    """Return what a file says under a key, if it is a text, however wrong the rest of it is."""
    value = plain_under(key, source, folder, search)
    return value if isinstance(value, str) else None


def _load(
    path: Path, folder: Folder, search: Sequence[Path], problems: Problems, chain: tuple[Path, ...]
) -> Document:
    root = parse_mapping(read_source(path), problems)
    chain = (*chain, path.resolve())
    assert isinstance(root.value, dict)
    extends = root.value.get("extends")
    own = root.with_items({key: node for key, node in root.value.items() if key != "extends"})
    if extends is None or extends.value is None:
        return Document(own, (path,))
    base = _base(extends, folder, search, problems, chain)
    if base is None:
        problems.hush_missing(root.mark.source)  # the base would have had them
        return Document(own, (path,))
    inherited = _load(base, folder, search, problems, chain)
    assert isinstance(inherited.root.value, dict)
    items = {key: node for key, node in inherited.root.value.items() if key not in _OWN}
    merged = merge(inherited.root.with_items(items), own)
    return Document(merged, (path, *inherited.files))


def _base(
    extends: Node,
    folder: Folder,
    search: Sequence[Path],
    problems: Problems,
    chain: tuple[Path, ...],
) -> Path | None:
    """Return the file that another one extends, None after noting why there is none."""
    name = extends.value
    directory = Path(extends.mark.source.name).parent
    if not isinstance(name, str):
        problems.add(extends.mark, f"extends is {shown(extends.plain())}, expected a name or path")
        return None
    try:
        beside = _beside(name, directory, chain)
        if is_path(name):
            base = directory / name
        elif beside is not None:
            base = beside
        else:
            base = _installed(name, directory, folder, search, chain)
        if not base.is_file():
            raise ConfigurationError(f"there is no file {base}{_whole_name(name, beside)}")
        if base.resolve().suffix not in SUFFIXES:  # errors quote lines of what is read
            raise ConfigurationError(f"{base} is no YAML file by its name")
    except (ConfigurationError, OSError, ValueError) as error:
        problems.add(extends.mark, f"extends: {error}")
        return None
    if base.resolve() == chain[-1]:
        problems.add(extends.mark, f"extends: no other {folder[:-1]} is called {name!r}")
        return None
    if base.resolve() in chain:
        problems.add(extends.mark, f"extends: {base} extends this file in turn")
        return None
    if len(chain) >= _MAX_CHAIN:
        problems.add(extends.mark, f"extends: a chain of more than {_MAX_CHAIN} files")
        return None
    return base


def _beside(name: str, directory: Path, chain: tuple[Path, ...]) -> Path | None:
    """Return the file of a name, less its suffix, from a folder on; no base of a file is itself."""
    paths = (directory / f"{name}{suffix}" for suffix in SUFFIXES)
    return next((path for path in paths if is_file(path) and path.resolve() not in chain), None)


def _installed(
    name: str, directory: Path, folder: Folder, search: Sequence[Path], chain: tuple[Path, ...]
) -> Path:
    """Return the first file of a name in the configuration folders; no base of a file is itself."""
    for configs in search:
        path = list_files(folder, (configs,)).get(name)
        if path is not None and path.resolve() not in chain:
            return path
    known = {path.stem: path for path in directory.iterdir() if path.suffix in SUFFIXES}
    known |= list_files(folder, search)
    if name in known:
        return known[name]  # in the chain, which is said
    hint = (
        alone_in(name, folder, search) or nearest(name, known) or "there is none beside this file"
    )
    raise ConfigurationError(f"no {folder[:-1]} is called {name!r}; {hint}")


def _whole_name(name: str, beside: Path | None) -> str:
    return "" if beside is None else f"; did you mean {name}{beside.suffix}?"


def parse_mapping(source: Source, problems: Problems) -> Node:
    """Parse a text whose root must be a mapping."""
    root = _sound(source.name, source.text) or parse(source, problems)
    if not isinstance(root.value, dict):
        if root.value is not BROKEN:
            problems.add(root.mark, f"the file holds {shown(root.plain())}, expected a mapping")
        raise problems.error()
    return root


@lru_cache(maxsize=64)
def _sound(name: str, text: str) -> Node | None:
    """Return what a text holds, None if there is anything to say of it.

    A sweep reads the same files for each of its points, a command some of them twice: what they
    hold is laid over other nodes and never changed.
    """
    problems = Problems()
    try:
        root = parse(Source(name, text), problems)
    except ProfileError:
        return None
    return None if problems else root


def merge(base: Node, over: Node) -> Node:
    """Lay a node over another: mappings key by key, anything else replaces.

    A mapping that names another driver, plant model or reference kind replaces the whole
    entry, since the keys of the one mean nothing to the other.
    """
    if not (isinstance(base.value, dict) and isinstance(over.value, dict)):
        return over
    for key in _SELECTORS:
        if key in over.value and key in base.value:
            other = over.value[key].plain() != base.value[key].plain()
            if other:
                return over
    items = dict(base.value)
    for key, node in over.value.items():
        items[key] = merge(items[key], node) if key in items else node
    return over.with_items(items)


class Override(NamedTuple):
    """One ``a.b=c`` option: where it goes, and what, located in the option's text."""

    keys: tuple[str, ...]
    node: Node


def parse_overrides(overrides: Sequence[str], problems: Problems) -> tuple[Override, ...]:
    """Parse ``a.b=c`` options.

    Parameters
    ----------
    overrides : sequence of str
        Path of keys (and of positions in a list), an equals sign, and a value in YAML on one
        line.
    problems : Problems
        Takes what is wrong with an option, located in its text.
    """
    parsed = []
    for text in overrides:
        path, equals, value = text.partition("=")
        # Blanks in the place of the path keep the columns.
        blank = " " * (len(path) + 1)
        source = (
            Source(text.written, blank + value, is_whole=True)
            if isinstance(text, Setting)
            else Source("--set", blank + value, seen=text)
        )
        mark = Mark(source, 1, 1)
        keys = tuple(key.strip() for key in path.split("."))
        if not equals or not all(keys) or len(keys) > MAX_DEPTH:
            problems.add(mark, "an option is a path of keys, = and a value, as in loop.rate=500")
            continue
        if not value.strip():
            problems.add(Mark(source, 1, len(path) + 1), "there is no value after =")
            continue
        found = Problems()
        try:
            node = parse(source, found, flow_only=True)
            found.raise_if_any()
        except ProfileError as error:
            for diagnostic in error.diagnostics:
                problems.add(diagnostic.mark, diagnostic.message, diagnostic.hint)
        else:
            parsed.append(Override(keys, replace(node, key=mark)))
    return tuple(parsed)


def apply_overrides(root: Node, overrides: Sequence[Override], problems: Problems) -> Node:
    """Lay options over a mapping, the later over the earlier."""
    for keys, node in overrides:
        root = _set(root, keys, node, problems)
    return root


def _set(root: Node, keys: Sequence[str], node: Node, problems: Problems) -> Node:
    assert node.key is not None
    first, rest = keys[0], keys[1:]
    if isinstance(root.value, list):
        if not (first.isascii() and first.isdigit() and len(first) < 6):
            problems.add(node.key, f"{first} is not a position in a list")
            return root
        index = int(first)
        if index >= len(root.value):
            problems.add(node.key, f"there is no position {index}: the list has {len(root.value)}")
            return root
        items = list(root.value)
        items[index] = _set(items[index], rest, node, problems) if rest else node
        return replace(root, value=items)
    if not isinstance(root.value, dict):
        problems.add(node.key, f"{first} cannot be set: what holds it is {shown(root.plain())}")
        return root
    below = root.value.get(first)
    if rest:
        below = below if below is not None else Node({}, node.key, node.key)
        changed = _set(below, rest, node, problems)
    else:
        changed = node
    return root.with_items({**root.value, first: changed})


def with_plain_quantities(node: Node, keys: Sequence[str], problems: Problems) -> Node:
    """Turn texts with any unit into SI numbers, and note the unit beside them as ``unit``.

    For fields whose dimension only another layer knows; the keys must agree in it.
    """
    if not isinstance(node.value, dict):
        return node
    items = dict(node.value)
    for key in keys:
        entry = items.get(key)
        if entry is None or not isinstance(entry.value, str):
            continue
        try:
            value, unit = parse_any_quantity(entry.value)
        except UnitError as error:
            problems.add_broken(entry.mark, f"{key}: {error}")
            continue
        stated = items.setdefault("unit", Node(unit, entry.mark, entry.key))
        if stated.value != unit:
            problems.add(entry.mark, f"{key} is in {unit}, but the unit is {shown(stated.plain())}")
        items[key] = replace(entry, value=value)
    return node.with_items(items)
