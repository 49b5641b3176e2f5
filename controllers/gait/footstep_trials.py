"""Whether a walk, or one step of it, can be done: yes or no where `plan_footsteps` raises."""

from collections.abc import Sequence
from typing import NamedTuple

from controllers.gait.footprints import Footstep, SteppingSettings
from controllers.gait.footstep_checks import check_phase
from controllers.gait.footstep_phases import hip_needs, walk_over, walk_phases
from controllers.gait.geometry import LegGeometry
from controllers.gait.phases import GaitPhase
from controllers.motion import InfeasibleMotion

_COARSE = 8
"""Points of a phase by which most of what does not fit is known not to."""
_SURE = 5e-5
"""By how much more a margin has to be kept by what is advised, m: a plan looks at more instants."""


class Trials(NamedTuple):
    """Footprints as they are asked for, beside which others are tried.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    steps : sequence of Footstep
        As they are asked for.
    min_margin : float
        Least distance of the centre of mass from the edge of what the feet stand on, m.
    number : int
        Of the step that others are tried for, from 1 on.
    """

    geometry: LegGeometry
    steps: Sequence[Footstep]
    min_margin: float
    number: int = 1

    def walk_fits(self, steps: Sequence[Footstep], manner: SteppingSettings) -> bool:
        """Return whether all of these steps can be done."""
        try:
            walk = walk_over(self.geometry, manner, steps)
            hip = manner.hip
            needs = hip_needs(self.geometry, manner, walk)
            if hip is None:
                hip = min(need.hips for need in needs)
            phases, numbers = walk_phases(self.geometry, manner, steps, walk, hip)
            order = sorted(range(len(phases)), key=lambda k: abs(numbers[k] - self.number))
            for place in order:  # most of what is tried fails where the walk was refused
                self._check(phases[place], _COARSE)
            for place in order:
                self._check(phases[place])
        except InfeasibleMotion:
            return False
        return True

    def step_fits(self, step: Footstep, manner: SteppingSettings, hip: float | None) -> bool:
        """Return whether a step can be done in the place of the one that is refused.

        With hips of a given height all before it is known to, and they are no higher than that.
        Without, they are as high as the steps up to it let them be, until the other foot has left
        the ground, and all of these have to fit.
        """
        number = self.number
        tried = [*self.steps[: number - 1], step, *self.steps[number : number + 1]]
        first = 1 if hip is None else number - 1
        try:
            walk = walk_over(self.geometry, manner, tried)
            height = manner.hip
            if height is None:
                needs = hip_needs(self.geometry, manner, walk)
                own = min(need.hips for need in needs if need.step <= number)
                height = own if hip is None else min(own, hip)
            phases, numbers = walk_phases(self.geometry, manner, tried, walk, height)
            checked = [
                phase for phase, its in zip(phases, numbers, strict=True) if first <= its <= number
            ]
            for phase in reversed(checked):
                self._check(phase, _COARSE)
            for phase in reversed(checked):
                self._check(phase)
        except InfeasibleMotion:
            return False
        return True

    def _check(self, phase: GaitPhase, *points: int) -> None:
        check_phase(self.geometry, phase, self.min_margin + _SURE, *points)
