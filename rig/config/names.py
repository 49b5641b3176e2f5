"""Find configuration folders, rigs and experiments by name."""

import difflib
import os
import re
import shlex
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Final, Literal

from rig.hal import ConfigurationError
from rig.hal.files import is_file, is_folder, reason_unread

Folder = Literal["rigs", "experiments"]

SUFFIXES: Final = (".yaml", ".yml")
_LONGEST: Final = 64
"""Letters of a wrong name that are looked at."""
_MOST_FILES: Final = 1000
"""Files beside a wrong name that are looked at."""
_SINGULAR: Final = {"rigs": "rig", "experiments": "experiment"}
_NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,63}")

SHIPPED = Path(__file__).resolve().parents[2] / "configs"
"""The configurations that come with the program."""


def is_name(text: str) -> bool:
    """Return whether a text may name a rig, bus or device: it may become a file's name."""
    return _NAME.fullmatch(text) is not None


def find_configs(given: Path | None = None) -> tuple[Path, ...]:
    """Return the folders that hold ``rigs``, ``experiments`` and ``calibration``.

    Parameters
    ----------
    given : Path, optional
        What the user named; then it is the only one.

    Returns
    -------
    tuple of Path
        Default: ``configs`` in the working directory, which need not be there, then the one
        beside this package. Commands write into the first, and only there.

    Raises
    ------
    ConfigurationError
        What the user named is no folder.
    """
    if given is not None:
        if not is_folder(given):
            raise ConfigurationError(f"{given} is not a folder with configurations")
        return (given,)
    here = Path("configs")
    return (here,) if here.resolve() == SHIPPED else (here, SHIPPED)


def say_where(folder: Path) -> str:
    """Return where commands write, in words: the folder, and whether it has to be made for it."""
    return str(folder) if is_folder(folder) else f"{folder}, which is made in {Path.cwd()}"


def list_files(folder: Folder, search: Sequence[Path]) -> dict[str, Path]:
    """Return the files of a kind by name, sorted; an earlier folder hides a later one.

    Raises
    ------
    ConfigurationError
        A folder of them is there and cannot be read.
    """
    found: dict[str, Path] = {}
    for configs in search:
        directory = configs / folder
        try:
            paths = sorted(directory.iterdir()) if directory.is_dir() else []
        except OSError as error:
            raise ConfigurationError(
                f"cannot read {directory}: {reason_unread(directory, error)}"
            ) from error
        for path in paths:
            if path.suffix in SUFFIXES and not path.name.startswith("."):
                found.setdefault(path.stem, path)
    return dict(sorted(found.items()))


def alone_in(name: str, folder: Folder, search: Sequence[Path]) -> str | None:
    """Return that a name is one of the usual folders, where another one was named; else None.

    Parameters
    ----------
    name : str
        That no file in `search` has.
    folder : str
        ``"rigs"`` or ``"experiments"``.
    search : sequence of Path
        The configuration folders.
    """
    found = None if len(search) != 1 else list_files(folder, find_configs()).get(name)
    if found is None:
        return None
    return f"{search[0]} alone is looked in, by --configs; without that it is {found}"


def hint_of_name(
    name: str, folders: Sequence[Folder], search: Sequence[Path], known: Iterable[str]
) -> str | None:
    """Return where a name may be that is none of those known here, or which one is like it.

    Parameters
    ----------
    name : str
        That no file in `search` has.
    folders : sequence of str
        ``"rigs"``, ``"experiments"`` or both.
    search : sequence of Path
        The configuration folders.
    known : iterable of str
        The names that there are.
    """
    for folder in folders:
        if hint := alone_in(name, folder, search) or _elsewhere(name, folder):
            return hint
    hint = nearest_of_all(name, known)
    if search and not is_folder(search[0]) and not (hint or "").startswith("did you mean"):
        missing = f"names of your own are looked for in {search[0]}, which is not in {Path.cwd()}"
        return f"{missing}; {hint}" if hint else missing
    return hint


