"""Motions that are passed more slowly, by number and in words."""

import re

import numpy as np
import pytest
from drawn_cases import WIDE, hand_of

from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.pose_path import PosePath
from controllers.arm.slower import slower_path
from controllers.arm.turn_path import TurnPath
from controllers.motion import InfeasibleMotion
from controllers.rounding import floor

ARM = ArmGeometry(**WIDE)
PLACES = ((0.3, 0.0, 0.4), (0.3, 0.1, 0.4))
PATHS = (
    Circle(rate=0.7),
    TurnPath(start=TurnBack().start, axis=(0.0, 0.0, 1.0), rate=0.3),
    DwellLine(speed=0.06, dwell=4.0),
    TurnBack(speed=0.07, turn_rate=-0.05),
    Line(middle=TurnBack().start, speed=0.1, turn_rate=0.0),
    PosePath(points=PLACES, speed=0.1),
)


@pytest.mark.parametrize("value", np.random.default_rng(5).uniform(-8, 4, 20))
def test_a_number_of_four_digits_is_no_greater_and_near(value):
    number = 10.0**value
    assert 0.998 * number < floor(number) <= number
    assert floor(number) == float(f"{floor(number):.4g}")


@pytest.mark.parametrize("path", PATHS, ids=lambda path: type(path).__name__)
@pytest.mark.parametrize("factor", [1.0, 1.37, 20.0])
def test_a_slower_path_is_what_its_words_say(path, factor):
    slower, words = slower_path(path, factor)
    numbers = [float(number) for number in re.findall(r"-?\d[\d.e+-]*", words)]
    changed = [
        getattr(slower, name)
        for name in ("speed", "turn_rate", "rate", "dwell")
        if getattr(slower, name, None) != getattr(path, name, None)
    ]
    if factor > 1.0:
        assert sorted(numbers) == sorted(changed)
    for name in ("speed", "turn_rate", "rate"):
        if getattr(path, name, 0.0):
            share = getattr(slower, name) / getattr(path, name)
            assert 0.998 / factor < share <= 1.0 / factor
    if isinstance(path, DwellLine):  # as far in the region, at less speed
        assert slower.dwell * slower.speed == pytest.approx(path.dwell * path.speed, rel=1e-5)


def test_what_has_no_speed_cannot_be_slower():
    assert slower_path(object(), 2.0) is None


def test_a_turn_back_ends_where_it_began():
    law = LookAhead(LookAheadSettings(), ARM, 5e-3)
    for path in (TurnBack(), TurnBack(turn_rate=0.0, speed=0.05)):
        plan = law.prepare(path)
        begins, ends = (hand_of(ARM, plan.positions[k].tolist())[0] for k in (0, -1))
        assert np.linalg.norm(ends - begins) < 1e-9


def test_a_turn_back_may_start_near_the_boundary():
    """Where the law that turns back at full speed would start inside its region."""
    path = TurnBack(start=(0.0, 1.0, 0.6, 0.5, -0.8, 0.0), speed=0.1, turn_rate=0.0)
    with pytest.raises(InfeasibleMotion, match=r"no faster than 0\.0\d+ m/s"):
        law = LookAhead(LookAheadSettings(), ARM, 5e-3)
        law._fine(law_trajectory(law, path), 2e-3)
    assert LookAhead(LookAheadSettings(), ARM, 5e-3).prepare(path).outcome == "done"


def law_trajectory(law, path):
    from controllers.arm.trajectories import make_trajectory

    return make_trajectory(law.arm, path)


def test_a_hand_keeps_its_speed_past_a_near_miss():
    path = Line(
        middle=(0.04, -0.23, 1.13, -1.9, 1e-8, -0.47),
        shoulder_distance=1e-5,
        direction=(0.41, 0.15, -0.11),
        before=0.05,
        after=0.2,
        speed=0.0147,
    )
    plan = LookAhead(LookAheadSettings(), ARM, 5e-3).prepare(path)
    hands = np.array([hand_of(ARM, row)[0] for row in plan.positions.tolist()])
    speeds = np.linalg.norm(np.diff(hands, axis=0), axis=1) / plan.period
    assert speeds.max() <= 1.001 * path.speed
