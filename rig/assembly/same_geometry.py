"""Whether a simulated rig has the cylinders and legs that its mechanism's settings say."""

import dataclasses
from collections.abc import Iterator
from typing import Final

from rig.config import Profile
from rig.hal import SeveralErrors

_ALIKE: Final = (
    ("stroke", "cylinder.stroke", "stroke", 0.05),
    ("home", "home", "stroke", 0.05),
    ("bore", "cylinder.bore", "bore", 0.1),
    ("rod", "cylinder.rod", "rod", 0.1),
)
"""Settings of a mechanism with cylinders, the plant's of the same meaning, and by which share of
which setting they may differ: what homing leaves and what units are off their drawings is less."""


def shared_lengths(profile: Profile) -> Iterator[tuple[str, str, float]]:
    """Yield what mechanism and plant both say: the key, the plant's key, and its value there, m."""
    for ours, theirs, *_ in _ALIKE:
        true = number_at(profile.plant.settings, theirs) if profile.plant is not None else None
        if true is not None and number_at(profile.mechanism_settings, ours) is not None:
            yield ours, theirs, true


def check_same_geometry(profile: Profile) -> None:
    """Refuse a plant with other cylinders than the controllers believe in: it faults at once.

    Nor can one stand whose hips begin where its legs do not reach.

    Raises
    ------
    ConfigurationError
        With both numbers; their places are found by their names.
    """
    if profile.plant is None:
        return
    found = []
    for ours, theirs, size, share in _ALIKE:
        believed = number_at(profile.mechanism_settings, ours)
        true = number_at(profile.plant.settings, theirs)
        most = share * (number_at(profile.mechanism_settings, size) or 0.0)
        if believed is None or true is None or abs(believed - true) <= most:
            continue
        key = f"plant.{theirs}"
        unsaid = "" if key in profile.places else " by default"
        found.append(
            f"{profile.mechanism}.{ours} is {believed * 1e3:g} mm and {key} is {true * 1e3:g} mm"
            f"{unsaid}: the simulated rig is another one; say both alike"
        )
    SeveralErrors.raise_if_any([*found, *_out_of_reach(profile)])


def _out_of_reach(profile: Profile) -> list[str]:
    """Return that simulated legs begin higher or lower than theirs reach, if they do."""
    assert profile.plant is not None
    thigh, shank = (
        number_at(profile.mechanism_settings, f"geometry.{link}") for link in ("thigh", "shank")
    )
    height = number_at(profile.plant.settings, "initial_hip_height")
    if thigh is None or shank is None or height is None:
        return []
    if abs(thigh - shank) < height <= thigh + shank:
        return []
    key = "plant.initial_hip_height"
    unsaid = "" if key in profile.places else " by default"
    return [
        f"{key} is {height * 1e3:g} mm{unsaid}, and with {profile.mechanism}.geometry.thigh of "
        f"{thigh * 1e3:g} mm and {profile.mechanism}.geometry.shank of {shank * 1e3:g} mm it can "
        f"be {abs(thigh - shank) * 1e3:g} … {(thigh + shank) * 1e3:g} mm: say one in between"
    ]


def number_at(settings: object, key: str) -> float | None:
    """Return the number behind a dotted key of settings; None: they have none."""
    for name in key.split("."):
        known = dataclasses.is_dataclass(settings) and {
            f.name for f in dataclasses.fields(settings)
        }
        if not known or name not in known:
            return None
        settings = getattr(settings, name)
    return settings if isinstance(settings, float) else None
