"""A motion that takes too long is refused before it is planned, whatever the rig."""

import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.paths import DwellLine, Line
from controllers.motion import LongMotion
from rig.experiment.plan import load_plan
from rig.hal import MotionRefused

CONFIGS = Path(__file__).parents[3] / "configs"
RNG = np.random.default_rng(20)
LONG = 10 ** RNG.uniform(4.6, 4.9, 9)
"""Seconds, drawn, below the day that a setting may be; each asks for so long a motion."""

ASKED = [
    ("cylinder-sine", "reference.tones=[{{frequency: {0!r} Hz}}]", -1),
    ("cylinder-staircase", "reference.rise={0!r} s", 1),
    ("cylinder-step", "reference.dwell={0!r} s", 1),
    ("joint-circle", "reference.tones=[{{frequency: {0!r} Hz}}]", -1),
    ("joint-poses", "reference.rise={0!r} s", 1),
    ("arm-wrist-hit", "reference.speed={0!r} m/s", -1),
    ("arm-elbow-dwell", "reference.dwell={0!r} s", 1),
    ("arm-elbow-circle", "reference.rate={0!r} rad/s", -1),
    ("legs-squat", "reference.time={0!r} s", 1),
]


@pytest.mark.parametrize(
    ("asked", "long"),
    list(zip(ASKED, LONG.tolist(), strict=True)),
    ids=[name for name, *_ in ASKED],
)
def test_it_is_refused_with_its_length_the_bound_and_the_setting(asked, long):
    experiment, option, power = asked
    # The first plan of a rig imports what it is made of.
    load_plan(experiment, configs=CONFIGS)
    tracemalloc.start()
    try:
        with pytest.raises(MotionRefused, match=r"at least \S+ s, .* 1800 s \(loop.longest_motion"):
            load_plan(experiment, [option.format(long**power)], configs=CONFIGS)
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


def test_the_bound_is_the_profiles():
    bound = float(RNG.uniform(30.0, 100.0))
    longer = [f"reference.rise={bound!r} s", f"loop.longest_motion={bound!r} s"]
    with pytest.raises(MotionRefused, match=rf" {bound:g} s \(loop.longest_motion"):
        load_plan("cylinder-staircase", longer, configs=CONFIGS)
    raised = [longer[0], f"loop.longest_motion={100.0 * bound!r} s"]
    assert load_plan("cylinder-staircase", raised, configs=CONFIGS).motion.duration > bound


@pytest.mark.parametrize("path", [DwellLine(), Line((0.0, 0.3, 1.5, 0.0, 0.0, 0.0))])
def test_a_law_that_comes_to_take_longer_than_its_path_stops_in_time(path):
    law = Esc(EscSettings(), ArmGeometry(), 1e-2)
    whole = law.prepare(path).duration
    law.longest = 0.99 * whole
    with pytest.raises(LongMotion, match=r"the longest that is permitted"):
        law.prepare(path)
    law.longest = 1.01 * whole
    assert math.isclose(law.prepare(path).duration, whole)
