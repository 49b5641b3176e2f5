"""A motion that leaves a drive's own bounds is refused before anything moves, and no other."""

import math
import random
from types import SimpleNamespace

import pytest
from servo_fakes import LOWER, NAMES, PERIOD, RATES, UPPER, Command

from rig.experiment.plan import load_plan
from rig.hal import MotionRefused
from rig.hal.driver import AxisBounds
from rig.mechanisms.servo.axes import AxisLimits
from rig.mechanisms.servo.planned import PlannedAxes


class Axes(PlannedAxes):
    """Three axes that need nothing but their limits."""

    @classmethod
    def axis_limits(cls, settings):
        return AxisLimits(NAMES, LOWER, UPPER, RATES)


def swing(chance):
    """Return a motion within the axes' limits, its amplitude and its angular frequency."""
    sizes = [chance.uniform(0.1, 0.45) for _ in NAMES]
    turns = [chance.uniform(0.2, 0.9) * rate / s for rate, s in zip(RATES, sizes, strict=True)]

    def at(t):
        angles = tuple(s * math.sin(w * t) for s, w in zip(sizes, turns, strict=True))
        return Command(angles, (0.0,) * 3)

    return SimpleNamespace(duration=2.0 * math.tau / min(turns), at=at), sizes, turns


def beyond(motion, drives):
    return Axes.beyond_drives(None, motion, drives, PERIOD)


@pytest.mark.parametrize("seed", range(10))
def test_the_first_axis_that_leaves_its_drives_bounds_is_named(seed):
    chance = random.Random(seed)
    motion, sizes, turns = swing(chance)
    k = chance.randrange(3)
    size, fastest = sizes[k], sizes[k] * turns[k]
    share = chance.uniform(0.3, 0.9)
    wide = {name: AxisBounds(-9.0, 9.0, 9.0) for name in NAMES}
    assert beyond(motion, wide) is None
    assert beyond(motion, {}) is None
    exact = AxisBounds(-1.01 * size, 1.01 * size, 1.01 * fastest)
    assert beyond(motion, wide | {NAMES[k]: exact}) is None
    narrow = AxisBounds(-share * size, 9.0, 9.0)
    said = beyond(motion, wide | {NAMES[k]: narrow})
    assert said.startswith(f"the motion takes {NAMES[k]} to -")
    assert f"permits {narrow.low:.4g} … 9 rad" in said
    slow = AxisBounds(-9.0, 9.0, share * fastest)
    said = beyond(motion, wide | {NAMES[k]: slow})
    assert said.startswith(f"the motion turns {NAMES[k]} at ")
    assert f"permits {slow.speed:.4g} rad/s" in said


@pytest.mark.parametrize(
    ("experiment", "option", "words"),
    [
        ("legs-walk", "devices.servos.joints.left_knee.max_speed=0.2", "left_knee.*0.2 rad/s"),
        ("arm-shoulder-circle", "devices.drives.joints.q3.max_speed=0.01", "q3.*0.01 rad/s"),
    ],
)
def test_an_experiment_is_refused_by_its_check(experiment, option, words):
    with pytest.raises(MotionRefused, match=words):
        load_plan(experiment, [option])
