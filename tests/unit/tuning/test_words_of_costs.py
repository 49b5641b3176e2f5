"""What `rig explain` says of costs and bounds is what the code does."""

import math

import pytest

from rig.cli.loops import loop_table
from rig.explaining.report_words import report_words
from rig.hal.bench import Trial
from rig.hal.closed_loop import MOST_SENSITIVE, SENSITIVITY, ClosedLoop
from rig.tuning.score import LOST, REFUSED, UNSTABLE, score

NEAR, FAR = ClosedLoop(True, 20.0, 0.8, 0.02, 1.5), ClosedLoop(True, 20.0, 0.8, 0.02, math.inf)


def trial(strayed=0.1, lasted=1.0):
    return Trial({"sine": 1e-3}, 0.0, 5.0, strayed, lasted)


def test_a_plant_that_would_be_stopped_costs_less_than_one_that_ran_away():
    assert score([trial(), trial(2.0)], [NEAR]).cost < 10.0
    assert score([trial(), trial(2.0, 0.5)], [NEAR]).cost == LOST == 1000.0
    assert (REFUSED, UNSTABLE) == (1500.0, 2000.0)
    told = report_words()["cost"]
    assert all(
        words in told for words in ("1000: a plant ran away", "1500 or more", "2000 or more")
    )


def test_a_loop_that_was_not_told_costs_what_is_said():
    more = score([trial()], [FAR]).cost - score([trial()], [NEAR]).cost
    assert more == pytest.approx(36.0, abs=0.5)
    assert "one that was not told, adds 36" in " ".join(report_words()["cost"].split())


def test_both_bounds_of_a_sensitivity_are_said():
    told = " ".join(report_words()["sensitivity"].split())
    assert f"at most {SENSITIVITY:g} on 99 of 100" in told
    assert f"refused above {MOST_SENSITIVE:g}" in told
    (row,) = [row for row in loop_table("pid", NEAR._asdict()).rows if "sensitivity" in row[0]]
    assert row[1] == "1.5 (at most 1.7 is wanted, 2 on hardware)"
