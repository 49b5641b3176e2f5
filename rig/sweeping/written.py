"""How what is asked of a sweep was written: its messages repeat that."""

from collections.abc import Callable
from typing import TypeAlias

from rig.hal.fits import shown

Written: TypeAlias = Callable[[str, str, object], str]
"""Returns an argument (``"vary"``, say), a setting and its value or values as they were written."""


def on_command_line(argument: str, setting: str, value: object) -> str:
    """Return it as an option."""
    return f"--{argument} {setting}={value}"


def in_python(argument: str, setting: str, value: object) -> str:
    """Return it as an argument of `rig.sweep`."""
    return f"{argument}={{{setting!r}: {shown(value)}}}"


def in_file(argument: str, setting: str, value: object) -> str:
    """Return it as an entry of a sweep file."""
    return f"{setting}: {value}"
