"""The rigs and experiments that lie in the working folder: a command that lacks one names them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click
from click.types import StringParamType

if TYPE_CHECKING:
    from rig.config.names import Folder

_MOST: Final = 12
"""Files that are named one by one."""


class RunName(StringParamType):
    """A run; who names none is told how the newest one is named."""

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        """Return what may stand in the place of nothing."""
        return "`latest` is the newest run; `rig list runs` names them all."


class ProfileOrExperiment(StringParamType):
    """A profile or an experiment; who names none is told which lie here."""

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        """Return what may stand in the place of nothing."""
        from rig.config.names import find_configs

        search = find_configs(ctx.params.get("configs") if ctx is not None else None)
        here = said_here(("rigs", "experiments"), search)
        return f"{here}`rig list` names those that have a name."


def said_here(kinds: Sequence[Folder], search: Sequence[Path]) -> str:
    """Return a sentence with the YAML files of the working folder, with a blank behind it.

    Parameters
    ----------
    kinds : sequence of str
        What they may be.
    search : sequence of Path
        The folders of configurations.
    """
    found = files_here(kinds, search)
    if not found:
        return ""
    more = f" and {len(found) - _MOST} more" if len(found) > _MOST else ""
    return f"Here: {', '.join(found[:_MOST])}{more}. "


def files_here(kinds: Sequence[Folder], search: Sequence[Path]) -> list[str]:
    """Return the YAML files of the working folder that are of a kind, by what they look like."""
    from rig.cli.file_kinds import is_experiment, is_rig
    from rig.config.names import files_beside

    tells = {"rigs": is_rig, "experiments": is_experiment}
    names = files_beside(Path("any"))
    return [name for name in names if any(tells[kind](name, search) for kind in kinds)]
