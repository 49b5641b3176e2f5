"""The reference of an orderly stop: on the motion's path, without a jump, and then at rest."""

import random

import numpy as np
import pytest
from loop_fakes import FakeMechanism

from controllers.cylinder.types import PairReference
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.mechanisms.cylinder.references import Sine, SineTone
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.references.circle import CircleTone, JointCircle
from rig.runtime.braking import Braking

DURATION = 0.25
STEP = 1e-5
DRAWN = random.Random(88)
SINE = Sine(10e-3, (SineTone(1.0, 3),))
CIRCLE = JointCircle(tilt=np.radians(20.0), tones=(CircleTone(0.5, 1),))
PAIR = (AntagonisticPair, SINE, lambda reference: (reference.position,))
JOINT = (SphericalJoint, CIRCLE, lambda reference: reference.axis)


def vector(values):
    return np.atleast_1d(np.asarray(values, dtype=float))


@pytest.mark.parametrize("kind", [PAIR, JOINT], ids=["cylinder", "joint"])
@pytest.mark.parametrize("start", [DRAWN.uniform(0.1, 2.5) for _ in range(6)])
def test_velocity_and_acceleration_are_those_of_the_slowed_path(kind, start):
    mechanism, motion, place = kind
    braking = Braking(mechanism.slow_down, motion.at, start, motion.duration, DURATION)
    assert vector(place(braking.at(0.0))) == pytest.approx(vector(place(motion.at(start))))
    assert vector(braking.at(0.0).velocity) == pytest.approx(vector(motion.at(start).velocity))
    for t in (DRAWN.uniform(0.02, 0.23) for _ in range(5)):
        before, now, after = (braking.at(t + k * STEP) for k in (-1, 0, 1))
        a, c = vector(place(before)), vector(place(after))
        assert vector(now.velocity) == pytest.approx((c - a) / (2.0 * STEP), abs=1e-6)
        slope = (vector(after.velocity) - vector(before.velocity)) / (2.0 * STEP)
        assert vector(now.acceleration) == pytest.approx(slope, abs=1e-3)
    rest = braking.at(DURATION)
    assert vector(rest.velocity) == pytest.approx(0.0, abs=1e-12)
    assert vector(rest.acceleration) == pytest.approx(0.0, abs=1e-12)
    assert braking.at(10.0) == rest
    assert vector(place(rest)) == pytest.approx(vector(place(motion.at(start + DURATION / 2.0))))


def test_path_ends_where_the_motion_ends():
    braking = Braking(
        AntagonisticPair.slow_down, SINE.at, SINE.duration - 0.02, SINE.duration, DURATION
    )
    assert braking.at(1.0) == PairReference(10e-3, 0.0, 0.0)


def test_without_a_duration_the_reference_stays_where_it_is():
    braking = Braking(AntagonisticPair.slow_down, SINE.at, 0.3, SINE.duration, 0.0)
    assert braking.at(0.0) == PairReference(SINE.at(0.3).position, 0.0, 0.0)


def test_mechanism_that_says_nothing_is_braked_on_its_path_at_rest():
    braking = Braking(FakeMechanism.slow_down, lambda t: 100.0 * t, 1.0, 9.0, DURATION)
    assert braking.at(0.0) == 100.0
    assert braking.at(DURATION) == pytest.approx(100.0 + 100.0 * DURATION / 2.0)