def _elsewhere(name: str, folder: Folder) -> str | None:
    """Return that a name is one of another working folder, above this one or just below it."""
    here = Path.cwd()
    try:
        below = sorted(path.name for path in islice(here.iterdir(), _MOST_FILES) if path.is_dir())
    except OSError:
        below = []
    for place in (*here.parents, *map(Path, below)):
        path = place / "configs" / folder / f"{name}.yaml"
        if is_file(path):
            return f"{path} is looked for only where its configs is: cd {shlex.quote(str(place))}"
    return None


def is_path(source: str) -> bool:
    """Return whether a text means a file and not a name."""
    return "/" in source or source.endswith(SUFFIXES)


def nearest_file(path: Path) -> Path | None:
    """Return the configuration file beside a path whose name is most like its; None: none is."""
    beside = files_beside(path)
    close = difflib.get_close_matches(path.name[:_LONGEST], beside, n=1)
    return beside[close[0]] if close else None


def nearest_of_all(name: str, names: Iterable[str]) -> str | None:
    """Return a hint as `nearest` does; a file here may be more like a wrong name than any name."""
    from rig.config.diagnostics import nearest  # slow to import, and needed for a wrong name only

    here = files_beside(Path(name))
    files = {path.stem: path for path in here.values()} | here
    close = difflib.get_close_matches(name[:_LONGEST], [*names, *files], n=1)
    if close and close[0] in files:
        return f"did you mean the file {files[close[0]]}?"
    return nearest(name, names)


def files_beside(path: Path) -> dict[str, Path]:
    """Return the configuration files in a path's folder by their names, a thousand at most."""
    try:
        found = sorted(islice(path.parent.iterdir(), _MOST_FILES))
    except OSError:
        return {}
    return {its.name: its for its in found if its.suffix in SUFFIXES and is_file(its)}


def find_file(source: str | Path, folder: Folder, search: Sequence[Path]) -> Path:
    """Return the file of a rig or experiment.

    Parameters
    ----------
    source : str or Path
        A name, or the path of a file.
    folder : str
        ``"rigs"`` or ``"experiments"``.
    search : sequence of Path
        The configuration folders.

    Raises
    ------
    ConfigurationError
        There is none of that name; with the nearest one.
    """
    if isinstance(source, Path) or is_path(source):
        path = Path(source)
        if not os.path.lexists(path):
            known = list_files(folder, search).get(path.stem) if source == path.name else None
            if known is not None:
                raise ConfigurationError(
                    f"there is no file {source} here; did you mean the {_SINGULAR[folder]} "
                    f"{path.stem}, {known}?"
                )
            if (beside := nearest_file(path)) is not None:
                raise ConfigurationError(
                    f"there is no file {source}; did you mean the file {beside}?"
                )
        return path
    files = list_files(folder, search)
    if source in files:
        return files[source]
    beside = Path(f"{source}.yaml")
    if is_file(beside):
        raise ConfigurationError(
            f"no {_SINGULAR[folder]} is called {source!r}; did you mean the file {beside}?"
        )
    hint = hint_of_name(source, (folder,), search, files)
    where = ", ".join(str(configs / folder) for configs in search) or "nowhere: no folder"
    raise ConfigurationError(
        f"no {_SINGULAR[folder]} is called {source!r}; " + (hint or f"looked in {where}")
    )


def rig_argument(name: str, files: Sequence[Path]) -> str:
    """Return what names a rig on a command line, as a shell takes it.

    Parameters
    ----------
    name : str
        The rig's own.
    files : sequence of Path
        What was read for it, its own file first; none: it was made by a program.

    Returns
    -------
    str
        The name of its file where that finds it from here; else the path.
    """
    if not files:
        return shlex.quote(name)
    file = files[0].resolve()
    found = list_files("rigs", find_configs()).get(file.stem)
    if found is not None and found.resolve() == file:
        return shlex.quote(file.stem)
    here = Path.cwd().resolve()
    path = str(file.relative_to(here) if file.is_relative_to(here) else file)
    return shlex.quote(f"./{path}" if path.startswith("-") else path)
