"""Whether a walk's footprints lie on the simulated ground, and its swings clear that."""

import math
from collections.abc import Iterable, Sequence
from typing import Protocol, cast

from controllers.gait.footprints import Footstep
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.ground_plane import GroundPlane
from controllers.gait.kinematics import Vector
from controllers.gait.soles import heights_of, sole_corners
from controllers.gait.turning import Attitude
from controllers.motion import InfeasibleMotion

_OFF = 2e-3
"""m; a print that is farther from the ground is another ground's. Soles land as hard as that."""
_TOUCHES = 1e-3
"""m; an edge that is no farther under a sole touches it at most."""
_INTO = 2e-4
"""m; a swing that dips into the ground by more is caught by it."""
_LOOKED_AT = 100
"""Places of a swing that are looked at."""
_TURNED = math.radians(0.5)
"""rad; ground whose slope is farther from that of the plan is another ground."""


class _Block(Protocol):
    start: float
    length: float
    height: float
    slope: float


class _Ground(Protocol):
    terrain: Iterable[_Block]
    floor_pitch: float
    floor_roll: float


def prints_off_ground(geometry: LegGeometry, reference: object, plant: object) -> tuple[str, ...]:
    """Say how the ground of the start is otherwise, or which footprint is off it as the first.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    reference : object
        The experiment's; those without footprints begin and walk on the level.
    plant : object
        Settings of the plant.
    """
    if not hasattr(plant, "terrain"):
        return ()
    its = cast("_Ground", plant)
    walk = reference if isinstance(reference, FootstepsSettings) else None
    start = GroundPlane(walk.start_pitch, walk.start_roll) if walk else GroundPlane()
    floor = GroundPlane(its.floor_pitch, its.floor_roll)
    for name, planned, simulated in zip(GroundPlane._fields, start, floor, strict=True):
        if abs(planned - simulated) > _TURNED:
            return (
                f"the plan begins on ground with a {name} of {math.degrees(planned):.4g} deg "
                f"(reference.start_{name}), and the simulated floor has "
                f"{math.degrees(simulated):.4g} deg (plant.floor_{name})",
            )
    if walk is None:
        return ()
    terrain = tuple(its.terrain)
    for number, step in enumerate(walk.footsteps(geometry), 1):
        ground = max(_height(terrain, step.x), floor.height(step.x, step.y))
        if abs(step.height - ground) > _OFF:
            words = (
                f"step {number} is planned to land {_words(step.height)}, and the simulated ground "
                f"there is {_words(ground)} (plant.terrain)"
            )
            return (walk.with_line(words),)
        over = _edge_under(geometry, step, terrain)
        if over is not None:
            x, higher = over
            words = (
                f"step {number} is planned to land on an edge: at x {x * 1e3:.1f} mm, still under "
                f"the sole, the simulated ground is {higher * 1e3:.3g} mm higher (plant.terrain)"
            )
            return (walk.with_line(words),)
    return _swings_into(geometry, walk, terrain)


def _swings_into(
    geometry: LegGeometry, walk: FootstepsSettings, terrain: Sequence[_Block]
) -> tuple[str, ...]:
    """Say which swings bring their soles into the simulated ground."""
    try:
        phases = walk.phases(geometry)
    except InfeasibleMotion:  # which is told where it is planned
        return ()
    told = []
    for phase in phases:
        if all(phase.standing):
            continue
        leg = 0 if phase.standing[1] else 1
        deepest, at = 0.0, 0.0
        for xi in (k / _LOOKED_AT for k in range(1, _LOOKED_AT)):
            depth = _depth(geometry, phase.foot_at(leg, xi), phase.attitude_at(leg, xi), terrain)
            deepest, at = max((deepest, at), (depth, xi))
        if deepest > _INTO:
            told.append(
                f"{phase.name}, {100.0 * at:.0f} % of the way, would bring the sole "
                f"{deepest * 1e3:.3g} mm into the simulated ground (plant.terrain): a lift of its "
                f"own, or a print farther on, clears the edge"
            )
    return tuple(told)


def _depth(geometry: LegGeometry, at: Vector, lies: Attitude, terrain: Sequence[_Block]) -> float:
    """Return how deep a sole is in what lies on the floor, m; negative: it is above it."""
    ahead = [x for x, _ in sole_corners(geometry, at, lies)]
    deepest = -math.inf
    for block in terrain:
        ends = max(min(ahead), block.start), min(max(ahead), block.start + block.length)
        if ends[0] < ends[1]:
            soles = heights_of(at, lies, [(x, at[1]) for x in ends])
            tops = [block.height + math.tan(block.slope) * (x - block.start) for x in ends]
            deepest = max(deepest, *(top - sole for top, sole in zip(tops, soles, strict=True)))
    return deepest


def _edge_under(
    geometry: LegGeometry, step: Footstep, terrain: Iterable[_Block]
) -> tuple[float, float] | None:
    """Return where higher ground begins or ends under a sole, m, and by how much it is higher."""
    at = (step.x, step.y, step.height)
    lies = (step.roll, step.pitch, step.heading)
    ahead = [x for x, _ in sole_corners(geometry, at, lies)]
    back, front = min(ahead) + _TOUCHES, max(ahead) - _TOUCHES
    for block in terrain:
        for edge in (block.start, block.start + block.length):
            if back < edge < front:
                top = block.height + math.tan(block.slope) * (edge - block.start)
                (sole,) = heights_of(at, lies, [(edge, step.y)])
                if top - sole > _OFF:
                    return edge, top - sole
    return None


def _words(height: float) -> str:
    if height == 0.0:
        return "level with the start"
    return f"{abs(height) * 1e3:.4g} mm {'above' if height > 0.0 else 'below'} the start"


def _height(terrain: Iterable[_Block], ahead: float) -> float:
    """Return how high what lies on the floor is so far ahead, m; minus infinity: nothing does."""
    levels = [
        block.height + math.tan(block.slope) * (ahead - block.start)
        for block in terrain
        if block.start <= ahead <= block.start + block.length
    ]
    return max(levels, default=-math.inf)
