"""Friction of a joint's pairs: what strokes and tugs tell of it, and what the ball takes."""

import math

import numpy as np
import pytest
from pneumatic_rigs import pneumatics_of

from controllers.spherical_joint.geometry import PAIRS
from controllers.spherical_joint.wires import InverseKinematics
from rig.assembly import REGISTRY
from rig.calibration.estimates import Fit
from rig.calibration.recording import CalibrationRefused, Stretch
from rig.config import find_configs, load_profile
from rig.mechanisms.joint.calibration.ball_friction import belief_of, friction_on_ball
from rig.mechanisms.joint.calibration.breakaway import Breakaways, TugCase, cases_of, forces_of_tugs
from rig.mechanisms.joint.calibration.leaning import Strokes
from rig.mechanisms.joint.calibration.stroke_fit import (
    COULOMB,
    GROWTH,
    VISCOUS,
    LeftOut,
    StrokeFit,
    fit_strokes,
)
from rig.mechanisms.joint.calibration.tugs import BACK, OTHER, SAME, StrokesAndTugs
from rig.mechanisms.pneumatic.calibration.smoothing import Bump

PERIOD = 1e-3
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def profile():
    return load_profile("joint-ideal", REGISTRY, (), find_configs())


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
    pairs = pneumatics_of(profile).signals(stretch, axes)
    signals = [Bump(PERIOD).smooth(pair) for pair in pairs]
    for on_ball in friction_on_ball(profile, belief, stretch, axes, signals):
        # Without a difference of tensions what one wire loses the other one gains.
        share = math.sqrt(2.0) * belief.ring + belief.wound * belief.wire
        assert on_ball == pytest.approx(share * 40.0, rel=0.01)


def of_a_tug(profile, tug, breaks_at, seals, lost, lean=0.0):
    """Return a stretch of a ring that stands upright until a force moves it 1 mm at once.

    Seals take as much of either rod's pull; the chambers have lost some pressure (Pa), or the
    wires of the pair stand so far off (m).
    """
    settings = profile.mechanism_settings
    t = np.arange(1500) * PERIOD
    force = tug.side * np.minimum(20.0 * t, breaks_at + 0.5)
    pulls = np.full((len(t), 4), settings.area * (settings.base_pressure - lost))
    taken = np.zeros(4)
    one, other = PAIRS[tug.pair]
    taken[one], taken[other] = tug.side * seals, -tug.side * seals
    pulls[:, one] += 0.5 * force
    pulls[:, other] -= 0.5 * force
    rods = (pulls - taken) / settings.wire_stiffness
    gone = np.where(20.0 * t > breaks_at, 1e-3 * tug.side, 0.0) + lean
    rods[:, one] += gone
    rods[:, other] -= gone
    columns = {"t": t, **{f"estimate.encoder_marker_{n}": 0.0 * t for n in "xy"}}
    columns["estimate.encoder_marker_z"] = 0.0 * t + 0.05
    for k in range(4):
        columns[f"reading.rod_ch{k + 1}"] = rods[:, k]
        columns[f"reading.pressure_ch{k + 1}"] = pulls[:, k] / settings.area
    return Stretch(columns)


