"""`rig completion`: the script that makes a shell complete commands and names."""

import click

from rig.cli.names import OneOf, json_option
from rig.cli.tables import print_json


@click.command()
@click.argument("shell", type=OneOf(["bash", "zsh", "fish"]))
@json_option
def completion(shell: str, as_json: bool) -> None:
    """Print the completion script of SHELL.

    For bash, put `eval "$(rig completion bash)"` into ~/.bashrc; names of experiments, rigs
    and runs are completed too.
    """
    from click.shell_completion import get_completion_class

    from rig.cli import group

    kind = get_completion_class(shell)
    if kind is None:  # pragma: no cover - click knows all three
        raise click.UsageError(f"click cannot complete {shell}")
    script = kind(group, {}, "rig", "_RIG_COMPLETE").source()
    if as_json:
        print_json({"shell": shell, "script": script})
    else:
        click.echo(script)
