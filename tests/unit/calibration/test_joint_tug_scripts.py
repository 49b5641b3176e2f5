"""How tugs and strokes of a joint are done, and which controllers take the ring there."""

import math
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from pneumatic_rigs import pneumatics_of

from controllers.spherical_joint.types import JointCommand, JointReference, JointState
from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.config import find_configs, load_profile
from rig.mechanisms.joint.calibration.leaning import Strokes
from rig.mechanisms.joint.calibration.tugs import StrokesAndTugs, TugScript

PERIOD = 1e-3
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def profile():
    return load_profile("joint-ideal", REGISTRY, (), find_configs())


class Seen(NamedTuple):
    encoder_marker: tuple[float, float, float] = (0.0, 0.0, 0.05)


class Follower:
    """Notes what it is asked for."""

    estimate = Seen()

    def __init__(self):
        self.asked = []

    def reset(self, state):
        pass

    def update(self, state, reference):
        self.asked.append(reference)
        return JointCommand(0.0, 0.0, 0.0, 0.0)


class Upright:
    """A motion that stays at home."""

    pose = ZERO

    def at(self, t):
        return JointReference((0.0, 0.0, 1.0), ZERO, ZERO)


def tugged(broken_by, settings):
    """Return each tug with its references, of pairs that jump once so much force pushes them."""
    follower = Follower()
    tugging = TugScript(settings, Upright(), follower, 120e3, 100e3)
    places = [0.0, 0.0]
    found = [[] for _ in settings.tugs]
    for cycle in range(int(settings.duration / PERIOD)):
        t = cycle * PERIOD
        one, other = places
        state = JointState(t, (one, -other, -one, other), (0.0,) * 4)
        tugging.update(state, tugging.at(t))
        reference = follower.asked[-1]
        number = next((k for k, tug in enumerate(settings.tugs) if tug.start <= t < tug.end), None)
        if number is not None:
            found[number].append((t, reference))
        pushes = reference.push or (0.0, 0.0)
        places = [
            math.copysign(1e-3, push) if abs(push) > broken_by else place if reference.push else 0.0
            for place, push in zip(places, pushes, strict=True)
        ]
    return zip(settings.tugs, found, strict=True)


def test_each_kind_of_tug_follows_each_kind_equally_often():
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1), rounds=2).tugs
    kinds = [(tug.pair, tug.side) for tug in tugs]
    follows = Counter(zip([kinds[-1], *kinds], kinds, strict=False))
    assert len(follows) == 16
    assert set(follows.values()) == {2}
    assert all(after.start == pytest.approx(before.end) for before, after in pairwise(tugs))


def test_pressures_swing_before_each_tug_and_as_often_begin_with_a_fall():
    settings = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1))
    follower = Follower()
    tugging = TugScript(settings, Upright(), follower, 120e3, 100e3)
    begins = Counter()
    for tug in settings.tugs:
        begins[tug.pair, tug.side, tug.swing] += 1
        asked = []
        for cycle in range(round((tug.rise - tug.start) / PERIOD) + 1):
            tugging.update(
                JointState(0.0, (0.0,) * 4, (0.0,) * 4), tugging.at(tug.start + cycle * PERIOD)
            )
            asked.append(follower.asked[-1])
        assert all(reference.push == (0.0, 0.0) for reference in asked[810:-1])
        pressures = np.array([reference.base_pressure for reference in asked[810:]])
        off = pressures / 120e3 - 1.0
        far = np.abs(off)
        turns = np.flatnonzero((far[1:-1] > far[:-2]) & (far[1:-1] >= far[2:])) + 1
        assert len(turns) == 24
        assert far[turns[0]] == pytest.approx(0.75, abs=0.02)
        assert np.all(np.diff(far[turns]) < 0.0)
        assert np.all(np.diff(np.sign(off[turns])) != 0.0)
        assert np.sign(off[turns[0]]) == tug.swing
        assert np.all(pressures[-290:] == 120e3)
    assert set(begins.values()) == {2}
    assert len(begins) == 8


def test_a_tug_pushes_one_pair_until_it_moves_and_the_controller_catches_it():
    settings = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1), rate=40.0, most=20.0)
    sides = set()
    for tug, asked in tugged(12.0, settings):
        pushes = [(t, reference.push) for t, reference in asked if reference.push is not None]
        alone = [push[tug.pair] for _, push in pushes]
        assert all(push[1 - tug.pair] == 0.0 for _, push in pushes)
        assert tug.side * alone[-1] == pytest.approx(12.0, abs=0.1)
        assert np.all(np.diff(np.abs(alone)) <= 40.0 * PERIOD + 1e-9)
        # From then on the controller has the ring, and brings it upright.
        last = pushes[-1][0]
        assert all(reference.push is None for t, reference in asked if t > last)
        assert asked[-1][1].axis == pytest.approx((0.0, 0.0, 1.0))
        sides.add((tug.pair, tug.side))
    assert sides == {(0, 1), (0, -1), (1, 1), (1, -1)}


