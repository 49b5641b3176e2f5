"""Every setting of a rig with its value, and where that comes from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from rig.cli.tables import Table

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.config.located import Plain

DEFAULT = "default"


class Origin(NamedTuple):
    """A setting, and who says so.

    Parameters
    ----------
    name : str
        Dotted, as for ``--set``.
    value : str
        In SI.
    place : str
        ``file:line:column`` of the profile, of what it extends, or of a calibration; the option;
        or that it is the default.
    """

    name: str
    value: str
    place: str


def origins_of(profile: Profile, part: str) -> list[Origin]:
    """Return the settings of a profile whose dotted name has a part in it."""
    from rig.config.dump import plain_of

    places = profile.places
    return [
        Origin(name, value, places.get(name) or _above(name, places))
        for name, value in _leaves("", plain_of(profile))
        if part in name
    ]


def origins_table(origins: list[Origin]) -> Table:
    """Return origins as a table."""
    return Table("settings", ("setting", "value (SI)", "from"), origins)


def _above(name: str, places: dict[str, str]) -> str:
    """Return where a value stands whose list or line of text is said as a whole, if it is."""
    section, _, last = name.rpartition(".")
    return places.get(section, DEFAULT) if last.isdecimal() else DEFAULT


def _leaves(name: str, value: Plain) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, below in value.items():
            yield from _leaves(f"{name}.{key}".lstrip("."), below)
    elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        for number, item in enumerate(value):
            yield from _leaves(f"{name}.{number}", item)
    elif isinstance(value, list):
        yield name, ", ".join(map(_shown, value))
    else:
        yield name, _shown(value)


def _shown(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
