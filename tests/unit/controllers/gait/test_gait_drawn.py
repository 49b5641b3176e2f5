"""Drawn gaits: a plan keeps what its law promises, and what is refused is refused with reason.

Both are judged by kinematics of the tests' own.
"""

import math
import re

import numpy as np
import pytest
from gait_claims import false_claim
from gait_oracle import off_way

from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.laws import (
    LimitedNormLaw,
    LimitedNormSettings,
    MinimumJerkLaw,
    NoSettings,
    TrapezoidNormLaw,
    TrapezoidNormSettings,
)
from controllers.gait.motions import BobSettings, SquatSettings, WalkSettings
from controllers.gait.smooth import SmoothLaw, SmoothSettings
from controllers.gait.types import BalanceSettings, GaitModel
from controllers.motion import InfeasibleMotion

GEOMETRY = LegGeometry()
SHARE = 1e-3
"""By which a promised limit may be passed."""
OFF = 1e-6
"""m."""
LAWS = (
    (LimitedNormLaw, LimitedNormSettings()),
    (TrapezoidNormLaw, TrapezoidNormSettings()),
    (SmoothLaw, SmoothSettings()),
    (MinimumJerkLaw, NoSettings()),
)


def turns(axis, angles):
    """Return rotations about x, y or z, one per instant."""
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.tile(np.eye(3), (len(angles), 1, 1))
    matrix[:, i, i] = matrix[:, j, j] = np.cos(angles)
    matrix[:, j, i] = np.sin(angles)
    matrix[:, i, j] = -np.sin(angles)
    return matrix


def soles(geometry, q, waist):
    """Return both soles under their ankles, and how far they are from upright."""
    found, tilts = [], []
    for leg, side in ((0, -1.0), (1, 1.0)):
        yaw, roll, pitch, knee, ankle_pitch, ankle_roll = q[:, 6 * leg : 6 * leg + 6].T
        thigh = turns("z", yaw) @ turns("x", roll) @ turns("y", pitch)
        shank = thigh @ turns("y", knee)
        foot = shank @ turns("y", ankle_pitch) @ turns("x", ankle_roll)
        at = waist + np.array((0.0, side * geometry.hip_half_spacing, 0.0))
        at = at - geometry.thigh * thigh[..., 2] - geometry.shank * shank[..., 2]
        found.append(at - geometry.ankle_height * foot[..., 2])
        tilts.append(np.abs(foot - np.eye(3)).max())
    return np.stack(found, axis=1), max(tilts)


def draw_geometry(rng):
    """Return the legs as they are, or others: longer, of two lengths, wider, quicker."""
    if rng.random() < 0.5:
        return GEOMETRY
    low, high = (0.08, 0.08, 0.02, 0.03, 3.0), (0.16, 0.16, 0.06, 0.06, 7.0)
    thigh, shank, ankle, spacing, rate = rng.uniform(low, high).tolist()
    return LegGeometry(
        thigh=thigh, shank=shank, ankle_height=ankle, hip_half_spacing=spacing, max_rate=rate
    )


def draw_motion(rng):
    if rng.random() < 0.1:
        return SquatSettings(
            depth=float(rng.uniform(0.005, 0.08)),
            knee_min=float(rng.choice([0.0, 1e-6, 1e-2])),
            time=float(rng.uniform(0.3, 3.0)),
            repeats=1,
        )
    bob = None
    if rng.random() < 0.1:
        bob = BobSettings(support_knee=math.radians(float(rng.uniform(0.5, 3.0))))
    times = rng.uniform((1.0, 1.0, 1.0), (4.0, 6.0, 6.0)).tolist()
    others = {}
    if rng.random() < 0.2:
        others = {"ahead": float(rng.uniform(-0.03, 0.03)), "first": "left"}
    if rng.random() < 0.1:
        others["hip"] = float(rng.uniform(0.14, 0.2))
    return WalkSettings(
        **others,
        landings=int(rng.integers(1, 4)),
        step=float(rng.uniform(0.005, 0.1)),
        lift=float(rng.uniform(0.002, 0.06)),
        sway=float(rng.uniform(0.9, 1.4)),
        knee_min=float(rng.choice([0.0, 1e-6, 1e-2, math.radians(1.0), 0.3])),
        first_shift_time=times[0],
        shift_time=times[1],
        swing_time=times[2],
        speed=float(10 ** rng.uniform(0.0, 0.7)),
        fastest=bool(rng.random() < 0.05),
        bob=bob,
    )


