"""An operator's word that a rig may move: its name, typed."""

from __future__ import annotations

import sys

import click

from rig.hal import ConfigurationError
from rig.terminals import is_terminal


class NotConfirmed(ConfigurationError):
    """Nobody has said the rig's name, and nobody can be asked for it."""


def confirm(rig: str, yes: str | None) -> bool:
    """Return whether the operator has named the rig; say what is missing if not.

    Parameters
    ----------
    rig : str
        Its name.
    yes : str or None
        What `--yes` said.

    Raises
    ------
    NotConfirmed
        There is nobody to ask, or another rig was named.
    """
    if yes is not None:
        if yes == rig:
            return True
        raise NotConfirmed(f"--yes {yes}: this is the rig {rig}")
    if not is_terminal(sys.stdin):
        raise NotConfirmed(f"there is no terminal to ask: say --yes {rig}")
    if (
        click.prompt("Type the rig's name to go on", default="", show_default=False, err=True)
        == rig
    ):
        return True
    click.echo("that is not its name: nothing was done", err=True)
    return False
