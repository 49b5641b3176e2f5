"""How a simulated rig differs from its profile: drawn from a seed, known to the simulation alone.

A calibration has something to find only if the rig is not what its profile says. Plants take
perturbed settings; between the plant and the devices stands `PerturbedPlant`, whose sensors and
regulators err as real ones do.
"""

import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from drivers.sim.perturbed_axes import (
    AxisDraws,
    PerturbedAxes,
    dimensions_of,
    draw_joints,
    perturb_links,
)

_CHANNELS = 16
"""Draws are made for so many channels, so that a rig with more of them keeps what it had."""


class Bounds(Protocol):
    """The profile's bounds of each draw; the attributes are those of its section."""

    def __getattribute__(self, name: str, /) -> Any:
        """Return one bound, SI."""
        ...


class Draws(NamedTuple):
    """What was drawn, each within its bound.

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


PER_CHANNEL = (
    "setpoint_gain", "setpoint_offset", "monitor_gain", "monitor_offset", "encoder_scale",
    "encoder_offset", "joint_zero",
)  # fmt: skip


def draw(bounds: Bounds, seed: int) -> Draws:
    """Draw everything in a fixed order: one bound does not change what another one draws."""
    rng = np.random.default_rng([seed, zlib.crc32(b"perturbation")])

    def values(bound: float, count: int) -> tuple[float, ...]:
        return tuple((bound * rng.uniform(-1.0, 1.0, count)).tolist())

    channels = {name: values(getattr(bounds, name), _CHANNELS) for name in PER_CHANNEL}
    (friction,), (wire_offset,) = values(bounds.friction, 1), values(bounds.wire_offset, 1)
    geometry = values(bounds.geometry, _CHANNELS)
    position, angle = values(bounds.camera_position, 3), values(bounds.camera_angle, 3)
    joints = draw_joints(bounds, seed)
    # No chamber is tight if any may leak: between a third of the bound and the whole of it.
    leaks = tuple((2.0 * bounds.leak + share) / 3.0 for share in values(bounds.leak, _CHANNELS))
    (stribeck,) = values(bounds.stribeck, 1)
    return Draws(
        channels, friction, wire_offset, geometry,
        position, angle, joints, leaks, stribeck,  # type: ignore[arg-type]
    )  # fmt: skip


def perturb_plant(settings: Any, draws: Draws) -> Any:
    """Return a plant's settings with its friction and wires as drawn; others are left alone."""
    changes: dict[str, Any] = {}
    if hasattr(settings, "friction_scale"):
        changes["friction_scale"] = settings.friction_scale * (1.0 + draws.friction)
    if hasattr(settings, "stribeck_scale"):
        changes["stribeck_scale"] = settings.stribeck_scale * (1.0 + draws.stribeck)
    if hasattr(settings, "home"):
        changes["home"] = settings.home + draws.wire_offset
    return replace(settings, **changes) if changes else settings


def perturb_geometry(geometry: Any, draws: Draws) -> Any:
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


class PerturbedPlant:
    """A plant behind sensors and regulators that err; everything else is the plant's own.

    Parameters
    ----------
    plant : object
        The physics.
    draws : Draws
        By how much each channel errs.
    """

    def __init__(self, plant: Any, draws: Draws) -> None:
        self._plant = plant
        of = draws.channels
        self._setpoint = tuple(zip(of["setpoint_gain"], of["setpoint_offset"], strict=True))
        self._monitor = tuple(zip(of["monitor_gain"], of["monitor_offset"], strict=True))
        self._encoder = tuple(zip(of["encoder_scale"], of["encoder_offset"], strict=True))
        if any(draws.leaks):
            plant.set_leaks(draws.leaks[: len(plant.channel_names)])
        joints = PerturbedAxes(plant, draws.joints, of["joint_zero"])
        self.command_joint = joints.command_joint
        self.joint_position = joints.joint_position
        self.joint_velocity = joints.joint_velocity
        self.joint_torque = joints.joint_torque

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator what it makes of a setpoint, Pa gauge."""
        gain, offset = self._setpoint[channel]
        self._plant.set_pressure_setpoint(channel, (1.0 + gain) * pressure + offset)

    def pressure(self, channel: int) -> float:
        """Return what a monitor shows, Pa gauge."""
        gain, offset = self._monitor[channel]
        return (1.0 + gain) * float(self._plant.pressure(channel)) + offset

    def position(self, channel: int) -> float:
        """Return what an encoder makes of a rod's extension, m."""
        scale, offset = self._encoder[channel]
        return (1.0 + scale) * float(self._plant.position(channel)) + offset

    def speed(self, channel: int) -> float:
        """Return what an encoder makes of a rod's speed, m/s."""
        return (1.0 + self._encoder[channel][0]) * float(self._plant.speed(channel))