def test_a_tug_takes_what_pushes_before_the_pair_is_fast_at_base_pressure(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    belief = belief_of(profile)._replace(seals=0.02)
    seals = 0.5 * (22.0 - belief.alone * belief.usual)
    lost = 3e3
    recording = {tug.name: of_a_tug(profile, tug, 22.0, seals, lost) for tug in tugs}
    grown = 4.0 * belief.ring + 2.0 * (belief.wound * belief.wire + belief.seals)
    grown *= lost * profile.mechanism_settings.area
    found = forces_of_tugs([TugCase(profile, belief)], recording, tugs)
    # The last bump without speed has its middle some 7 ms before the pair jumps.
    assert found == pytest.approx(np.full((1, len(tugs)), 22.0 - 0.14 + grown), abs=0.03)


def test_a_ring_that_leans_adds_nothing_to_what_a_tug_takes(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    belief = belief_of(profile)
    upright = {tug.name: of_a_tug(profile, tug, 22.0, 5.0, 0.0) for tug in tugs}
    stretched = {tug.name: of_a_tug(profile, tug, 22.0, 5.0, 0.0, lean=0.2e-3) for tug in tugs}
    one, other = (
        forces_of_tugs([TugCase(profile, belief)], recording, tugs)[0]
        for recording in (upright, stretched)
    )
    # Rods that stand 0.2 mm off: all four tensions let the ring fall on by as much of them.
    sides = np.array([tug.side for tug in tugs])
    fallen = sides * (other - one)
    assert fallen == pytest.approx(np.full(len(tugs), fallen[0]), rel=0.1)
    settings = profile.mechanism_settings
    pulls = 4.0 * settings.area * settings.base_pressure
    assert 0.2 < fallen[0] / (pulls * 0.2e-3 / settings.geometry.ball_radius) < 1.0


def test_a_pair_that_never_moved_tells_nothing(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    recording = {tug.name: of_a_tug(profile, tug, 99.0, 6.0, 0.0) for tug in tugs}
    assert np.all(np.isnan(forces_of_tugs([TugCase(profile, belief_of(profile))], recording, tugs)))


def taken_in(tugs, scatter, swung=0.2):
    """Return what tugs take: by their kind, by what was before, and by chance."""
    kinds = {(0, 1): 20.0, (0, -1): 18.0, (1, 1): 15.0, (1, -1): 16.0}
    before = {SAME: 0.3, BACK: -0.5, OTHER: 0.1}
    kept = np.array([kinds[t.pair, t.side] + before[t.after] + swung * t.swing for t in tugs])
    return kept + scatter


def test_what_tugs_leave_behind_counts_neither_in_the_mean_nor_as_scatter(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    forces = taken_in(tugs, np.zeros(len(tugs)), swung=0.0)
    breakaways, case = Breakaways(tugs, forces, (0, 1)), [TugCase(profile, belief_of(profile))]
    for pair, value in enumerate((19.0, 15.5)):
        found = breakaways.estimate(pair, "b", case, forces[None])
        assert (found.value, found.std) == pytest.approx((value, 0.0), abs=1e-9)


def test_the_interval_of_breakaway_holds_chance_and_what_may_be_true(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1), rounds=8).tugs
    scatter = np.random.default_rng(3).normal(0.0, 0.1, len(tugs))
    forces = taken_in(tugs, scatter)
    belief = belief_of(profile)
    breakaways = Breakaways(tugs, forces, (0, 1))
    alone = breakaways.estimate(0, "b", [TugCase(profile, belief)], forces[None])
    mine = np.array([tug.pair == 0 for tug in tugs])
    assert alone.value == pytest.approx(19.0 + scatter[mine].mean())
    # What swings leave lies anywhere between what begins with a rise and with a fall.
    chance, left = 0.1 / math.sqrt(mine.sum()), 0.2 / math.sqrt(3.0)
    assert alone.std == pytest.approx(math.hypot(chance, left), rel=0.1)
    # An even one: 95 % of it are within 1.65 standard deviations.
    assert alone.high - alone.value == pytest.approx(1.65 * alone.std, rel=0.02)
    cases = [TugCase(profile, belief), TugCase(profile, belief, bound=True)]
    both = breakaways.estimate(0, "b", cases, np.array([forces, forces - 0.3]))
    assert both.value == alone.value
    assert both.std == pytest.approx(math.hypot(alone.std, 0.3 / math.sqrt(3.0)))


def test_a_pair_with_too_few_tugs_leaves_the_other_one_its_own(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    forces = taken_in(tugs, np.random.default_rng(3).normal(0.0, 0.01, len(tugs)), swung=0.0)
    forces[[tug.pair == 0 for tug in tugs]] = np.nan
    case = [TugCase(profile, belief_of(profile))]
    found = Breakaways(tugs, forces, (1,)).estimate(1, "b", case, forces[None])
    assert found.value == pytest.approx(15.5, abs=0.02)
    assert 0.0 < found.std < 0.02


def test_what_else_may_be_true_takes_as_much_of_the_strokes(profile):
    belief = belief_of(profile)._replace(seals=0.02)
    believed, share, seals, growth, stiffness = cases_of(profile, belief, 0.1)
    assert believed.belief is belief
    assert share.belief.ring == pytest.approx(1.3 * belief.ring)
    assert share.belief.shared == pytest.approx(belief.shared, rel=0.002)
    assert seals.belief.seals == 0.0
    assert seals.belief.shared == pytest.approx(belief.shared + belief.seals, rel=0.02)
    assert growth.belief.shared == pytest.approx(1.1 * belief.shared, rel=0.02)
    usual = profile.mechanism_settings.wire_stiffness
    assert stiffness.profile.mechanism_settings.wire_stiffness == pytest.approx(1.1 * usual)


def test_the_interval_of_sliding_friction_holds_what_else_may_be_true():
    def told(value):
        return Fit(np.array([value]), np.array([[0.1**2]]), 400.0, np.zeros(5))

    # As little and as much as may be the seals', as much as may be the ring's, stiffer wires.
    strokes = StrokeFit(None, (told(7.0), told(7.2)), told(7.3), told(6.8))
    found = strokes.estimate(0, "coulomb", "N")
    assert found.value == pytest.approx(7.1)
    bounds = math.hypot(0.1, 0.3) / math.sqrt(3.0)
    assert found.std == pytest.approx(math.hypot(0.1, bounds, 0.2))
    assert found.high - found.value == pytest.approx(1.93 * found.std, rel=0.02)


@pytest.mark.parametrize("index", [COULOMB, VISCOUS, GROWTH])
def test_what_the_model_leaves_out_is_a_share_of_each_of_its_own(index):
    fit = Fit(np.full(4, 7.0), np.diag(np.full(4, 0.1**2)), 400.0, np.zeros(5))
    exact = StrokeFit(None, (fit, fit), fit, fit)
    left_out = exact._replace(model=LeftOut(coulomb=0.1, viscous=0.2, growth=0.3))
    share = {COULOMB: 0.1, VISCOUS: 0.2, GROWTH: 0.3}[index]
    more = math.hypot(0.1, share * 7.0 / math.sqrt(3.0))
    assert exact.estimate(index, "f", "N").std == pytest.approx(0.1)
    assert left_out.estimate(index, "f", "N").std == pytest.approx(more)
    assert left_out.estimate(0, "f", "N").std == pytest.approx(0.1)


def test_a_force_rises_on_while_the_moment_of_breakaway_is_not_known(profile):
    tugs = StrokesAndTugs(Strokes(10e-3, (0.05,), 0.1)).tugs
    forces = taken_in(tugs, np.zeros(len(tugs)), swung=0.0)
    case = [TugCase(profile, belief_of(profile))]
    found = Breakaways(tugs, forces, (0, 1), 0.04).estimate(0, "b", case, forces[None])
    assert found.std == pytest.approx(0.04 / math.sqrt(3.0))
    assert found.high - found.value == pytest.approx(0.95 * 0.04, rel=0.02)


@pytest.mark.parametrize(
    ("way", "why"),
    [(lambda t: 1e-4 * t, "a rod is stuck"), (lambda t: 6e-3 * np.sin(220.0 * t), "it hunts")],
)
def test_pairs_that_did_not_slide_are_refused_with_the_reason(profile, way, why):
    t = np.arange(300) * PERIOD
    recording = {name: lean(profile, way(t), 20.0)[0] for name in ("one", "other")}
    with pytest.raises(CalibrationRefused, match=why):
        fit_strokes(profile, recording, list(recording), 10e-3)
