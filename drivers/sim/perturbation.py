"""How a simulated rig differs from its profile: drawn from a seed, known to the simulation alone.

A calibration has something to find only if the rig is not what its profile says. Plants take
perturbed settings; between a plant and a device stands a port of `drivers.sim.axis_lines`,
`regulator_lines` or `rod_lines`, whose sensors and actuators err as real ones do.
"""

import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from drivers.sim.perturbed_geometry import (
    AxisDraws,
    Geometry,
    dimensions_of,
    draw_joints,
    perturb_links,
)
from rig.hal import PhysicsSettings

_CHANNELS = 16
"""Draws are made for so many channels, so that a rig with more of them keeps what it had."""


Bounds = Mapping[str, float]
"""The profile's bounds of each draw by their names, SI."""

Line = tuple[float, float]
"""Gain and offset of a straight line."""

Changed = TypeVar("Changed", bound=PhysicsSettings)


class Draws(NamedTuple):
    """Everything that was drawn, each within its bound.

    Parameters
    ----------
    channels : mapping of str to tuple of float
        By the name of the bound, one value per channel or joint.
    friction, wire_offset : float
        Share of the friction, and m.
    geometry : tuple of float
        Shares, one per dimension in their order.
    camera_position, camera_angle : tuple of float
        m and rad, length 3.
    joints : AxisDraws
        Of servo joints and the links between them.
    leaks : tuple of float
        Sonic conductance of each chamber's leak, m³/(s Pa).
    stribeck : float
        Share of the seals' Stribeck velocity.
    """

    channels: Mapping[str, tuple[float, ...]]
    friction: float
    wire_offset: float
    geometry: tuple[float, ...]
    camera_position: tuple[float, float, float]
    camera_angle: tuple[float, float, float]
    joints: AxisDraws = AxisDraws()
    leaks: tuple[float, ...] = (0.0,) * _CHANNELS
    stribeck: float = 0.0

    def lines(self, gain: str, offset: str) -> dict[int, Line]:
        """Return the line of each channel by the names of its draws: ``1 + gain``, and offset."""
        drawn = zip(self.channels[gain], self.channels[offset], strict=True)
        return {k: (1.0 + share, shift) for k, (share, shift) in enumerate(drawn)}


PER_CHANNEL = (
    "setpoint_gain", "setpoint_offset", "monitor_gain", "monitor_offset", "encoder_scale",
    "encoder_offset", "joint_zero",
)  # fmt: skip


def draw(bounds: Bounds, seed: int) -> Draws:
    """Draw everything in a fixed order: one bound does not change what another one draws."""
    rng = np.random.default_rng([seed, zlib.crc32(b"perturbation")])

    def values(bound: float, count: int) -> tuple[float, ...]:
        return tuple((bound * rng.uniform(-1.0, 1.0, count)).tolist())

    channels = {name: values(bounds[name], _CHANNELS) for name in PER_CHANNEL}
    (friction,), (wire_offset,) = values(bounds["friction"], 1), values(bounds["wire_offset"], 1)
    geometry = values(bounds["geometry"], _CHANNELS)
    position, angle = values(bounds["camera_position"], 3), values(bounds["camera_angle"], 3)
    joints = draw_joints(bounds, seed)
    # No chamber is tight if any may leak: between a third of the bound and the whole of it.
    leak = bounds["leak"]
    leaks = tuple((2.0 * leak + share) / 3.0 for share in values(leak, _CHANNELS))
    (stribeck,) = values(bounds["stribeck"], 1)
    return Draws(
        channels, friction, wire_offset, geometry,
        position, angle, joints, leaks, stribeck,  # type: ignore[arg-type]
    )  # fmt: skip


def perturb_plant(settings: Changed, draws: Draws) -> Changed:
    """Return a plant's settings with its friction and wires as drawn; others are left alone."""
    return settings.perturbed(
        friction=draws.friction, stribeck=draws.stribeck, wire_offset=draws.wire_offset
    )


def perturb_geometry(geometry: Geometry, draws: Draws) -> Geometry:
    """Return a geometry with every length scaled and every angle turned as drawn.

    An angle turns by its share of a right angle. Links and markers are moved besides.
    """
    shares = iter(draws.geometry)
    changes: dict[str, Any] = {}
    for name, value, _ in dimensions_of(geometry):
        if isinstance(value, float):
            changes[name] = value * (1.0 + next(shares))
        else:
            # Against each other: nothing but the wires themselves says from where angles count.
            turns = [next(shares) * 0.5 * np.pi for _ in value]
            mean = sum(turns) / len(turns)
            changes[name] = tuple(v + turn - mean for v, turn in zip(value, turns, strict=True))
    return perturb_links(replace(geometry, **changes), draws.joints)
