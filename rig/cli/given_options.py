"""The options that a command was given, for the command that goes on."""

from __future__ import annotations

from collections.abc import Iterable

import click
from click.core import ParameterSource

_CALLED = {"overrides": "set", "experiment": "for"}
"""Parameters that are called otherwise than their options."""


def given_options(names: Iterable[str]) -> list[str]:
    """Return those words of the running command line that gave some of its options.

    Parameters
    ----------
    names : iterable of str
        Parameters of the command, in the order in which their options are returned.
    """
    context = click.get_current_context()
    words: list[str] = []
    for name in names:
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        value = context.params[name]
        for one in value if isinstance(value, tuple) else (value,):
            words += [f"--{_CALLED.get(name, name)}", *([] if one is True else [str(one)])]
    return words
