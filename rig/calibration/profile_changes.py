"""A profile with other values than its files have, checked as `--set` checks them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from rig.config import Profile
from rig.config.settings import annotation
from rig.hal import ConfigurationError

S = TypeVar("S")


def profile_with(profile: Profile, changes: Mapping[str, object]) -> Profile:
    """Return a profile with other values.

    Parameters
    ----------
    profile : Profile
        As it was loaded.
    changes : mapping of str to object
        By dotted names, as in ``"devices.camera.max_absence"``; in SI.

    Raises
    ------
    ConfigurationError
        A settings class does not permit a value.
    """
    for key, value in changes.items():
        section, *path = key.split(".")
        if section == profile.mechanism:
            settings = _changed(profile.mechanism_settings, path, value)
            profile = replace(profile, mechanism_settings=settings)
        elif section == "devices":
            entry = profile.devices[path[0]]
            entry = replace(entry, settings=_changed(entry.settings, path[1:], value))
            profile = replace(profile, devices={**profile.devices, path[0]: entry})
        elif section == "controllers":
            settings = _changed(profile.controllers[path[0]], path[1:], value)
            profile = replace(profile, controllers={**profile.controllers, path[0]: settings})
        elif section == "plant" and profile.plant is not None:
            plant = replace(profile.plant, settings=_changed(profile.plant.settings, path, value))
            profile = replace(profile, plant=plant)
        else:
            raise ConfigurationError(f"{key} cannot be changed in the profile {profile.name}")
    return profile


def with_wider_limits(
    profile: Profile, least: Mapping[str, float]
) -> tuple[Profile, tuple[str, ...]]:
    """Return a profile with limits that rest on what is looked for, and notes on them.

    Parameters
    ----------
    profile : Profile
        The rig's.
    least : mapping of str to float
        How wide limits have to be at least, m.
    """
    usual = profile.mechanism_settings.limits
    wider = {name: value for name, value in least.items() if value > getattr(usual, name)}
    notes = tuple(
        f"limits.{name} is {1e3 * value:g} mm instead of {1e3 * getattr(usual, name):g} mm: "
        "it rests on what is looked for"
        for name, value in wider.items()
    )
    changes = {f"{profile.mechanism}.limits.{name}": value for name, value in wider.items()}
    return profile_with(profile, changes), notes


def _changed(settings: S, path: list[str], value: object) -> S:
    """Return settings with one value, validated by the types and bounds of their class."""
    for key in reversed(path):
        value = {key: value}
    try:
        strict = cast("type[S]", annotation(type(settings), settings))
        changed = TypeAdapter(strict).validate_python(value)
    except ValidationError as error:
        details = error.errors(include_url=False)[0]
        raise ConfigurationError(f"{'.'.join(path)}: {details['msg']}") from error
    return changed
