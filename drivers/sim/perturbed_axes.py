"""Servo joints and links that differ from the profile: drawn from a seed of their own.

They have a generator to themselves, so that what is drawn for pneumatics and cameras stays.
"""

import re
import zlib
from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from annotated_types import Unit

_JOINTS = 16
_LENGTHS = 16
"""Draws are made for so many, so that a mechanism with more of them keeps what it had."""

_NO_DIMENSION = re.compile("min|max|limit|torque|mirror")
"""In the names of what a geometry permits, beside what it measures."""


class AxisDraws(NamedTuple):
    """What was drawn for joints on servo drives and the links between them.

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


def draw_joints(bounds: Any, seed: int) -> AxisDraws:
    """Draw everything in a fixed order: one bound does not change what another one draws."""
    rng = np.random.default_rng([seed, zlib.crc32(b"joints")])
    scale = bounds.joint_scale * rng.uniform(-1.0, 1.0, _JOINTS)
    turned = rng.uniform(0.0, 1.0, _JOINTS) < bounds.joint_reversed
    lengths = bounds.link_length * rng.uniform(-1.0, 1.0, _LENGTHS)
    marker = bounds.marker * rng.standard_normal(3)
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


def perturb_links(geometry: Any, draws: AxisDraws) -> Any:
    """Return a geometry with every length and its marker moved as drawn."""
    shares = iter(draws.lengths)
    changes: dict[str, Any] = {
        name: value + next(shares) for name, value, is_length in dimensions_of(geometry)
        if is_length
    }  # fmt: skip
    if isinstance(getattr(geometry, "marker", None), tuple):  # of a hand; a joint computes it
        pairs = zip(geometry.marker, draws.marker, strict=True)
        changes["marker"] = tuple(value + error for value, error in pairs)
    return replace(geometry, **changes) if changes else geometry


class PerturbedAxes:
    """Joints of a plant as drives see them that err: ``shown = ± (1 + scale) angle - zero``.

    Parameters
    ----------
    plant : object
        The physics.
    draws : AxisDraws
        Directions and scales.
    zeros : tuple of float
        rad.
    """

    def __init__(self, plant: Any, draws: AxisDraws, zeros: tuple[float, ...]) -> None:
        self._plant = plant
        self._gains = tuple(
            (-1.0 if turned else 1.0) * (1.0 + scale)
            for turned, scale in zip(draws.reversed, draws.scale, strict=True)
        )
        self._zeros = zeros

    def command_joint(
        self, channel: int, position: float | None, velocity: float, torque_on: bool
    ) -> None:
        """Give a servo its reference as its drive means it."""
        gain = self._gains[channel]
        true = None if position is None else (position + self._zeros[channel]) / gain
        self._plant.command_joint(channel, true, velocity / gain, torque_on)

    def joint_position(self, channel: int) -> float:
        """Return a joint's angle as its drive has it, rad."""
        true = float(self._plant.joint_position(channel))
        return self._gains[channel] * true - self._zeros[channel]

    def joint_velocity(self, channel: int) -> float:
        """Return a joint's velocity as its drive has it, rad/s."""
        return self._gains[channel] * float(self._plant.joint_velocity(channel))

    def joint_torque(self, channel: int) -> float:
        """Return a joint's torque as its drive has it, N m."""
        return float(self._plant.joint_torque(channel)) / self._gains[channel]