def faults_of(motion, law, plan):
    """Return what is wrong with a plan."""
    geometry = law.model.geometry
    if not (np.isfinite(plan.q).all() and np.isfinite(plan.q_dot).all()):
        return ["not a number"]
    faults = []
    rates = np.diff(plan.q, axis=0) / plan.period
    fastest = getattr(motion, "fastest", False)
    if (law.keeps_rates or fastest) and np.abs(rates).max() > (1 + SHARE) * geometry.max_rate:
        faults.append("rate")
    if isinstance(law, SmoothLaw):
        changes = np.diff(rates, axis=0, prepend=0.0, append=0.0) / plan.period
        speed = law.acceleration(math.sqrt(_speed_squared(geometry, plan, motion)))
        if np.abs(changes).max() > (1 + SHARE) * speed:
            faults.append(f"acceleration {np.abs(changes).max():.4g} of {speed:.4g}")
    low, high = np.array(geometry.limits).T
    if (plan.q < low - 1e-8).any() or (plan.q > high + 1e-8).any():
        faults.append("range")
    feet, tilt = soles(geometry, plan.q, plan.waist)
    if tilt > OFF:
        faults.append("tilt")
    if off_way(geometry, motion, plan, feet) > OFF:
        faults.append("way")
    for planned in plan.phases:
        during = slice(planned.first, planned.last + 1)
        for leg, stands in enumerate(planned.phase.standing):
            if stands and np.ptp(feet[during, leg], axis=0).max() > OFF:
                faults.append(f"{planned.phase.name}: a foot that stands moves")
    if isinstance(motion, WalkSettings):
        landed = motion.landings * motion.step
        ahead = np.array((landed, landed - motion.step))
        if np.abs(np.sort(feet[-1, :, 0])[::-1] - ahead).max() > OFF:
            faults.append("landings")
        if motion.bob is None and np.ptp(plan.waist[:, 2]) > OFF:
            faults.append("hip height")
    if np.abs(feet[[0, -1], :, 2]).max() > OFF:
        faults.append("ground")
    return faults


def _speed_squared(geometry, plan, motion):
    """Return the square of the speed at which a walk was planned, `fastest` or not."""
    if not getattr(motion, "fastest", False):
        return motion.speed**2
    whole = sum(phase.duration for phase in motion.phases(geometry)) * motion.speed
    return (whole / plan.duration) ** 2 * (1.0 + 1e-2)


def judge(seeds):
    """Return how many gaits were planned, how many refused, and what is wrong by seed."""
    planned, refused, wrong = 0, 0, {}
    balance = BalanceSettings(min_margin=1e-6, response_time=1.0)
    for seed in seeds:
        rng = np.random.default_rng((3, seed))
        kind, settings = LAWS[seed % len(LAWS)]
        geometry, motion = draw_geometry(rng), draw_motion(rng)
        period = float(rng.choice([5e-3, 1e-2]))
        law = kind(settings, GaitModel(geometry, balance), period)
        try:
            plan = law.prepare(motion)
        except InfeasibleMotion as error:
            refused += 1
            lie = false_claim(str(error), motion, law, geometry, period)
            if lie or "-0.000" in str(error):
                wrong[seed] = (law.name, str(error), lie, motion)
            continue
        planned += 1
        faults = faults_of(motion, law, plan)
        if faults:
            wrong[seed] = (law.name, faults, motion)
    return planned, refused, wrong


def test_a_few_drawn_gaits():
    planned, _, wrong = judge(range(12))
    assert not wrong
    assert planned >= 4


def test_a_walk_that_is_to_be_as_fast_as_it_can_is_told_a_speed_that_keeps_the_rates():
    """Under min-jerk, which itself keeps no rates."""
    _, refused, wrong = judge([1171])
    assert (refused, wrong) == (1, {})


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("block", range(10))
def test_five_hundred_drawn_gaits(block):
    planned, _, wrong = judge(range(1000 + 50 * block, 1050 + 50 * block))
    assert not wrong
    assert planned >= 10


def model(**balance):
    return GaitModel(GEOMETRY, BalanceSettings(**{"min_margin": 1e-6, **balance}))


def test_a_knee_that_turns_round_in_mid_swing_is_slowed_before_it():
    walk = WalkSettings(
        landings=1, step=0.0287, lift=0.0279, sway=1.2535, knee_min=0.01745,
        first_shift_time=3.786, shift_time=4.284, swing_time=1.937, speed=3.005,
    )  # fmt: skip
    made = SmoothLaw(SmoothSettings(acceleration=8.0), model(), 2e-3).prepare(walk)
    hardest = np.abs(np.diff(made.q_dot, axis=0, append=0.0)).max() / 2e-3
    assert hardest <= 8.0 * walk.speed**2 * (1 + SHARE)
    trapezoid = TrapezoidNormLaw(TrapezoidNormSettings(), model(), 2e-3).prepare(walk)
    assert np.abs(np.diff(trapezoid.q_dot, axis=0)).max() / 2e-3 > 1000.0
    with pytest.raises(InfeasibleMotion, match=r"swing right 1: .*at least 0\.9\d+ s instead of"):
        SmoothLaw(SmoothSettings(), model(), 2e-3).prepare(walk)


def test_a_phase_does_not_end_early_where_its_parameter_outruns_the_joints():
    """Where a bob's curvature jumps; the last steps of the knee would be taken in one."""
    bob = BobSettings(support_knee=0.036641472502683015)
    walk = WalkSettings(
        landings=2, step=0.030212172881516758, lift=0.012456350675797872, sway=1.158571203660218,
        knee_min=0.0, first_shift_time=3.2402266993163016, shift_time=3.1188352182066854,
        swing_time=4.417792433785241, speed=3.001102782015991, bob=bob,
    )  # fmt: skip
    made = SmoothLaw(SmoothSettings(), model(response_time=1.0), 5e-3).prepare(walk)
    hardest = np.abs(np.diff(made.q_dot, axis=0, append=0.0)).max() / 5e-3
    assert hardest <= 2.0 * walk.speed**2 * (1 + SHARE)


