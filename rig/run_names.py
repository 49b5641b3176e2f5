"""Run folders by name: where they live, and which one is meant. Imports nothing that is slow."""

import difflib
from pathlib import Path

from rig.hal.errors import ConfigurationError
from rig.hal.files import is_folder, reason_unread

RUNS = Path("runs")
"""Where run folders live unless ``--out`` says otherwise."""
LATEST = "latest"
"""Stands for the newest run, alone or behind a folder of runs: a word, and no file."""
_DEEPEST = 4
"""Folders down: ``FOLDER/seed-3/CASE/RUN`` are those of a campaign, and one more holds several."""
MANIFEST = "manifest.json"
"""What makes a folder a run folder; here so that listing needs nothing that is slow."""


def list_runs(out: Path) -> list[Path]:
    """Return the run folders in a folder, newest first.

    Raises
    ------
    ConfigurationError
        The folder is there and cannot be read.
    """
    try:
        found = [path for path in out.iterdir() if _is_run(path)]
    except FileNotFoundError:
        return []
    except OSError as error:
        raise ConfigurationError(f"cannot list {out}: {reason_unread(out, error)}") from error
    # The name starts with the UTC time; of one second, the longer suffix is the later run.
    return sorted(found, key=_age_key, reverse=True)


def list_runs_within(out: Path) -> list[Path]:
    """Return the run folders in a folder, or else those in folders within it, newest first.

    So lie the cases of a campaign. What may not be looked into has none to show.

    Raises
    ------
    ConfigurationError
        The folder is there and cannot be read.
    """
    if found := list_runs(out):
        return found
    within = [out]
    for _ in range(_DEEPEST):
        folders = [path for folder in within for path in _folders_in(folder)]
        runs = {path for path in folders if _is_run(path)}
        found += runs
        within = [path for path in folders if path not in runs]
    return sorted(found, key=_age_key, reverse=True)


def _folders_in(folder: Path) -> list[Path]:
    try:
        return [path for path in folder.iterdir() if path.is_dir() and not path.is_symlink()]
    except OSError:
        return []


def _is_run(path: Path) -> bool:
    """Return whether a folder is a run; one that may not be looked into goes by its name."""
    try:
        return (path / MANIFEST).is_file()
    except PermissionError:
        return "Z-" in path.name


def _age_key(path: Path) -> tuple[str, float]:
    try:
        born = (path / "experiment.yaml").stat().st_mtime
    except OSError:
        born = 0.0
    return path.name.partition("Z-")[0], born


def folder_of_latest(source: str, runs: Path = RUNS) -> Path | None:
    """Return the folder of whose runs a text means the newest; None if it means another."""
    if source == LATEST:
        return runs
    path = Path(source)
    is_word = path.name == LATEST and not is_folder(path) and is_folder(path.parent)
    return path.parent if is_word else None


def find_run(source: str, runs: Path = RUNS) -> Path:
    """Return the folder of a run.

    Parameters
    ----------
    source : str
        A path, the name of a folder in `runs`, ``"latest"``, or that of a folder: ``runs/latest``.
    runs : Path
        Where run folders live.

    Raises
    ------
    ConfigurationError
        There is none; with the nearest one.
    """
    latest = folder_of_latest(source, runs)
    if latest is not None:
        runs = latest
        found = list_runs(runs)
        if not found:
            raise ConfigurationError(f"there is no run in {runs} yet; `rig run` makes one")
        return found[0]
    for path in (Path(source), runs / source):
        if is_folder(path):
            return path

    names = [path.name for path in list_runs(runs)]
    near = difflib.get_close_matches(source, [*names, LATEST], n=1)
    if near:
        hint = f"did you mean {near[0]}?"
    elif names:
        hint = f"there are {len(names)} in {runs}, see `rig list runs`"
    else:
        hint = f"there is none in {runs}"
    raise ConfigurationError(f"no run is called {source!r}; {hint}")
