"""Whether the simulated ground is where a walk's footprints lie."""

import math
from collections.abc import Iterable
from typing import Protocol, cast

from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import LegGeometry

_OFF = 2e-3
"""m; a print that is farther from the ground is another ground's. Soles land as hard as that."""


class _Block(Protocol):
    start: float
    length: float
    height: float
    slope: float


class _Ground(Protocol):
    terrain: Iterable[_Block]


def prints_off_ground(geometry: LegGeometry, reference: object, plant: object) -> tuple[str, ...]:
    """Say which footprint is the first that lies above or below the simulated ground.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    reference : object
        The experiment's; those without footprints walk on the level.
    plant : object
        Settings of the plant.
    """
    if not isinstance(reference, FootstepsSettings) or not hasattr(plant, "terrain"):
        return ()
    terrain = tuple(cast("_Ground", plant).terrain)
    for number, step in enumerate(reference.footsteps(geometry), 1):
        ground = _height(terrain, step.x)
        if abs(step.height - ground) > _OFF:
            return (
                f"step {number} is planned to land {_words(step.height)}, and the simulated ground "
                f"there is {_words(ground)} (plant.terrain)",
            )
    return ()


def _words(height: float) -> str:
    if height == 0.0:
        return "level with the start"
    return f"{abs(height) * 1e3:.4g} mm {'above' if height > 0.0 else 'below'} the start"


def _height(terrain: Iterable[_Block], ahead: float) -> float:
    """Return how high the ground is so far ahead, m."""
    levels = [
        block.height + math.tan(block.slope) * (ahead - block.start)
        for block in terrain
        if block.start <= ahead <= block.start + block.length
    ]
    return max(levels, default=0.0)
