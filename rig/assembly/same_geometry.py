"""Whether a simulated rig has the stroke and the home that its mechanism's settings say."""

import dataclasses
from typing import Final

from rig.config import Profile
from rig.hal import SeveralErrors

_APART: Final = 0.05
"""Share of the stroke by which home and stroke may differ: what homing leaves is less."""
_ALIKE: Final = (("stroke", "cylinder.stroke"), ("home", "home"))
"""Settings of a mechanism with cylinders, and the plant's of the same meaning."""
_AS_WIDE: Final = (("bore", "cylinder.bore"), ("rod", "cylinder.rod"))
"""The same, of which no unit is far from its drawing."""
_WIDE: Final = 0.1
"""Share of the setting itself by which those may differ."""


def check_same_geometry(profile: Profile) -> None:
    """Refuse a plant with other cylinders than the controllers believe in: it faults at once.

    Raises
    ------
    ConfigurationError
        With both numbers; their places are found by their names.
    """
    if profile.plant is None:
        return
    found = []
    most = _APART * (_length(profile.mechanism_settings, "stroke") or 0.0)
    for ours, theirs in (*_ALIKE, *_AS_WIDE):
        believed = _length(profile.mechanism_settings, ours)
        true = _length(profile.plant.settings, theirs)
        if believed is None or true is None:
            continue
        if abs(believed - true) <= (most if (ours, theirs) in _ALIKE else _WIDE * believed):
            continue
        key = f"plant.{theirs}"
        unsaid = "" if key in profile.places else " by default"
        found.append(
            f"{profile.mechanism}.{ours} is {believed * 1e3:g} mm and {key} is {true * 1e3:g} mm"
            f"{unsaid}: the simulated rig is another one; say both alike"
        )
    SeveralErrors.raise_if_any(found)


def _length(settings: object, key: str) -> float | None:
    """Return the number behind a dotted key of settings; None: they have none."""
    for name in key.split("."):
        known = dataclasses.is_dataclass(settings) and {
            f.name for f in dataclasses.fields(settings)
        }
        if not known or name not in known:
            return None
        settings = getattr(settings, name)
    return settings if isinstance(settings, float) else None
