"""`rig new`: files to begin with, which run at once in simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from rig.cli.names import configs_option

if TYPE_CHECKING:
    from rig.scaffolding.packages import PackageKind

_KINDS = ("experiment", "rig", "controller", "driver")
_FOR_MECHANISMS = "a mechanism takes more than a file: rig/README.md of the program says what"


@click.command()
@click.argument("kind", type=click.Choice([*_KINDS, "mechanism"]))
@click.argument("name")
@click.option("--rig", help="Of an experiment: whose it is. Default: cylinder.")
@click.option("--like", metavar="NAME", help="The experiment or rig to begin with.")
@configs_option
def new(kind: str, name: str, rig: str | None, like: str | None, configs: Path | None) -> int:
    """Write files to begin with, under NAME: an experiment, a rig, a controller or a driver.

    An experiment and a rig are one commented file each. A controller (for the pair of cylinders)
    and a driver (a sensor on an analogue input, which is logged) are packages with a test, a
    profile and an experiment that runs at once; another package's law or driver needs no change
    of this program.
    """
    from rig.config.names import find_configs
    from rig.hal import ConfigurationError
    from rig.scaffolding.files import experiment_text, profile_text
    from rig.scaffolding.names import spell
    from rig.scaffolding.packages import package_files, write_files

    spell(name)
    if kind == "mechanism":
        raise ConfigurationError(_FOR_MECHANISMS)
    if kind in ("controller", "driver"):
        if rig is not None or like is not None:
            raise click.UsageError("--rig and --like are for experiments and rigs")
        write_files(Path(name), package_files(cast("PackageKind", kind), name))
        following = [
            f"pip install -e ./{name}",
            f"cd {name} && rig run {name}-sine --on sim",
            f"cd {name} && pytest tests",
        ]
    else:
        file = Path(f"{name}.yaml")
        if file.exists():
            raise ConfigurationError(f"{file} is there already; nothing was written")
        search = find_configs(configs)
        if kind == "experiment":
            text = experiment_text(name, rig or "cylinder", search, like)
            following = [f"rig check {file}", f"rig run {file} --on sim"]
        else:
            text = profile_text(name, like or rig or "cylinder", search)
            following = [f"rig check {file}", f"rig check {file} --values"]
        try:
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ConfigurationError(f"cannot write {file}: {error.strerror or error}") from error
    click.echo(f"{kind} {name} is written; next:", err=True)
    for line in following:
        click.echo(f"  {line}", err=True)
    return 0
