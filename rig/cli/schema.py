"""`rig schema`: what an editor needs to check a file while it is typed."""

from __future__ import annotations

import json

import click

from rig.cli.tables import print_data


@click.command()
@click.argument("kind", type=click.Choice(["profile", "experiment"]))
def schema(kind: str) -> int:
    """Print the JSON Schema of a profile or an experiment.

    Save it and name it in the file's first line, for editors with a YAML language server:
    `# yaml-language-server: $schema=profile.schema.json`.
    """
    from rig.assembly.registry import REGISTRY
    from rig.config import experiment_schema, profile_schema

    made = profile_schema(REGISTRY) if kind == "profile" else experiment_schema(REGISTRY)
    print_data(json.dumps(made, indent=2, ensure_ascii=False))
    return 0
