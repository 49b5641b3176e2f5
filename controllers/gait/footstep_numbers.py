"""Footprints from numbers: straight on, aside, round a bend, up and down."""

import math

from controllers.gait.footprints import Foot, Footstep, StepNumbers
from controllers.gait.geometry import LegGeometry
from controllers.gait.ground_plane import GroundPlane


def number_footsteps(
    geometry: LegGeometry, numbers: StepNumbers, ground: GroundPlane
) -> tuple[Footstep, ...]:
    """Return the footprints of numbers.

    Parameters
    ----------
    geometry : LegGeometry
        For the width of the stance.
    numbers : StepNumbers
        How they go on.
    ground : GroundPlane
        On which they do.
    """
    width = 2.0 * geometry.hip_half_spacing if numbers.width is None else numbers.width
    other: Foot = "left" if numbers.first == "right" else "right"
    x = y = heading = height = 0.0
    steps: list[Footstep] = []

    def put(foot: Foot) -> None:
        side = 0.5 * width if foot == "left" else -0.5 * width
        s, c = math.sin(heading), math.cos(heading)
        at, lies = (x - s * side, y + c * side), ground.tilt(heading)
        over = height + ground.height(*at)
        steps.append(Footstep(foot, *at, heading, over, lies.pitch, lies.roll))

    foot = numbers.first
    for number in range(numbers.count):
        foot = numbers.first if numbers.together or number % 2 == 0 else other
        # Half of the turn before the way and half after it: places on a circle.
        middle = heading + 0.5 * numbers.turn
        s, c = math.sin(middle), math.cos(middle)
        x += c * numbers.length - s * numbers.aside
        y += s * numbers.length + c * numbers.aside
        heading, height = heading + numbers.turn, height + numbers.rise
        put(foot)
        if numbers.together and (numbers.close or number < numbers.count - 1):
            put(other)
    if numbers.close and not numbers.together:
        put(other if foot == numbers.first else numbers.first)
    return tuple(steps)
