"""Servo joints and links that differ from the profile: drawn from a seed of their own.

They have a generator to themselves, so that what is drawn for pneumatics and cameras stays.
"""

import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
from annotated_types import Unit

_JOINTS = 16
_LENGTHS = 16
"""Draws are made for so many, so that a mechanism with more of them keeps what it had."""

_NO_DIMENSION = re.compile("min|max|limit|torque|mirror")
"""In the names of what a geometry permits, beside what it measures."""


Geometry = TypeVar("Geometry", bound=Any)  # a dataclass


class AxisDraws(NamedTuple):
    """The draws for joints on servo drives and the links between them.

    Parameters
    ----------
    scale : tuple of float
        Share by which each encoder counts too much.
    reversed : tuple of bool
        Whether each drive turns the other way than the profile says.
    lengths : tuple of float
        Of each length of the geometry in its order, m.
    marker : tuple of float
        Of the marker on the hand, m, length 3.
    """

    scale: tuple[float, ...] = (0.0,) * _JOINTS
    reversed: tuple[bool, ...] = (False,) * _JOINTS
    lengths: tuple[float, ...] = (0.0,) * _LENGTHS
    marker: tuple[float, ...] = (0.0, 0.0, 0.0)


def draw_joints(bounds: Mapping[str, float], seed: int) -> AxisDraws:
    """Draw everything in a fixed order: one bound does not change what another one draws."""
    rng = np.random.default_rng([seed, zlib.crc32(b"joints")])
    scale = bounds["joint_scale"] * rng.uniform(-1.0, 1.0, _JOINTS)
    turned = rng.uniform(0.0, 1.0, _JOINTS) < bounds["joint_reversed"]
    lengths = bounds["link_length"] * rng.uniform(-1.0, 1.0, _LENGTHS)
    marker = bounds["marker"] * rng.standard_normal(3)
    return AxisDraws(
        tuple(scale.tolist()),
        tuple(turned.tolist()),
        tuple(lengths.tolist()),
        tuple(marker.tolist()),
    )


def dimensions_of(geometry: Any) -> Iterator[tuple[str, Any, bool]]:
    """Yield name, value and whether it is a length, of what a geometry measures in floats."""
    hints = get_type_hints(type(geometry), include_extras=True)
    for entry in fields(geometry):
        value = getattr(geometry, entry.name)
        if _NO_DIMENSION.search(entry.name) or entry.name == "marker":
            continue
        if isinstance(value, float):
            units = [m.unit for m in getattr(hints[entry.name], "__metadata__", ())
                     if isinstance(m, Unit)]  # fmt: skip
            yield entry.name, value, units == ["m"]
        elif isinstance(value, tuple) and all(isinstance(item, float) for item in value):
            yield entry.name, value, False


def perturb_links(geometry: Geometry, draws: AxisDraws) -> Geometry:
    """Return a geometry with every length and its marker moved as drawn."""
    shares = iter(draws.lengths)
    changes: dict[str, Any] = {
        name: value + next(shares) for name, value, is_length in dimensions_of(geometry)
        if is_length
    }  # fmt: skip
    if any(entry.name == "marker" for entry in fields(geometry)):  # of a hand
        pairs = zip(geometry.marker, draws.marker, strict=True)
        changes["marker"] = tuple(value + error for value, error in pairs)
    return replace(geometry, **changes) if changes else geometry