def test_a_pair_that_does_not_move_is_pushed_no_harder_than_permitted():
    settings = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1), rate=40.0, most=20.0)
    for _, asked in tugged(99.0, settings):
        pushes = [abs(force) for _, reference in asked for force in reference.push or ()]
        assert 19.9 < max(pushes) < 20.0


def test_its_controller_is_calmer_than_usual_and_shakes_nothing(profile):
    calm, name = pneumatics_of(profile).with_gentle_controller()
    usual, now = profile.controllers[name], calm.controllers[name]
    assert now.pair.position_rate < 0.6 * usual.pair.position_rate
    assert now.pair.integral < 0.4 * usual.pair.integral
    assert now.dither.amplitude == 0.0 == now.camera.gain


def test_its_controller_keeps_gains_that_somebody_has_set_lower(profile):
    usual = profile.controllers["cascade"]
    careful = replace(usual, pair=replace(usual.pair, position_rate=40.0, integral=2e4))
    changed = replace(profile, controllers={"cascade": careful})
    calm, name = pneumatics_of(changed).with_gentle_controller()
    now = calm.controllers[name].pair
    assert (now.position_rate, now.integral) == (40.0, 2e4)
    usual, _ = pneumatics_of(profile).with_gentle_controller()
    assert now.velocity_rate == usual.controllers[name].pair.velocity_rate


def test_a_leaning_ring_is_moved_under_little_pull_and_without_a_pid(profile):
    assert profile.mechanism_settings.base_pressure == 200e3
    assert pneumatics_of(profile).gentle_pressure == 120e3
    assert pneumatics_of(profile).with_gentle_controller()[1] == "cascade"
    cylinder = load_profile("cylinder", REGISTRY, (), find_configs())
    assert pneumatics_of(cylinder).gentle_pressure == cylinder.mechanism_settings.base_pressure


LOW_SPEED = ("joint.friction.coulomb=4.8 N", "joint.friction.breakaway=5.0 N")


@pytest.fixture(scope="module")
def late():
    return load_profile("joint", REGISTRY, LOW_SPEED, find_configs())


def test_where_late_air_lets_a_ring_fall_its_gains_are_the_profiles_with_less_integral(late):
    calm, name = pneumatics_of(late).with_gentle_controller()
    usual, now = late.controllers[name], calm.controllers[name]
    assert now.pair.integral == pytest.approx(0.3 * usual.pair.integral)
    # What holds a falling ring, and what holds it at rest, is what was tuned for its regulators.
    assert replace(now.pair, integral=usual.pair.integral) == usual.pair
    assert now.friction_distance == usual.friction_distance
    assert now.dither.amplitude == now.path_dither.force == 0.0 == now.camera.gain


@pytest.mark.parametrize(
    ("response", "own"),
    [
        ("{dead_time: 7.1 ms}", False),
        ("{dead_time: 7.3 ms}", True),
        ("{dead_time: 12.1 ms, monitor_time: 5 ms}", False),  # for which the air does not wait
        ("{dead_time: 12.3 ms, monitor_time: 5 ms}", True),
    ],
)
def test_regulators_are_late_by_what_the_air_waits_for(response, own):
    options = (f"joint.regulator_response={response}", *LOW_SPEED)
    told = load_profile("joint", REGISTRY, options, find_configs())
    calm, name = pneumatics_of(told).with_gentle_controller()
    hold = calm.controllers[name].pair.hold_integral
    assert (hold == told.controllers[name].pair.hold_integral) is own


@pytest.mark.parametrize(("breakaway", "own"), [(5.7, True), (5.8, False)])
def test_seals_that_hold_the_ring_need_the_integrals_for_standard_ones(breakaway, own):
    options = (LOW_SPEED[0], f"joint.friction.breakaway={breakaway} N")
    told = load_profile("joint", REGISTRY, options, find_configs())
    calm, name = pneumatics_of(told).with_gentle_controller()
    hold = calm.controllers[name].pair.hold_integral
    assert (hold == told.controllers[name].pair.hold_integral) is own
    assert (pneumatics_of(told).with_placing_controller()[1] == "cascade") is own


def test_rods_are_taken_to_the_caliper_by_what_the_regulators_bear(profile, late):
    placing, name = pneumatics_of(profile).with_placing_controller()
    assert name == "pid" and placing.controllers[name].wire == profile.controllers[name].wire
    calm, name = pneumatics_of(late).with_placing_controller()
    assert name == "cascade"
    assert calm.controllers[name].pair.integral < late.controllers[name].pair.integral
    procedure = procedures(late)["encoders"]
    assert procedure.excite(late, ()).controller_name == "cascade"
