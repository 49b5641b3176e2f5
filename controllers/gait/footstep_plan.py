"""The phases of a walk over footprints, each step checked, and what would fit where one is not."""

from collections.abc import Sequence
from dataclasses import replace

from controllers.gait.footprints import Footstep, SteppingSettings
from controllers.gait.footstep_advice import SwingSoles, advise
from controllers.gait.footstep_checks import BeyondLeg, MeetsGround, TwoHeights, check_phase
from controllers.gait.footstep_phases import hip_needs, walk_over, walk_phases
from controllers.gait.geometry import LegGeometry
from controllers.gait.phases import GaitPhase
from controllers.gait.walk_advice import advise_walk
from controllers.motion import InfeasibleMotion

_FOLLOWS = range(5, 85, 5)
"""How far the waist might follow, mm, where a leg is beyond its ranges."""


def plan_footsteps(
    geometry: LegGeometry, settings: SteppingSettings, steps: Sequence[Footstep]
) -> tuple[GaitPhase, ...]:
    """Return the phases of a walk over footprints.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    settings : SteppingSettings
        How to walk.
    steps : sequence of Footstep
        Where the feet come down.

    Raises
    ------
    InfeasibleMotion
        A step is out of reach, turns a joint out of its range, or brings the foot against the
        other one or the edge of where it is to stand; with its number, the number and its bound,
        and how much of the step would fit.
    """
    walk = walk_over(geometry, settings, steps)
    needs = hip_needs(geometry, settings, walk)
    lowest = min(needs, key=lambda need: need.hips)
    hip = lowest.hips if settings.hip is None else settings.hip
    phases, numbers = walk_phases(geometry, settings, steps, walk, hip)
    for place, (phase, number) in enumerate(zip(phases, numbers, strict=True)):
        try:
            check_phase(geometry, phase)
        except InfeasibleMotion as error:
            if settings.hip is None and isinstance(error, BeyondLeg):
                own = min(need.hips for need in needs if need.step in (number, number + 1))
                higher, _ = walk_phases(geometry, settings, steps, walk, own)
                if own > hip and _passes(geometry, higher[place]):
                    hint = _what_fits(geometry, settings, steps, lowest.step, None, error)
                    raise InfeasibleMotion(
                        f"step {lowest.step} needs the hips at {hip * 1e3:.1f} mm over the "
                        f"standing ankle, which is too low for step {number}: {error}{hint}"
                    ) from error
            hint = _what_fits(geometry, settings, steps, number, hip, error)
            raise InfeasibleMotion(f"step {number}, {error}{hint}") from error
    return phases


def _passes(geometry: LegGeometry, phase: GaitPhase) -> bool:
    try:
        check_phase(geometry, phase)
    except InfeasibleMotion:
        return False
    return True


def _what_fits(
    geometry: LegGeometry,
    settings: SteppingSettings,
    steps: Sequence[Footstep],
    number: int,
    hip: float | None,
    error: InfeasibleMotion,
) -> str:
    """Say what would fit instead of a step that is refused with an error.

    With hips of a given height all before it is known to, and they are no higher than that.
    Without, they are as high as the steps up to it let them be, until the other foot has left the
    ground, and all of these have to fit.
    """
    before = list(steps[:number])
    asked = before.pop()
    stance = walk_over(geometry, settings, [*before, asked]).stances[-1]
    soles = (stance.support, stance.before, stance.after)
    support, stood, after = ((sole.at, sole.attitude) for sole in soles)
    place = SwingSoles(support, stood, after, 2.0 * geometry.side(stance.leg))

    def fits(step: Footstep, follow: float = settings.follow) -> bool:
        tried = [*before, step, *steps[number : number + 1]]
        first = 1 if hip is None else number - 1
        manner = replace(settings, follow=follow)
        try:
            walk = walk_over(geometry, manner, tried)
            height = settings.hip
            if height is None:
                needs = hip_needs(geometry, manner, walk)
                own = min(need.hips for need in needs if need.step <= number)
                height = own if hip is None else min(own, hip)
            phases, numbers = walk_phases(geometry, manner, tried, walk, height)
            for phase, its in zip(phases, numbers, strict=True):
                if first <= its <= number:
                    check_phase(geometry, phase)
        except InfeasibleMotion:
            return False
        return True

    name = f"step {number}" if hip is None else f"step {number} by itself"
    said = advise(fits, asked, settings.lift, place, name, error)
    if not said and isinstance(error, BeyondLeg):
        # The waist may go to meet the foot: then the other leg need not fold so far.
        wider = (mm for mm in _FOLLOWS if 1e-3 * mm > settings.follow)
        found = next((mm for mm in wider if fits(asked, 1e-3 * mm)), None)
        said = "" if found is None else f" With follow at {found} mm {name} would fit."
    elif isinstance(error, TwoHeights):
        # On the same ground there is no tread any more: perhaps longer ones would do.
        said += _what_walk_fits(geometry, settings, steps, number)
    if said or not isinstance(error, BeyondLeg | MeetsGround):
        return said
    nothing = " No part of the step, no other lift and no waist that follows farther would do."
    return _what_walk_fits(geometry, settings, steps, number) or nothing


def _what_walk_fits(
    geometry: LegGeometry,
    settings: SteppingSettings,
    steps: Sequence[Footstep],
    number: int,
) -> str:
    """Say how a whole walk would fit; empty if it would in no way that is tried."""

    def fits(tried: Sequence[Footstep], follow: float) -> bool:
        manner = replace(settings, follow=follow)
        try:
            walk = walk_over(geometry, manner, tried)
            needs = hip_needs(geometry, manner, walk)
            hip = min(need.hips for need in needs) if settings.hip is None else settings.hip
            phases, numbers = walk_phases(geometry, manner, tried, walk, hip)
            # The step that was refused comes first: most of what is tried fails there.
            for _, phase in sorted(zip(numbers, phases, strict=True), key=lambda p: p[0] != number):
                check_phase(geometry, phase)
        except InfeasibleMotion:
            return False
        return True

    return advise_walk(fits, steps, settings.follow)
