"""Legs that walk begin with both soles on the floor, by the encoders."""

import re
from dataclasses import replace

import numpy as np
import pytest
from motion_fakes import LegsBench
from scipy.spatial.transform import Rotation

from controllers.gait.geometry import AXIS_NAMES
from controllers.gait.types import LegsReference
from rig.hal import SafetyError

BOUND = 0.07
PITCH = (2, 3, 4)


def stance(rng, slope=0.0):
    """Return joints with flat soles, however the two legs are bent: on a slope all pitch alike."""
    q = np.zeros(12)
    for leg in (0, 6):
        hip, knee = rng.uniform(-0.8, 0.0), rng.uniform(0.0, 1.5)
        q[leg] = rng.uniform(-0.3, 0.3)
        roll = rng.uniform(-0.2, 0.2)
        q[[leg + 1, leg + 5]] = roll, -roll
        q[[leg + 2, leg + 3, leg + 4]] = hip, knee, slope - hip - knee
        if slope:
            q[[leg, leg + 1, leg + 5]] = 0.0
    return q


def begin(q, **settings):
    bench = LegsBench()
    bench.legs.settings = replace(bench.legs.settings, **settings)
    bench.legs.attach(None, bench.motion)
    bench.legs.check_still(LegsReference(tuple(q), (0.0,) * 12, False))
    return bench


def sole(q, leg):
    """Return which way a sole points, seen from the waist; by a library of rotations."""
    yaw, roll, pitch, knee, ankle, ankle_roll = q[6 * leg : 6 * leg + 6]
    turns = Rotation.from_euler("ZXY", (yaw, roll, pitch + knee + ankle))
    return (turns * Rotation.from_euler("X", ankle_roll)).apply((0.0, 0.0, 1.0))


@pytest.mark.parametrize("seed", range(8))
def test_flat_soles_are_a_stance_however_the_legs_are_bent(seed):
    rng = np.random.default_rng(seed)
    begin(stance(rng))
    begin(stance(rng, slope=0.3))


@pytest.mark.parametrize("joint", range(12))
@pytest.mark.parametrize("seed", range(3))
def test_an_encoder_that_is_off_is_seen_while_its_joint_rests(joint, seed):
    rng = np.random.default_rng((joint, seed))
    q = LegsBench().motion.at(0.0).positions + rng.normal(scale=2e-3, size=12)
    q[joint] += rng.choice((-1.0, 1.0)) * rng.uniform(0.08, 0.3)
    if joint in (0, 6):  # where a foot points is free
        begin(q)
        return
    tilt = np.degrees(np.arccos(sole(q, 0) @ sole(q, 1)))
    with pytest.raises(SafetyError, match=f"{AXIS_NAMES[joint]} would explain") as fault:
        begin(q)
    assert f"soles are {tilt:.3g} deg apart, at most 4.01 deg" in str(fault.value)
    begin(q, start_tilt=None)


@pytest.mark.parametrize("joint", sorted(set(range(12)) - {0, 6}))
@pytest.mark.parametrize("seed", range(4))
def test_the_encoder_that_is_off_is_named_however_far_both_knees_are_bent(joint, seed):
    """Knees far from where the walk begins are no reason to blame one of them."""
    rng = np.random.default_rng((23, joint, seed))
    knee = rng.uniform(0.3, 1.2)
    hip = -knee * rng.uniform(0.3, 0.7)
    q = np.tile((0.0, 0.0, hip, knee, -hip - knee, 0.0), 2) + rng.normal(scale=2e-3, size=12)
    off = rng.choice((-1.0, 1.0)) * rng.uniform(0.1, 0.5)
    q[joint] += off
    with pytest.raises(SafetyError, match=f"{AXIS_NAMES[joint]} would explain it") as fault:
        begin(q)
    said = float(re.search(r"off by (\S+) deg", str(fault.value))[1])
    assert said == pytest.approx(np.degrees(off), abs=1.5)


def test_the_bound_is_the_profiles():
    q = np.array(LegsBench().motion.at(0.0).positions)
    for off in (BOUND - 1e-6, BOUND - 1e-3):
        q[5] = off
        begin(q)
    q[5] = BOUND + 1e-6
    with pytest.raises(SafetyError):
        begin(q)


def test_legs_that_do_not_walk_may_have_their_soles_anywhere():
    """A calibration or an acceptance test has them hang, or in a jig."""
    bench = LegsBench()
    bench.legs.check_still(LegsReference((0.5, *[0.0] * 4, 0.5, *[0.0] * 6), (0.0,) * 12, False))
