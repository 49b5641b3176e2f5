"""Gains as a search sees them: numbers between 0 and 1, and settings of a law."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from controllers.base import Tunable

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Settings = TypeVar("Settings", bound="DataclassInstance")

Nested = dict[str, "float | Nested"]
"""Of a profile's section."""

_DIGITS = 4
"""Of a gain, as it is tried and written."""


def gains_at(tunables: Sequence[Tunable], place: Sequence[float]) -> dict[str, float]:
    """Return the gains at a place of the search, whose coordinates are between 0 and 1."""
    found = {}
    for tunable, share in zip(tunables, place, strict=True):
        inside = min(max(float(share), 0.0), 1.0)
        gain = tunable.low * (tunable.high / tunable.low) ** inside
        found[tunable.key] = float(f"{gain:.{_DIGITS}g}")
    return found


def values_of(tunables: Sequence[Tunable], settings: object) -> dict[str, float]:
    """Return the gains that settings have."""
    found = {}
    for tunable in tunables:
        value = settings
        for name in tunable.key.split("."):
            value = getattr(value, name)
        assert isinstance(value, float | int)
        found[tunable.key] = float(value)
    return found


def place_of(tunables: Sequence[Tunable], settings: object) -> list[float]:
    """Return where settings are in the search; what is beyond its bounds is put on them."""
    found = []
    for tunable, value in zip(tunables, values_of(tunables, settings).values(), strict=True):
        inside = min(max(value, tunable.low), tunable.high)
        found.append(math.log(inside / tunable.low) / math.log(tunable.high / tunable.low))
    return found


def widened(tunables: Sequence[Tunable], settings: object) -> tuple[Tunable, ...]:
    """Return tunables within whose bounds lies also what settings have: one may go back to it."""
    values = values_of(tunables, settings)
    return tuple(
        [
            gain._replace(
                low=min(gain.low, values[gain.key]), high=max(gain.high, values[gain.key])
            )
            for gain in tunables
        ]
    )


def with_gains(settings: Settings, gains: Mapping[str, float]) -> Settings:
    """Return a law's settings with other gains, ``{"feedforward.gain": 0.9}``."""
    changes: dict[str, Any] = {}
    for key, value in gains.items():
        name, _, below = key.partition(".")
        if below:
            part: DataclassInstance = changes.get(name, getattr(settings, name))
            changes[name] = with_gains(part, {below: value})
        else:
            changes[name] = value
    return dataclasses.replace(settings, **changes)


def nested(gains: Mapping[str, float]) -> Nested:
    """Return gains as a profile's section has them."""
    found: Nested = {}
    for key, value in gains.items():
        *above, name = key.split(".")
        part = found
        for section in above:
            inner = part.setdefault(section, {})
            assert isinstance(inner, dict)
            part = inner
        part[name] = value
    return found
