"""What every control law does: a pure function of states, references and a bounded memory."""

import tracemalloc
from typing import ClassVar

import pytest

from controllers.base import Law
from rig.assembly import make_controller
from rig.hal.offers import lacking
from rig.testing.of_experiment import OfExperiment
from rig.testing.rehearsal import AnyLaw, Rehearsal, numbers_of
from rig.tuning.gains import values_of, with_gains

_ROUNDS = 3
_MEMORY = 20_000
"""Bytes by which Python's own bookkeeping may grow while a law answers."""


class LawSuite(OfExperiment):
    """The law of an experiment, made anew and given what it was given in simulation.

    Attributes
    ----------
    bump : float
        The greatest step of the command as the law takes over, as a share of the greatest command.
    """

    bump: ClassVar[float] = 0.02

    def made(self, rehearsal: Rehearsal) -> AnyLaw:
        """Return another one of the experiment's law, planned for its motion."""
        from rig.assembly import plan_motion

        plan = rehearsal.plan
        law: AnyLaw = make_controller(plan.profile, plan.experiment.controller)
        plan_motion(plan.profile, plan.experiment.reference.settings, law)
        return law

    def answers(self, law: AnyLaw, rehearsal: Rehearsal) -> list[list[float]]:
        """Return the numbers of every command that a law gives on the rehearsal's way."""
        law.reset(rehearsal.started)
        return [numbers_of(law.update(a.state, a.reference)) for a in rehearsal.asked]

    def test_it_offers_what_its_mechanism_asks_for(self, rehearsal: Rehearsal) -> None:
        assert lacking(self.made(rehearsal), type(rehearsal.mechanism).law) == ()

    def test_the_same_inputs_give_the_same_commands(self, rehearsal: Rehearsal) -> None:
        told = [numbers_of(asked.command) for asked in rehearsal.asked]
        assert self.answers(self.made(rehearsal), rehearsal) == told

    def test_reset_forgets_everything(self, rehearsal: Rehearsal) -> None:
        law = self.made(rehearsal)
        once = self.answers(law, rehearsal)
        assert self.answers(law, rehearsal) == once

    def test_gains_that_change_online_go_and_come_back(self, rehearsal: Rehearsal) -> None:
        law = self.made(rehearsal)
        if not isinstance(law, Law) or not law.online:
            pytest.skip("none of its gains changes while it runs")
        once, settings = self.answers(law, rehearsal), law.settings
        for gain in law.online:
            assert gain.low <= values_of((gain,), settings)[gain.key] <= gain.high
            middle = 0.5 * (gain.low + gain.high)
            law.retune(with_gains(settings, {gain.key: middle}))
            assert values_of((gain,), law.settings)[gain.key] == middle
        law.retune(settings)
        assert self.answers(law, rehearsal) == once

    def test_two_of_them_share_nothing(self, rehearsal: Rehearsal) -> None:
        alone = self.answers(self.made(rehearsal), rehearsal)
        one, other = self.made(rehearsal), self.made(rehearsal)
        one.reset(rehearsal.started)
        other.reset(rehearsal.started)
        told = []
        for asked, backwards in zip(rehearsal.asked, reversed(rehearsal.asked), strict=True):
            told.append(numbers_of(one.update(asked.state, asked.reference)))
            try:
                other.update(backwards.state, backwards.reference)
            except ValueError:  # it may well refuse such nonsense
                other.reset(rehearsal.started)
        assert told == alone

    def test_it_takes_over_without_a_bump(self, rehearsal: Rehearsal) -> None:
        before, first = numbers_of(rehearsal.applied), numbers_of(rehearsal.asked[0].command)
        greatest = max(abs(n) for asked in rehearsal.asked for n in numbers_of(asked.command))
        assert first == pytest.approx(before, abs=self.bump * greatest)

    def test_its_memory_is_bounded(self, rehearsal: Rehearsal) -> None:
        law = self.made(rehearsal)
        law.reset(rehearsal.started)
        grown = []
        tracemalloc.start()
        try:
            for _ in range(_ROUNDS):
                for asked in rehearsal.asked:
                    law.update(asked.state, asked.reference)
                grown.append(tracemalloc.get_traced_memory()[0])
        finally:
            tracemalloc.stop()
        assert grown[-1] - grown[0] < _MEMORY
