"""Options that commands share, and what a shell completes them with.

Completion runs at every press of the tabulator: it lists folders and opens no file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from rig.cli.files_here import RunName
from rig.run_names import LATEST, RUNS, list_runs

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from rig.config.names import Folder


Decorated = TypeVar("Decorated", bound=Callable[..., object])


class OneOf(click.Choice[str]):
    """One of a few words; a word that is none is told the nearest one, too."""

    def get_invalid_choice_message(self, value: object, ctx: click.Context | None) -> str:
        """Return what is wrong with a word."""
        from difflib import get_close_matches

        said = super().get_invalid_choice_message(value, ctx)
        near = get_close_matches(str(value), list(self.choices), n=1)
        return f"{said} Did you mean {near[0]!r}?" if near else said


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


def _need(kind: Folder, ctx: click.Context, value: str | None) -> str:
    """Return a name; who gives none is told what there is of its kind."""
    if value is None:
        from rig.cli.files_here import said_here
        from rig.config.names import find_configs, list_files

        search = find_configs(ctx.params.get("configs"))
        names, here = list_files(kind, search), said_here([kind], search)
        raise click.UsageError(
            f"Which {kind.upper().removesuffix('S')}? {here}There are: {', '.join(names)}. "
            f"`rig list {kind}` describes them; the path of a YAML file will do as well."
        )
    return value


def _need_experiment(ctx: click.Context, param: click.Parameter, value: str | None) -> str:
    return _need("experiments", ctx, value)


def need_rig(ctx: click.Context, param: click.Parameter, value: str | None) -> str:
    """Return the name of a profile; who gives none is told what there is."""
    return _need("rigs", ctx, value)


experiment_argument = click.argument(
    "experiment", required=False, callback=_need_experiment, shell_complete=complete_experiment
)
"""The name of an experiment, or a file; who gives none is told what there is."""


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


def run_argument(name: str) -> Callable[[Decorated], Decorated]:
    """Return the decorator of an argument that is a run; who gives none is told of the newest."""
    return click.argument(name, type=RunName(), shell_complete=complete_run)


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
    "--configs", type=click.Path(path_type=Path),
    help="Folder of configurations; default: configs where you work, then the program's own.",
)  # fmt: skip
set_option = click.option(
    "--set", "overrides", multiple=True, metavar="A.B=C", help="Override a setting."
)
seed_option = click.option(
    "--seed", type=int, help="Seed of the simulation; short for simulation.seed."
)


def with_seed(overrides: Sequence[str], seed: int | None) -> list[str]:
    """Return settings with the one that ``--seed`` is short for."""
    from rig.config.setting import Setting

    if seed is None:
        return list(overrides)
    return [*overrides, Setting(f"simulation.seed={seed}", f"--seed {seed}")]


rig_option = click.option(
    "--rig", "rig_name", metavar="PROFILE", shell_complete=complete_rig,
    help="Another rig than the experiment's.",
)  # fmt: skip
runs_option = click.option(
    "--runs", "--out", "runs", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where run folders live.",
)  # fmt: skip
"""Where a run is looked for by its name."""
out_option = click.option(
    "--out", "--runs", "out", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where run folders live.",
)  # fmt: skip
"""Where a run is put. Both options have both spellings: a person knows one folder of runs."""
runs_beside_out_option = click.option(
    "--runs", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where run folders live.",
)  # fmt: skip
"""Where a run is looked for, of a command whose ``--out`` is what it writes."""
out_beside_runs_option = click.option(
    "--out", type=click.Path(path_type=Path), default=RUNS, show_default=True,
    help="Where the new run is put.",
)  # fmt: skip
"""Where a run is put, of a command that looks for another one in ``--runs``."""
yes_option = click.option(
    "--yes", metavar="NAME", help="The rig's name: on hardware, in the place of typing it."
)
uncommissioned_option = click.option(
    "--uncommissioned",
    metavar="REASON",
    help="All of the speed and the effort from hardware that is not commissioned; kept in the run.",
)
workers_option = click.option(
    "--workers", type=click.IntRange(1, 1024), default=os.cpu_count() or 1, show_default=True,
    help="How many processes.",
)  # fmt: skip
json_option = click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")

TUNED_LAW = "cascade"
"""The law whose gains are looked for and measured where none is named."""
law_option = click.option("--controller", default=TUNED_LAW, show_default=True, help="The law.")
