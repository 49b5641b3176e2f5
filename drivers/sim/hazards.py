"""What must never be true of a plant, from the limits in the profile and a margin each.

A margin is what a rig needs to come to rest after its limit was seen to be passed: a limit alone
is no hazard, and to be far beyond it is one.
"""

import math
from typing import Protocol

from drivers.sim.plants.legs_model import CHANNELS as LEG_CHANNELS
from drivers.sim.plants.spherical_joint_truth import CHANNELS as JOINT_CHANNELS
from rig.hal.hazards import ENERGY_LEFT, Hazard

POSITION_MARGIN = 0.1
"""Of a pair's range."""
SPEED_MARGIN = 0.3
"""Of a permitted speed, on every rig."""
PRESSURE_MARGIN = 20e3
"""Pa: a regulator's overshoot."""
TENSION_MARGIN = 0.5
"""Of the greatest permitted tension: a wire that goes taut rings."""
TILT_MARGIN = math.radians(5.0)
"""Beyond the tilt that is a fault."""
RESIDUAL_PRESSURE = 20e3
"""Pa gauge: what may be left in a chamber that is called safe."""
ANGLE_MARGIN = 0.1
"""Of a servo's axis, rad: its braking distance from a third of its greatest speed."""


class _PneumaticLimits(Protocol):
    @property
    def speed(self) -> float: ...

    @property
    def pressure(self) -> tuple[float, float]: ...


class _PairLimits(_PneumaticLimits, Protocol):
    @property
    def position(self) -> tuple[float, float]: ...


class _JointLimits(_PneumaticLimits, Protocol):
    @property
    def tilt(self) -> float: ...

    @property
    def tilt_excess(self) -> float: ...

    @property
    def tension(self) -> tuple[float, float]: ...


class _Pair(Protocol):
    @property
    def home(self) -> float: ...

    @property
    def stroke(self) -> float: ...

    @property
    def limits(self) -> _PairLimits: ...


class _Joint(Protocol):
    @property
    def limits(self) -> _JointLimits: ...


class _ArmGeometry(Protocol):
    @property
    def position_min(self) -> tuple[float, ...]: ...

    @property
    def position_max(self) -> tuple[float, ...]: ...

    @property
    def rate_limits(self) -> tuple[float, ...]: ...


class _Arm(Protocol):
    @property
    def geometry(self) -> _ArmGeometry: ...


class _LegGeometry(Protocol):
    @property
    def max_rate(self) -> float: ...


class _Legs(Protocol):
    @property
    def geometry(self) -> _LegGeometry: ...


def pair_hazards(settings: _Pair) -> tuple[Hazard, ...]:
    """Return those of one antagonistic pair."""
    low, high = settings.limits.position
    margin = POSITION_MARGIN * (high - low)
    speed = (1.0 + SPEED_MARGIN) * settings.limits.speed
    end = min(settings.home, settings.stroke - settings.home)
    sides = ("agonist", "antagonist")
    return (
        Hazard("position", "m", ("position",), low - margin, high + margin),
        Hazard("end stop hit", "m", ("position",), -end, end),
        Hazard("speed", "m/s", ("velocity",), -speed, speed),
        *_pressures(settings.limits, sides),
    )


def joint_hazards(settings: _Joint) -> tuple[Hazard, ...]:
    """Return those of the spherical joint."""
    limits = settings.limits
    tilt = limits.tilt + limits.tilt_excess + TILT_MARGIN
    speed = (1.0 + SPEED_MARGIN) * limits.speed
    tension = (1.0 + TENSION_MARGIN) * limits.tension[1]
    return (
        Hazard("tilt", "rad", ("axis_z",), -math.inf, tilt, of=_tilt),
        Hazard("speed", "m/s", _each("speed", JOINT_CHANNELS), -speed, speed),
        Hazard("tension", "N", _each("tension", JOINT_CHANNELS), -math.inf, tension),
        *_pressures(limits, JOINT_CHANNELS),
    )


def arm_hazards(settings: _Arm) -> tuple[Hazard, ...]:
    """Return those of an arm: ranges and speeds of its axes."""
    geometry = settings.geometry
    found = []
    for k, axis in enumerate(f"q{k}" for k in range(1, len(geometry.rate_limits) + 1)):
        low, high = geometry.position_min[k], geometry.position_max[k]
        rate = (1.0 + SPEED_MARGIN) * geometry.rate_limits[k]
        found += [
            Hazard("range", "rad", (axis,), low - ANGLE_MARGIN, high + ANGLE_MARGIN),
            Hazard("rate", "rad/s", (f"{axis}_velocity",), -rate, rate),
        ]
    return tuple(found)


def legs_hazards(settings: _Legs) -> tuple[Hazard, ...]:
    """Return those of walking legs: they fall, or an axis runs away."""
    rate = (1.0 + SPEED_MARGIN) * settings.geometry.max_rate
    return (
        # On the ground the plant means nothing: only the soles touch it.
        Hazard("fall", "1", ("fell",), -math.inf, 0.5, is_last=True),
        Hazard("rate", "rad/s", tuple(f"{axis}_velocity" for axis in LEG_CHANNELS), -rate, rate),
    )


def _pressures(limits: _PneumaticLimits, channels: tuple[str, ...]) -> tuple[Hazard, ...]:
    columns = _each("pressure", channels)
    high = limits.pressure[1] + PRESSURE_MARGIN
    return (
        Hazard("pressure", "Pa", columns, -math.inf, high),
        Hazard(ENERGY_LEFT, "Pa", columns, -math.inf, RESIDUAL_PRESSURE, only_safe=True),
    )


def _each(quantity: str, channels: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{quantity}_{channel}" for channel in channels)


def _tilt(axis_z: float) -> float:
    """Return the tilt of an axis whose vertical part this is, rad."""
    return math.acos(max(-1.0, min(1.0, axis_z)))
