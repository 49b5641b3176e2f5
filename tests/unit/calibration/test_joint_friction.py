"""Friction of a joint's pairs: who does the strokes and tugs, and what the ball takes of them."""

import math
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from controllers.spherical_joint.geometry import PAIRS
from controllers.spherical_joint.types import JointCommand, JointReference, JointState
from controllers.spherical_joint.wires import InverseKinematics
from rig.assembly import REGISTRY
from rig.calibration.excitation import Strokes
from rig.calibration.joint.on_ball import belief_of, friction_on_ball
from rig.calibration.joint.stroke_fit import fit_strokes
from rig.calibration.joint.tugs import StrokesAndTugs, Tugging
from rig.calibration.mechanism import follower
from rig.calibration.pairs import pairs_of
from rig.calibration.recording import CalibrationRefused, Stretch
from rig.calibration.sliding import smooth
from rig.config import find_configs, load_profile

PERIOD = 1e-3
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def profile():
    return load_profile("joint", REGISTRY, (), find_configs())


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
    tugging = Tugging(settings, Upright(), follower, 120e3)
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
    calm, name = follower(profile)
    usual, now = profile.controllers[name], calm.controllers[name]
    assert now.pair.position_rate < 0.6 * usual.pair.position_rate
    assert now.pair.integral < 0.3 * usual.pair.integral
    assert now.dither.amplitude == 0.0 == now.camera.gain


def test_its_controller_keeps_gains_that_somebody_has_set_lower(profile):
    usual = profile.controllers["cascade"]
    careful = replace(usual, pair=replace(usual.pair, position_rate=40.0, integral=2e4))
    calm, name = follower(replace(profile, controllers={"cascade": careful}))
    now = calm.controllers[name].pair
    assert (now.position_rate, now.integral) == (40.0, 2e4)
    assert now.velocity_rate == follower(profile)[0].controllers[name].pair.velocity_rate


@pytest.mark.parametrize(("pairs", "share"), [(2, "shared"), (1, "alone")])
def test_what_the_wires_lose_the_ring_does_not_bear(profile, pairs, share):
    belief = belief_of(profile)._replace(ring=0.09, wire=0.12)
    wires, tension = belief.wound * belief.wire, 20.0
    ring = belief.ring * (math.sqrt(0.5) if pairs == 2 else 1.0)
    friction = 0.0
    for _ in range(50):
        a, b = tension + 0.5 * friction, tension - 0.5 * friction
        at_ring = (1.0 - wires) * a + (1.0 + wires) * b
        four = pairs * at_ring + (2 - pairs) * 2.0 * tension
        friction = wires * (a + b) + ring * four
    assert getattr(belief, share) == pytest.approx(friction / (2.0 * tension), rel=1e-9)


def lean(profile, way, pull):
    """Return a stretch whose rods have gone along a line between the pairs, m."""
    geometry = profile.mechanism_settings.geometry
    inverse = InverseKinematics(geometry, "exact", "natural")
    x, y = (
        math.sqrt(0.5) * sum(f(geometry.anchor_angles[one]) for one, _ in PAIRS)
        for f in (math.cos, math.sin)
    )
    columns = {"t": np.arange(len(way)) * PERIOD}
    tilts = (way / geometry.ball_radius).tolist()
    axes = [(math.sin(s) * x, math.sin(s) * y, math.cos(s)) for s in tilts]
    rods = np.array([inverse.motion(axis, ZERO, ZERO)[0] for axis in axes])
    for k in range(4):
        stretched = pull / profile.mechanism_settings.wire_stiffness
        columns[f"reading.rod_ch{k + 1}"] = rods[:, k] + stretched
        pressure = pull / profile.mechanism_settings.area
        columns[f"reading.pressure_ch{k + 1}"] = np.full(len(way), pressure)
    for name, column in zip("xyz", np.array(axes).T, strict=True):
        columns[f"estimate.encoder_marker_{name}"] = column
    return Stretch(columns), np.array(axes)


def test_the_ball_takes_from_both_pairs_what_their_tensions_load_it_with(profile):
    belief = belief_of(profile)._replace(coulomb=0.0, viscous=0.0)
    stretch, axes = lean(profile, np.linspace(-2e-3, 2e-3, 101), 20.0)
    pairs = pairs_of(profile, stretch, axes)
    signals = [smooth(pair.force, pair.position, pair.load, PERIOD) for pair in pairs]
    for on_ball in friction_on_ball(profile, belief, stretch, axes, signals):
        # Without a difference of tensions what one wire loses the other one gains.
        share = math.sqrt(2.0) * belief.ring + belief.wound * belief.wire
        assert on_ball == pytest.approx(share * 40.0, rel=0.01)


@pytest.mark.parametrize(
    ("way", "why"),
    [(lambda t: 1e-4 * t, "a rod is stuck"), (lambda t: 6e-3 * np.sin(220.0 * t), "it hunts")],
)
def test_pairs_that_did_not_slide_are_refused_with_the_reason(profile, way, why):
    t = np.arange(300) * PERIOD
    recording = {name: lean(profile, way(t), 20.0)[0] for name in ("one", "other")}
    with pytest.raises(CalibrationRefused, match=why):
        fit_strokes(profile, recording, list(recording), 10e-3)
