"""The command that goes on with a calibration that was broken off or refused."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

if TYPE_CHECKING:
    from rig.config import Profile

_KEPT = ("on", "seed", "overrides", "out", "configs", "readings", "uncommissioned", "replace")
"""Options with which a procedure goes on as it began, if they were given; `--yes` is asked anew."""
_CALLED = {"overrides": "set"}


def go_on_command(procedure: str, profile: Profile, folders: Sequence[Path]) -> str:
    """Return the `rig calibrate` that goes on from recorded runs, as a shell takes it.

    Parameters
    ----------
    procedure : str
        Its name.
    profile : Profile
        The rig's.
    folders : sequence of Path
        What was recorded.
    """
    context = click.get_current_context()
    words = [procedure]
    for name in _KEPT:
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        value = context.params[name]
        for one in value if isinstance(value, tuple) else (value,):
            words += [f"--{_CALLED.get(name, name)}", *([] if one is True else [str(one)])]
    for folder in folders:
        words += ["--from", str(folder)]
    return f"rig calibrate {profile.argument} {shlex.join(words)}"
