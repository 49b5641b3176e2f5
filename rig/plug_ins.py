"""The packages of others whose code takes part: which they are, and a digest of what they hold."""

import hashlib
import sys
from collections import defaultdict
from functools import cache
from importlib import metadata
from importlib.metadata import EntryPoint, EntryPoints, distributions, version
from pathlib import Path
from types import ModuleType
from typing import Final

from rig.hal.fits import OWN
from rig.run_facts import PlugIn

GROUPS: Final = ("rig.mechanisms", "rig.drivers", "rig.protocols", "rig.additions")
"""Of the entry points by which other packages offer theirs."""


def entry_points(*, group: str) -> EntryPoints:
    """Return the entry points of one of `GROUPS`.

    What is installed is read once, as it does not change while a program runs: to look takes longer
    than to validate a profile, and every kind of row has a group of its own.
    """
    return _installed(tuple(sys.path))[group]


@cache
def _installed(_: tuple[str, ...]) -> dict[str, EntryPoints]:
    everything = metadata.entry_points()
    return {group: everything.select(group=group) for group in GROUPS}


def plug_ins() -> dict[str, PlugIn]:
    """Return every package with entry points for this program whose code has been imported.

    The digest is of all its files, so that a package that was edited in place, under the same
    version, is seen.
    """
    return {
        name: {
            "distribution": told[0], "version": told[1], "sha256": _digest(sys.modules[name]),
        }
        for name, told in _imported().items()
    }  # fmt: skip


def packages_that_take_part() -> tuple[str, ...]:
    """Return the names of the packages that `plug_ins` tells of."""
    return tuple(_imported())


def note_import(module: str) -> None:
    """Remember that a row has led to a module, which may be of a package without entry points."""
    package = module.partition(".")[0]
    if package not in OWN:
        _LED_TO.add(package)


_LED_TO: Final[set[str]] = set()
_Told = tuple[str | None, str | None]


def _imported() -> dict[str, _Told]:
    """Return distribution and version of each package that has been imported, by its name."""
    found: dict[str, _Told] = {}
    for point in _points():
        name = point.module.partition(".")[0]
        if sys.modules.get(name) is not None:
            told = (None, None) if point.dist is None else (point.dist.name, point.dist.version)
            found.setdefault(name, told)
    for name in _LED_TO - found.keys():
        if sys.modules.get(name) is not None:
            found[name] = _distribution_of(name)
    return dict(sorted(found.items()))


def _distribution_of(package: str) -> _Told:
    try:
        (name,) = set().union(*(_distributions_in(entry).get(package, ()) for entry in sys.path))
        return name, version(name)
    except Exception:  # of none, of several, or of one whose files are damaged
        return None, None


@cache
def _distributions_in(entry: str) -> dict[str, set[str]]:
    """Return the distributions of every package below an entry of `sys.path`.

    Looked up once, as it takes as long as a short run: what is installed does not change while a
    program runs.
    """
    found: dict[str, set[str]] = defaultdict(set)
    for distribution in distributions(path=[entry]):
        declared = (distribution.read_text("top_level.txt") or "").split()
        listed = {file.parts[0].removesuffix(".py") for file in distribution.files or ()}
        for package in declared or listed:
            found[package].add(distribution.name)
    return found


def _points() -> list[EntryPoint]:
    try:
        return [point for group in GROUPS for point in entry_points(group=group)]
    except Exception:  # a file of some package that is none; the registry tells of it
        return []


def _digest(module: ModuleType) -> str:
    """Return the SHA-256 of all files of a package, by their names, or of a module's one."""
    digest = hashlib.sha256()
    folders = [Path(folder) for folder in getattr(module, "__path__", ())]
    files = [(path.relative_to(folder), path) for folder in folders for path in folder.rglob("*")]
    if not folders and module.__file__ is not None:
        files = [(Path(Path(module.__file__).name), Path(module.__file__))]
    for name, path in sorted(files):
        if path.is_file() and "__pycache__" not in path.parts:
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            digest.update(f"{name.as_posix()}\n{content}\n".encode())
    return digest.hexdigest()