def test_legs_agree_on_their_way_where_a_knee_turns_round_sharply():
    walk = WalkSettings(
        landings=3, step=0.005742548779796423, lift=0.02803981476183423, sway=1.3035848629058058,
        first_shift_time=2.59250236192561, shift_time=2.0485278719130915,
        swing_time=2.0856419582693726, speed=1.4059512407225987,
    )  # fmt: skip
    law = TrapezoidNormLaw(TrapezoidNormSettings(), model(response_time=1.0), 1e-2)
    made = law.prepare(walk)
    feet, _ = soles(GEOMETRY, made.q, made.waist)
    assert off_way(GEOMETRY, walk, made, feet) < 0.1 * OFF


@pytest.mark.slow
@pytest.mark.parametrize(
    ("true", "false"),
    [
        (r"than 0\.\d+ rad/s\^2", "than 0.9 rad/s^2"),
        (r"least [\d.]+ s", "least 9.9 s"),
        (r"of [\d.]+ s\.", "of 2 s."),
        (r"needs at", "wants at"),
    ],
)
def test_a_false_claim_is_found(true, false):
    walk, law = WalkSettings(), SmoothLaw(SmoothSettings(0.05), model(), 5e-3)
    with pytest.raises(InfeasibleMotion) as refused:
        law.prepare(walk)
    said = str(refused.value)
    assert false_claim(said, walk, law, GEOMETRY, 5e-3) == ""
    told, count = re.subn(true, false, said)
    assert count == 1
    assert false_claim(told, walk, law, GEOMETRY, 5e-3)


@pytest.mark.parametrize("acceleration", [0.5, 2.0, 20.0])
def test_smooth_walk_needs_less_of_its_knees_than_the_trapezoid_in_the_same_time(acceleration):
    trapezoid = TrapezoidNormLaw(TrapezoidNormSettings(), GaitModel(), 1e-2).prepare(WalkSettings())
    made = SmoothLaw(SmoothSettings(acceleration), GaitModel(), 1e-2).prepare(WalkSettings())
    assert made.duration == trapezoid.duration
    assert made.peak_knee_rate < 0.98 * trapezoid.peak_knee_rate
    # Whatever the timing, the peak is no less than the way of the fastest joint over the time.
    least = max(
        np.abs(np.diff(made.q[p.first : p.last + 1], axis=0)).max(axis=1).sum()
        / ((p.last - p.first) * made.period)
        for p in made.phases
    )
    assert made.peak_knee_rate > least
    if acceleration == 20.0:
        assert made.peak_knee_rate < 1.02 * least


@pytest.mark.parametrize("period", [1e-3, 2e-3, 5e-3, 1e-2])
def test_bounded_norm_is_bounded_at_coarse_periods_too(period):
    walk = WalkSettings(
        landings=4, step=0.06567, lift=0.03497, sway=1.281, knee_min=1e-6,
        first_shift_time=1.7676, shift_time=3.7031, swing_time=1.6168, speed=2.0399,
    )  # fmt: skip
    law = LimitedNormLaw(LimitedNormSettings(), model(response_time=10.0), period)
    assert law.prepare(walk).peak_rates.max() <= (1 + 1e-4) * GEOMETRY.max_rate


def test_fastest_walk_keeps_the_joints_rates_whatever_the_law():
    walk = WalkSettings(lift=0.06, step=0.02, knee_min=0.0, fastest=True)
    made = MinimumJerkLaw(NoSettings(), model(response_time=1.0), 1e-2).prepare(walk)
    assert 0.98 * GEOMETRY.max_rate < made.peak_rates.max() <= (1 + SHARE) * GEOMETRY.max_rate


def test_trapezoid_is_not_refused_for_a_share_that_it_does_not_meet_at_its_height():
    walk = WalkSettings(
        landings=2, step=0.0912, lift=0.00203, sway=1.4969, knee_min=1.745e-4,
        first_shift_time=3.7389, shift_time=1.0532, swing_time=2.8931, speed=1.04244,
    )  # fmt: skip
    made = TrapezoidNormLaw(TrapezoidNormSettings(), model(), 5e-3).prepare(walk)
    assert made.peak_rates.max() < 0.7 * GEOMETRY.max_rate


def test_an_angle_that_only_rounds_to_its_limit_is_shown_with_its_digits():
    law = TrapezoidNormLaw(TrapezoidNormSettings(), GaitModel(), 1e-2)
    made = law.prepare(WalkSettings())
    made.q[5, AXIS_NAMES.index("right_knee")] = math.radians(-1.25e-4)
    with pytest.raises(InfeasibleMotion, match=r"right_knee would be at -0\.000125 deg, outside 0"):
        law._check(made, 1.0)
