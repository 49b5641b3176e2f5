"""The oracle against a search by hand, on drawn truths and bounds."""

import math
import random

import numpy as np
import pytest

from rig.faults.oracle import Violation, judge
from rig.faults.performance import _is_confessed
from rig.hal.hazards import ENERGY_LEFT, Hazard

COLUMNS = ("a", "b", "c")


def truth_of(chance: random.Random, count: int = 200):
    times = np.cumsum([chance.uniform(0.5e-3, 1.5e-3) for _ in range(count)])
    rows = np.array([[chance.gauss(0.0, 1.0) for _ in COLUMNS] for _ in range(count)])
    return times, rows


@pytest.mark.parametrize("seed", range(40))
def test_a_bound_is_broken_where_a_search_by_hand_says(seed):
    chance = random.Random(seed)
    times, rows = truth_of(chance)
    low, high = -chance.uniform(1.0, 3.5), chance.uniform(1.0, 3.5)
    safe_from = chance.uniform(0.0, float(times[-1]))
    only_safe = bool(seed % 2)
    hazard = Hazard("x", "m", COLUMNS, low, high, only_safe=only_safe)
    found = judge([hazard], COLUMNS, times, rows, safe_from=safe_from)
    beyond = [
        (max(value - high, low - value), column, t)
        for t, row in zip(times, rows, strict=True)
        for column, value in zip(COLUMNS, row, strict=True)
        if not low <= value <= high and (t >= safe_from or not only_safe)
    ]
    assert bool(found) == bool(beyond)
    if beyond:
        excess, column, _ = max(beyond)
        (violation,) = found
        assert violation.column == column
        assert abs(violation.worst - violation.bound) == pytest.approx(excess)
        assert violation.t == min(t for _, name, t in beyond if name == column)


def test_a_rate_is_that_of_the_column():
    times = np.arange(0.0, 1.0, 1e-3)
    rows = np.stack([3.0 * times, 5.0 * times, np.sin(times)], axis=1)
    hazard = Hazard("rate", "rad/s", COLUMNS, -4.0, 4.0, is_rate=True)
    (violation,) = judge([hazard], COLUMNS, times, rows, safe_from=0.0)
    assert (violation.column, violation.worst) == ("b", pytest.approx(5.0))


def test_what_is_bounded_may_be_made_of_a_column():
    rows = np.array([[math.cos(tilt), 0.0, 0.0] for tilt in (0.1, 0.9, 0.2)])
    hazard = Hazard("tilt", "rad", ("a",), -math.inf, 0.8, of=math.acos)
    (violation,) = judge([hazard], COLUMNS, np.array([0.0, 1.0, 2.0]), rows, safe_from=0.0)
    assert violation.worst == pytest.approx(0.9)
    assert violation.t == 1.0


def test_a_forgiven_hazard_is_not_judged_and_another_is():
    rows = np.full((3, 3), 9.0)
    hazards = [Hazard("speed", "m/s", ("a",), -1, 1), Hazard("pressure", "Pa", ("b",), 0, 1)]
    found = judge(hazards, COLUMNS, np.arange(3.0), rows, safe_from=0.0, forgiven={"speed"})
    assert [violation.hazard for violation in found] == ["pressure"]


def test_a_value_that_is_no_number_is_beyond_every_bound():
    rows = np.array([[0.0, 0.0, 0.0], [math.nan, 0.0, 0.0]])
    found = judge([Hazard("x", "m", ("a",), -1, 1)], COLUMNS, np.arange(2.0), rows, safe_from=0.0)
    assert found


@pytest.mark.parametrize("seed", range(20))
def test_what_comes_after_a_forgiven_end_is_not_judged(seed):
    chance = random.Random(seed)
    times, rows = truth_of(chance)
    fall = chance.randrange(1, len(times))
    rows[:, 0] = np.arange(len(times)) >= fall
    hazards = [
        Hazard("fall", "1", ("a",), -math.inf, 0.5, is_last=True),
        Hazard("rate", "m", ("b",), -1.5, 1.5),
    ]
    before = np.any(np.abs(rows[:fall, 1]) > 1.5)
    forgiven = judge(hazards, COLUMNS, times, rows, safe_from=0.0, forgiven={"fall"})
    assert [violation.hazard for violation in forgiven] == ["rate"] * int(before)
    whole = judge(hazards, COLUMNS, times, rows, safe_from=0.0)
    after = np.any(np.abs(rows[:, 1]) > 1.5)
    assert [violation.hazard for violation in whole] == ["fall", *["rate"] * int(after)]


@pytest.mark.parametrize(
    ("told", "confessed"),
    [
        ("regulators: agonist still holds 46.7 kPa", True),
        ("regulators: antagonist still holds 46.7 kPa", False),  # which is another chamber
        ("not known to be safe, its last reading is 1 s old: then agonist held 46.7 kPa", True),
        ("not known to be safe, its last reading is 1 s old", False),
        ("made safe", False),
    ],
)
def test_a_chamber_that_was_told_of_is_no_false_promise(told, confessed):
    left = Violation(ENERGY_LEFT, "pressure_agonist", 1.0, 46.7e3, 20e3, "Pa")
    assert _is_confessed(left, told) is confessed
    assert not _is_confessed(left._replace(hazard="speed"), told)
