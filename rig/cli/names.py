"""Options that commands share, and what a shell completes them with.

Completion runs at every press of the tabulator: it lists folders and opens no file.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from rig.config.names import Folder

RUNS = Path("runs")
"""Where run folders live unless ``--out`` says otherwise."""
LATEST = "latest"
"""Stands for the newest run."""
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
        found = [path for path in out.iterdir() if (path / MANIFEST).is_file()]
    except FileNotFoundError:
        return []
    except OSError as error:
        from rig.hal import ConfigurationError

        raise ConfigurationError(f"cannot list {out}: {error.strerror or error}") from error
    # The name starts with the UTC time; of one second, the longer suffix is the later run.
    return sorted(found, key=_age_key, reverse=True)


def _age_key(path: Path) -> tuple[str, float]:
    try:
        born = (path / "experiment.yaml").stat().st_mtime
    except OSError:
        born = 0.0
    return path.name.partition("Z-")[0], born


def find_run(source: str, runs: Path = RUNS) -> Path:
    """Return the folder of a run.

    Parameters
    ----------
    source : str
        A path, the name of a folder in `runs`, or ``"latest"``.
    runs : Path
        Where run folders live.

    Raises
    ------
    ConfigurationError
        There is none; with the nearest one.
    """
    from rig.hal import ConfigurationError

    if source == LATEST:
        found = list_runs(runs)
        if not found:
            raise ConfigurationError(f"there is no run in {runs} yet; `rig run` makes one")
        return found[0]
    for path in (Path(source), runs / source):
        if path.is_dir():
            return path
    import difflib

    names = [path.name for path in list_runs(runs)]
    near = difflib.get_close_matches(source, [*names, LATEST], n=1)
    if near:
        hint = f"did you mean {near[0]}?"
    elif names:
        hint = f"there are {len(names)} in {runs}, see `rig list runs`"
    else:
        hint = f"there is none in {runs}"
    raise ConfigurationError(f"no run is called {source!r}; {hint}")


def complete_rig(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of a profile."""
    return _complete(_names(ctx, "rigs"), incomplete)


def complete_experiment(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of an experiment."""
    return _complete(_names(ctx, "experiments"), incomplete)


def complete_config(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of a profile or an experiment."""
    return _complete([*_names(ctx, "rigs"), *_names(ctx, "experiments")], incomplete)


def complete_run(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of a run."""
    from rig.hal import ConfigurationError

    try:
        runs = [path.name for path in list_runs(Path(ctx.params.get("runs") or RUNS))]
    except ConfigurationError:
        runs = []
    return _complete([LATEST, *runs], incomplete)


def complete_device(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of a device of the profile that the command line names before."""
    return _complete(_device_names(ctx), incomplete)


def _device_names(ctx: click.Context) -> list[str]:
    """Look for the keys below ``devices:``, without reading what they mean."""
    import re

    from rig.config.names import find_configs, find_file
    from rig.hal import ConfigurationError
    from rig.hal.files import read_regular

    # While an option's value is missing, click has not given the arguments to their names yet.
    rig = ctx.params.get("rig") or next(iter(ctx.args), None)
    if rig is None:
        return []
    try:
        path = find_file(rig, "rigs", find_configs(ctx.params.get("configs")))
        text = read_regular(path, 1 << 20).decode(errors="replace")
    except (ConfigurationError, OSError):  # a shell has no place for an error
        return []
    section = re.search(r"^devices:.*\n((?:[ #].*\n|\n)*)", text, re.MULTILINE)
    return re.findall(r"^  ([\w.+-]+):", section[1], re.MULTILINE) if section else []


def _names(ctx: click.Context, folder: Folder) -> list[str]:
    from rig.config.names import find_configs, list_files
    from rig.hal import ConfigurationError

    try:
        return list(list_files(folder, find_configs(ctx.params.get("configs"))))
    except (ConfigurationError, OSError):  # a shell has no place for an error
        return []


def _complete(names: list[str], incomplete: str) -> list[CompletionItem]:
    from click.shell_completion import CompletionItem

    if "/" in incomplete or incomplete.startswith("."):
        return [CompletionItem(incomplete, type="file")]
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


configs_option = click.option(
    "--configs", type=click.Path(path_type=Path), help="Folder of configurations."
)
set_option = click.option(
    "--set", "overrides", multiple=True, metavar="A.B=C", help="Override a setting."
)
seed_option = click.option(
    "--seed", type=int, help="Seed of the simulation; short for simulation.seed."
)
rig_option = click.option(
    "--rig", "rig_name", metavar="PROFILE", shell_complete=complete_rig,
    help="Another rig than the experiment's.",
)  # fmt: skip
out_option = click.option(
    "--out", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where run folders live.",
)  # fmt: skip
"""Where a run is put."""
runs_option = click.option(
    "--runs", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where run folders live.",
)  # fmt: skip
"""Where a run is looked for by its name."""
yes_option = click.option(
    "--yes", metavar="NAME", help="The rig's name: on hardware, in the place of typing it."
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
