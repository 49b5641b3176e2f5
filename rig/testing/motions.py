"""What every motion does: from rest to rest, with stretches inside it and numbers for facts."""

import math
from itertools import pairwise
from typing import ClassVar

from rig.testing.of_experiment import OfExperiment
from rig.testing.rehearsal import Rehearsal, numbers_of, place_of

_STEPS = 400


class MotionSuite(OfExperiment):
    """The motion of an experiment; the first member of its references is where to be.

    Attributes
    ----------
    rest : float
        The share of the greatest step between two instants that the first and the last may have.
    """

    rest: ClassVar[float] = 0.2

    def test_it_lasts(self, rehearsal: Rehearsal) -> None:
        assert 0.0 < rehearsal.plan.motion.duration < math.inf

    def test_it_is_made_of_numbers(self, rehearsal: Rehearsal) -> None:
        motion = rehearsal.plan.motion
        for k in range(_STEPS + 1):
            numbers = numbers_of(motion.at(motion.duration * k / _STEPS))
            assert numbers
            assert all(math.isfinite(number) for number in numbers)

    def test_it_goes_from_rest_to_rest(self, rehearsal: Rehearsal) -> None:
        motion = rehearsal.plan.motion
        rows = [place_of(motion.at(motion.duration * k / _STEPS)) for k in range(_STEPS + 1)]
        greatest = [max(map(abs, row)) for row in zip(*_steps(rows), strict=True)]
        step = motion.duration / _STEPS
        for t in (0.0, motion.duration - step):
            (change,) = _steps([place_of(motion.at(t)), place_of(motion.at(t + step))])
            for moved, most in zip(change, greatest, strict=True):
                assert abs(moved) <= self.rest * most + 1e-9

    def test_its_stretches_are_inside_it_and_have_names_of_their_own(
        self, rehearsal: Rehearsal
    ) -> None:
        motion = rehearsal.plan.motion
        names = [segment.name for segment in motion.segments]
        assert len(set(names)) == len(names)
        for segment in motion.segments:
            assert segment.name
            assert 0.0 <= segment.start < segment.end <= motion.duration + 1e-9

    def test_its_facts_are_numbers_with_a_description(self, rehearsal: Rehearsal) -> None:
        for fact in rehearsal.plan.motion.facts.values():
            assert not math.isnan(fact.value)  # infinite is what never happens
            assert fact.description


def _steps(rows: list[list[float]]) -> list[list[float]]:
    return [[b - a for a, b in zip(before, after, strict=True)] for before, after in pairwise(rows)]
