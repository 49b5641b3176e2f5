"""A profile that is made from a description which others wrote of a rig."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple


class DrawnProfile(NamedTuple):
    """A profile that comes of a description.

    Parameters
    ----------
    text : str
        A profile in YAML.
    notes : tuple of str
        Sentences on what was found, and on what the description does not say.
    """

    text: str
    notes: tuple[str, ...]


Draw = Callable[[str, Path, str | None], DrawnProfile]
"""Takes the profile's name, the file, and the part of it that moves (None: the obvious one).

Raises `rig.hal.ConfigurationError` if the file describes no rig of the mechanism.
"""
