"""In what the simulated arm is another one than a path is timed for."""

import math
from collections.abc import Iterator
from typing import Protocol, cast

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.pose_path import PosePath

_LINKS = ("shoulder", "upper arm", "forearm", "first", "second", "third link of the wrist")
_ALIKE = 0.05
"""Share by which numbers of the same meaning may differ: estimates have no more digits."""


class _Links(Protocol):
    masses: tuple[float, ...]
    payload: float


class _Drives(Protocol):
    torque_limits: tuple[float, ...]


class _Plant(Protocol):
    links: _Links
    drives: _Drives
    start: tuple[float, ...] | None


def differences(geometry: ArmGeometry, reference: object, plant: object) -> Iterator[str]:
    """Yield what the simulated arm has otherwise: payload, masses, the drives' torques.

    Masses and torques count where the path is timed with them.
    """
    if not hasattr(plant, "links"):
        return
    its = cast("_Plant", plant)
    yield from _starts_outside(geometry, its)
    if not isinstance(reference, PosePath):
        return
    carried = reference.payload.mass
    if (carried > 0.0 or reference.torques) and not _alike(carried, its.links.payload):
        yield (
            f"the path is planned with a payload of {carried:g} kg (reference.payload), and the "
            f"simulated arm carries {its.links.payload:g} kg (plant.links.payload)"
        )
    if not reference.torques or geometry.dynamics is None:
        return
    ours, own = geometry.dynamics.torque_limits, its.drives.torque_limits
    for name, believed, true in zip(AXIS_NAMES, ours, own, strict=True):
        if not _alike(believed, true):
            yield (
                f"the path is timed for {believed:g} N m of {name} (arm.geometry.dynamics), and "
                f"the simulated drive has {true:g} N m (plant.drives.torque_limits)"
            )
            break
    for name, believed, true in zip(
        _LINKS, geometry.dynamics.masses, its.links.masses, strict=True
    ):
        if not _alike(believed, true):
            yield (
                f"the path is timed for {believed:g} kg of the {name} (arm.geometry.dynamics), "
                f"and the simulated one has {true:g} kg (plant.links.masses)"
            )
            break


def _starts_outside(geometry: ArmGeometry, plant: _Plant) -> Iterator[str]:
    for name, start, low, high in zip(
        AXIS_NAMES, plant.start or (), geometry.position_min, geometry.position_max, strict=False
    ):
        if not low <= start <= high:
            yield (
                f"the simulated arm is to start with {name} at {math.degrees(start):.4g} deg "
                f"(plant.start), outside its range of {math.degrees(low):.4g} to "
                f"{math.degrees(high):.4g} deg: no simulation begins there"
            )


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= _ALIKE * max(abs(one), abs(other))
