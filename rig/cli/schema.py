"""`rig schema`: what an editor needs to check a file while it is typed."""

from __future__ import annotations

from pathlib import Path

import click

from rig.cli.names import OneOf, complete_rig, configs_option, json_option
from rig.cli.tables import print_json, visible


@click.command()
@click.argument("kind", type=OneOf(["profile", "experiment", "sweep", "scenario"]))
@click.argument("rig", required=False, shell_complete=complete_rig)
@configs_option
@json_option
def schema(kind: str, rig: str | None, configs: Path | None, as_json: bool) -> int:
    """Print the JSON Schema of a profile, an experiment, a sweep or a scenario of `rig faults run`.

    What packages of others offer is in it if RIG's profile names it: code of theirs runs for no
    other.

    Save it and name it in the file's first line, for editors with a YAML language server:
    `# yaml-language-server: $schema=profile.schema.json`.
    """
    from rig.assembly.registry import REGISTRY
    from rig.config import (
        ProfileError,
        experiment_schema,
        find_configs,
        load_profile,
        profile_schema,
    )

    if rig is not None:
        try:
            load_profile(rig, REGISTRY, (), find_configs(configs))
        except ProfileError as error:  # it is being written
            click.echo(visible(f"{rig} is not valid yet: {error}"), err=True)
    if kind == "sweep":
        from rig.sweeping.sweep_keys import sweep_schema

        print_json(sweep_schema())
    elif kind == "scenario":
        from rig.faults.scenario_file import scenario_schema

        print_json(scenario_schema())
    else:
        print_json((profile_schema if kind == "profile" else experiment_schema)(REGISTRY))
    return 0
