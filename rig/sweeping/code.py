"""The version of the code that runs: its source files, and the packages that it stands on."""

import contextlib
import hashlib
import importlib
import importlib.util
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Final, NamedTuple

from rig import provenance
from rig.plug_ins import GROUPS, entry_points

OURS: Final = ("controllers", "drivers", "rig")
_NOT_RUN: Final = ("rig.__main__", "rig.cli", "rig.faults", "rig.report", "rig.testing")
"""What no run imports before it has ended."""


class CodeVersion(NamedTuple):
    """A state of the code.

    Parameters
    ----------
    digest : str
        Of all source files and of the versions of the packages that may change a result.
    files : dict of str to str
        The digest of each file, by its path.
    """

    digest: str
    files: dict[str, str]

    def changed(self, later: "CodeVersion") -> list[str]:
        """Return the files that differ from a later state."""
        names = sorted({*self.files, *later.files})
        return [name for name in names if self.files.get(name) != later.files.get(name)]


def code_version() -> CodeVersion:
    """Return the state of the code on the disk: ours and that of packages with rows for it."""
    files = {
        f"{package}/{path.relative_to(folder)}": hashlib.sha256(path.read_bytes()).hexdigest()
        for package, folder in _packages()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".md"
    }
    text = repr((sorted(files.items()), sorted(provenance.versions().items())))
    return CodeVersion(hashlib.sha256(text.encode()).hexdigest(), files)


def import_all(packages: Collection[str]) -> None:
    """Import everything that a run might: what is edited afterwards changes nothing.

    Parameters
    ----------
    packages : collection of str
        Those of others that take part; no other is imported.
    """
    for name, folder in _packages():
        if name not in (*OURS, *packages):
            continue
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            module = ".".join((name, *parts)).removesuffix(".__init__")
            if not module.startswith(_NOT_RUN):
                with contextlib.suppress(Exception):  # of others, or for hardware not here
                    importlib.import_module(module)


def _packages() -> Iterator[tuple[str, Path]]:
    """Yield the packages of the product and of its plug-ins, with their folders."""
    others = {
        entry.module.partition(".")[0] for group in GROUPS for entry in entry_points(group=group)
    }
    for name in sorted({*OURS, *others}):
        spec = importlib.util.find_spec(name)
        for folder in spec.submodule_search_locations or () if spec is not None else ():
            yield name, Path(folder)
