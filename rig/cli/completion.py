"""`rig completion`: the script that makes a shell complete commands and names."""

import click

from rig.cli.names import OneOf


@click.command()
@click.argument("shell", type=OneOf(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the completion script of SHELL.

    For bash, put `eval "$(rig completion bash)"` into ~/.bashrc; names of experiments, rigs
    and runs are completed too.
    """
    from click.shell_completion import get_completion_class

    from rig.cli import group

    kind = get_completion_class(shell)
    if kind is None:  # pragma: no cover - click knows all three
        raise click.UsageError(f"click cannot complete {shell}")
    click.echo(kind(group, {}, "rig", "_RIG_COMPLETE").source())
