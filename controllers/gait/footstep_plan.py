"""The phases of a walk over footprints, each step checked, and what would fit where one is not."""

import math
from collections.abc import Sequence
from functools import lru_cache

from controllers.gait.footprints import Footstep, SteppingSettings
from controllers.gait.footstep_advice import SwingSoles, advise
from controllers.gait.footstep_checks import BeyondLeg, check_phase
from controllers.gait.footstep_phases import AnkleTooFar, HipNeed, hip_needs, walk_over, walk_phases
from controllers.gait.footstep_trials import Trials
from controllers.gait.geometry import LegGeometry
from controllers.gait.phases import GaitPhase
from controllers.gait.walk_advice import advise_manner, advise_walk
from controllers.motion import InfeasibleMotion


@lru_cache(maxsize=8)  # a plan asks at two periods, for its length, and for how fast it can be
def plan_footsteps(
    geometry: LegGeometry,
    settings: SteppingSettings,
    steps: tuple[Footstep, ...],
    min_margin: float = -math.inf,
) -> tuple[GaitPhase, ...]:
    """Return the phases of a walk over footprints.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    settings : SteppingSettings
        How to walk.
    steps : tuple of Footstep
        Where the feet come down.
    min_margin : float
        Least distance of the centre of mass from the edge of what the feet stand on, m.

    Raises
    ------
    InfeasibleMotion
        A step is out of reach, turns a joint out of its range, tips the robot over, or brings the
        foot against the other one or the edge of where it is to stand; with its number, the number
        and its bound, and what would fit.
    """
    walk = walk_over(geometry, settings, steps)
    trials = Trials(geometry, steps, min_margin)
    try:
        needs = hip_needs(geometry, settings, walk)
    except AnkleTooFar as error:
        hint = _what_fits(trials, settings, (error.step,), None, error)
        raise InfeasibleMotion(f"{error}{hint}") from error
    lowest = min(needs, key=lambda need: need.hips)
    hip = lowest.hips if settings.hip is None else settings.hip
    phases, numbers = walk_phases(geometry, settings, steps, walk, hip)
    for place, (phase, number) in enumerate(zip(phases, numbers, strict=True)):
        try:
            check_phase(geometry, phase, min_margin)
        except InfeasibleMotion as error:
            told = f"step {number}, {error}"
            to_change: tuple[int, ...] = (number,)
            if settings.hip is None and isinstance(error, BeyondLeg):
                higher = _hips_without(needs, number, lowest.step)
                tried = [
                    walk_phases(geometry, settings, steps, walk, own)[0][place]
                    for own in higher
                    if own > hip
                ]
                if any(_passes(geometry, phase, min_margin) for phase in tried):
                    told = (
                        f"step {lowest.step} needs the hips at {hip * 1e3:.1f} mm over the "
                        f"standing ankle, which is too low for step {number}: {error}"
                    )
                    to_change = (lowest.step, number)
            hint = _what_fits(trials, settings, to_change, hip, error)
            raise InfeasibleMotion(f"{told}{hint}") from error
    return phases


def _hips_without(needs: Sequence[HipNeed], number: int, lowest: int) -> set[float]:
    """Return how high the hips could be for a step and the next, and without the lowest step, m."""
    about = [need.hips for need in needs if need.step in (number, number + 1)]
    others = [need.hips for need in needs if need.step != lowest]
    return {min(hips) for hips in (about, others) if hips}


def _passes(geometry: LegGeometry, phase: GaitPhase, min_margin: float) -> bool:
    try:
        check_phase(geometry, phase, min_margin)
    except InfeasibleMotion:
        return False
    return True


def _what_fits(
    trials: Trials,
    settings: SteppingSettings,
    to_change: tuple[int, ...],
    hip: float | None,
    error: InfeasibleMotion,
) -> str:
    """Say what would fit instead of a walk that is refused with an error.

    Another manner of walking that lets all steps be as they are is best; else what would do for
    one of the steps to change, and how all would fit. `hip` is the hips' height, m; of two steps
    to change, the first one sets it.
    """
    whole = trials._replace(number=to_change[-1])
    said = advise_manner(whole, settings, error)
    if said:
        return said
    for number in to_change:
        own = None if number != to_change[-1] else hip
        said = _of_step(trials._replace(number=number), settings, own, error)
        if said:
            break
    climbs = any(step.height for step in trials.steps)
    if climbs or not said:
        said += advise_walk(whole, settings)
    return said or (
        " No part of the step, no other lift, no other place of the waist and no flatter, longer "
        "or shorter steps that were tried would do."
    )


def _of_step(
    trials: Trials, settings: SteppingSettings, hip: float | None, error: InfeasibleMotion
) -> str:
    """Say what would fit in the place of one step."""
    number = trials.number
    asked = trials.steps[number - 1]
    stance = walk_over(trials.geometry, settings, trials.steps[:number]).stances[-1]
    soles = (stance.support, stance.before, stance.after)
    support, stood, after = ((sole.at, sole.attitude) for sole in soles)
    place = SwingSoles(support, stood, after, 2.0 * trials.geometry.side(stance.leg))
    name = f"step {number}" if hip is None else f"step {number} by itself"

    def fits(step: Footstep) -> bool:
        return trials.step_fits(step, settings, hip)

    return advise(fits, asked, settings.lift, place, name, error)
