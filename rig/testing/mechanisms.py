"""What every mechanism does with its states, commands and log."""

import math

import pytest

from rig.hal import Mechanism
from rig.hal.columns import group_order, schema_text
from rig.hal.offers import lacking
from rig.testing.of_experiment import OfExperiment
from rig.testing.rehearsal import Rehearsal, numbers_of, place_of

_ALIKE = 1e-9


class MechanismSuite(OfExperiment):
    """The mechanism of an experiment's rig, after a stretch of it in simulation."""

    def test_it_offers_all_that_the_loop_asks_for(self, rehearsal: Rehearsal) -> None:
        assert lacking(rehearsal.mechanism, Mechanism) == ()

    def test_its_columns_make_a_message(self, rehearsal: Rehearsal) -> None:
        columns = list(rehearsal.columns)
        schema_text([columns[k] for k in group_order(columns)])

    def test_a_row_has_a_value_for_each_column(self, rehearsal: Rehearsal) -> None:
        assert rehearsal.rows
        for row in rehearsal.rows:
            assert len(row) == len(rehearsal.columns)
            assert not any(math.isnan(value) for value in row)

    def test_a_blend_begins_and_ends_with_its_ends(self, rehearsal: Rehearsal) -> None:
        mechanism = rehearsal.mechanism
        start, end = rehearsal.asked[0].command, rehearsal.asked[-1].command
        for share, wanted in ((0.0, start), (1.0, end)):
            # What is blended is where to go; how fast is the way's own matter.
            assert _first(mechanism.blend(start, end, share)) == pytest.approx(_first(wanted))

    def test_what_was_limited_is_not_limited_again(self, rehearsal: Rehearsal) -> None:
        mechanism = rehearsal.mechanism
        for asked in (rehearsal.asked[0], rehearsal.asked[-1]):
            mechanism.start_limiting(asked.state)
            once = mechanism.limit(asked.command)
            before = dict(mechanism.limit_hits())
            again = mechanism.limit(once)
            assert _first(again) == pytest.approx(_first(once), abs=_ALIKE)
            assert mechanism.limit_hits() == before

    def test_an_approach_goes_from_one_end_to_the_other(self, rehearsal: Rehearsal) -> None:
        mechanism, motion = rehearsal.mechanism, rehearsal.plan.motion
        start, end = mechanism.reference_of(rehearsal.started), motion.at(0.0)
        for t, wanted in ((0.0, start), (2.0, end)):
            reached = mechanism.approach(start, end, 2.0, t)
            assert place_of(reached) == pytest.approx(place_of(wanted), abs=1e-6)

    def test_the_worst_margin_is_at_most_one(self, rehearsal: Rehearsal) -> None:
        mechanism, asked = rehearsal.mechanism, rehearsal.asked[-1]
        applied = mechanism.limit(asked.command)
        margin = mechanism.worst_margin(asked.state, applied, 0.0)
        assert margin.name
        assert margin.fraction <= 1.0 + _ALIKE

    def test_hits_are_counted_by_the_limits_names(self, rehearsal: Rehearsal) -> None:
        for name, hits in rehearsal.mechanism.limit_hits().items():
            assert name
            assert hits >= 0


def _first(value: object) -> list[float]:
    """Return what a command sends: all of it, or its first member where that is many numbers."""
    numbers = numbers_of(value)
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return numbers_of(value[0])
    return numbers
