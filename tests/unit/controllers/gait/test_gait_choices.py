"""What a walk may choose: the first foot, where the waist is, the hips' height, longer steps."""

import math

import numpy as np
import pytest
from test_gait_drawn import faults_of, model, soles

from controllers.gait.geometry import LegGeometry
from controllers.gait.laws import TrapezoidNormLaw, TrapezoidNormSettings
from controllers.gait.motions import WalkSettings
from controllers.gait.types import BalanceSettings, GaitModel
from controllers.motion import InfeasibleMotion


def plan(walk, gait=None):
    law = TrapezoidNormLaw(TrapezoidNormSettings(), gait or model(), 1e-2)
    made = law.prepare(walk)
    if gait is None:
        assert faults_of(walk, law, made) == []
    return made


def test_left_first_is_the_mirror_image_of_right_first():
    right, left = plan(WalkSettings(speed=4.0)), plan(WalkSettings(speed=4.0, first="left"))
    names = [planned.phase.name for planned in left.phases]
    assert names[1] == "swing left 1"
    mirrored = right.q.reshape(-1, 2, 6)[:, ::-1] * (-1, -1, 1, 1, 1, -1)
    np.testing.assert_allclose(left.q, mirrored.reshape(-1, 12), atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_waist_is_ahead_of_the_ankles_and_as_high_as_it_was_asked_to_be(seed):
    rng = np.random.default_rng((71, seed))
    ahead, hip = float(rng.uniform(-0.02, 0.03)), float(rng.uniform(0.17, 0.185))
    made = plan(WalkSettings(speed=2.0, landings=2, ahead=ahead, hip=hip))
    feet, _ = soles(made.geometry, made.q, made.waist)
    last = made.phases[-1].phase
    stands = 0 if last.waist_at(1.0)[1] < 0.0 else 1
    assert made.waist[-1, 0] - feet[-1, stands, 0] == pytest.approx(ahead, abs=1e-9)
    height = made.waist[:, 2] - LegGeometry().ankle_height
    np.testing.assert_allclose(height, hip, atol=1e-9)


def test_a_waist_ahead_leaves_the_knees_what_was_asked_of_them():
    made = plan(WalkSettings(speed=2.0, landings=1, ahead=0.01, knee_min=math.radians(3.0)))
    assert made.q[:, [3, 9]].min() == pytest.approx(math.radians(3.0), abs=1e-6)


def test_hips_out_of_reach_are_refused():
    with pytest.raises(InfeasibleMotion, match="reach"):
        plan(WalkSettings(hip=0.3))


def test_longer_legs_make_longer_steps():
    geometry = LegGeometry(thigh=0.4, shank=0.4)
    gait = GaitModel(geometry, BalanceSettings(min_margin=1e-6, response_time=1.0))
    made = plan(WalkSettings(step=0.3, lift=0.05, landings=2), gait)
    assert made.advance == pytest.approx(0.6, abs=1e-6)
    with pytest.raises(InfeasibleMotion, match="out of the reach"):
        plan(WalkSettings(step=0.3))
