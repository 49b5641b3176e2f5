"""The base case of the walk: the paper's Fig. 3 to 5 as numbers."""

import math

import numpy as np
import pytest
from gait_laws import LAWS

from controllers.gait.geometry import KNEES, LegGeometry
from controllers.gait.laws import (
    InverseLaw,
    LimitedNormLaw,
    LimitedNormSettings,
    TrapezoidNormLaw,
    TrapezoidNormSettings,
)
from controllers.gait.motions import BobSettings, WalkSettings
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.types import BalanceSettings, GaitModel, LegsReference, LegsState
from controllers.motion import InfeasibleMotion

NAMES = [law.name for law in LAWS]
INSTANTS = (12.0, 18.0, 27.0, 33.0, 42.0, 48.0)


def test_hip_is_where_the_straightest_knee_puts_it():
    assert WalkSettings().hip_height(LegGeometry()) == pytest.approx(192.031e-3, abs=1e-6)


@pytest.mark.parametrize(
    ("law", "knee", "norm", "jump"),
    [
        ("inverse", 7.2, 8.84, 11.2),
        ("sc", 0.347, 0.425, 0.694),
        ("sc-trapezoid", 0.248, 0.309, 0.0021),
        ("min-jerk", 0.293, 0.362, 0.0007),
    ],
)
def test_rates_of_the_four_laws(plan, law, knee, norm, jump):
    made = plan(law)
    assert made.peak_knee_rate == pytest.approx(knee, rel=0.01)
    assert made.peak_norm == pytest.approx(norm, rel=0.01)
    assert made.greatest_jump == pytest.approx(jump, rel=0.01, abs=5e-5)


@pytest.mark.parametrize(
    ("law", "knee"), [("inverse", 25.3), ("sc", 1.74), ("sc-trapezoid", 1.24), ("min-jerk", 1.46)]
)
def test_rates_at_five_times_the_speed(plan, law, knee):
    made = plan(law, "walk 5x")
    assert made.duration == pytest.approx(9.6)
    assert made.peak_knee_rate == pytest.approx(knee, rel=0.01)


def test_only_the_plain_law_asks_more_than_a_servo_has(plan):
    limit = LegGeometry().max_rate
    beyond = {law: plan(law, "walk 5x").peak_rates.max() > limit for law in NAMES}
    assert beyond == {"inverse": True, "sc": False, "sc-trapezoid": False, "min-jerk": False}


@pytest.mark.parametrize(
    ("law", "knee"), [("inverse", 17.4), ("sc", 0.356), ("sc-trapezoid", 0.256)]
)
def test_rates_when_the_knee_is_exactly_straight(plan, law, knee):
    made = plan(law, "walk touching")
    assert made.q[:, list(KNEES)].min() == pytest.approx(0.0, abs=1e-7)
    assert made.peak_knee_rate == pytest.approx(knee, rel=0.01)


def test_plain_law_grows_without_bound_as_the_period_shrinks(plan):
    """At an exact touch with the inverse root of the period; the joints' length does not care."""
    coarse, fine = (plan("inverse", "walk touching", period) for period in (4e-3, 1e-3))
    assert fine.peak_knee_rate / coarse.peak_knee_rate == pytest.approx(2.0, rel=0.02)
    coarse, fine = (plan("sc-trapezoid", "walk touching", period) for period in (4e-3, 1e-3))
    assert fine.peak_knee_rate == pytest.approx(coarse.peak_knee_rate, rel=1e-3)


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.parametrize("period", [1e-3, 5e-3])
def test_the_way_is_kept_by_both_legs(plan, pulse, law, period):
    made = plan(law, "walk", period)
    assert made.duration == pytest.approx(48.0)
    assert made.advance == pytest.approx(0.120, abs=1e-9)
    assert made.mismatch() < 1e-10
    assert 20e-6 < made.mismatch(pulse) < 25e-6
    heights = made.odometry()[:, 2]
    assert np.ptp(heights) < 1e-9


@pytest.mark.parametrize("law", ["sc", "sc-trapezoid"])
def test_both_legs_agree_however_far_a_period_takes_them(plan, law):
    made = plan(law, "walk 5x", 5e-3)
    assert made.peak_norm * made.period > 7e-3  # rad in one update
    assert made.mismatch() < 1e-10
    assert made.off_path < 1e-10


@pytest.mark.parametrize("law", NAMES)
def test_feet_follow_half_sines_to_their_prints(plan, law):
    made = plan(law)
    swing = (made.t >= 18.0) & (made.t <= 27.0)
    left = made.feet[swing, 1]
    seen = made.feet[swing, 1] + made.waist[swing] - made.odometry()[swing]
    np.testing.assert_allclose(left, seen, atol=1e-9)
    along = left[:, 0] / 0.080
    np.testing.assert_allclose(left[:, 2], 0.020 * np.sin(np.pi * along), atol=1e-12)
    assert made.feet[-1, :, 0] == pytest.approx((0.120, 0.080))


@pytest.mark.parametrize(
    ("law", "half_width"), [("inverse", 0.05), ("sc", 0.21), ("sc-trapezoid", 0.65)]
)
def test_knees_are_near_straight_at_landings_and_arrivals_only(plan, law, half_width):
    windows = plan(law).near_singular_windows
    assert len(windows) == len(INSTANTS)
    for (start, end), instant in zip(windows, INSTANTS, strict=True):
        assert instant - half_width < start < instant <= end < instant + half_width
    assert np.degrees(plan(law).q[:, list(KNEES)].min()) == pytest.approx(1.0, abs=1e-6)


def test_first_shift_stays_away_from_the_singularity(plan):
    made = plan("sc")
    knees = made.q[made.t <= 3.0][:, list(KNEES)]
    assert np.degrees(knees.min()) == pytest.approx(23.1, abs=0.1)


def test_lengths_of_the_joints_curve(plan):
    lengths = [planned.joint_length for planned in plan("sc").phases]
    expected = (0.514, 1.891, 1.700, 2.523, 1.700, 2.523, 1.700)
    assert lengths == pytest.approx(expected, abs=5e-4)


def test_without_raised_speed_the_phases_stop_short(plan):
    reached = [planned.pace.reach_unraised for planned in plan("sc").phases]
    assert reached == pytest.approx((1.0, 0.986, 0.952, 0.936, 0.952, 0.936, 0.952), abs=1e-3)
    raised = [planned.pace.raised_by for planned in plan("sc").phases]
    assert raised == pytest.approx((1.0, 1.056, 1.122, 1.181, 1.122, 1.181, 1.122), abs=2e-3)


def test_a_phase_that_is_stepped_without_raised_speed_stops_there_too(plan):
    planned = plan("sc").phases[2]
    curve = PhaseCurve(LegGeometry(), planned.phase, 1e-3)
    speed = planned.path_length / planned.phase.duration
    for _ in range(round(planned.phase.duration / 1e-3)):
        norm, path = curve.rates()
        if speed * norm < planned.pace.norm_rate * path:
            curve.follow_path(speed * 1e-3)
        else:
            curve.follow_joints(planned.pace.norm_rate * 1e-3)
    assert curve.path == pytest.approx(planned.pace.reach_unraised, abs=2e-4)


@pytest.mark.parametrize("law", NAMES)
def test_online_the_motion_is_that_of_the_plan(plan, law):
    kind = next(kind for kind in LAWS if kind.name == law)
    online = kind(kind.Settings(), GaitModel(), 5e-3)
    made = online.prepare(WalkSettings(speed=3.0))
    standing = LegsState(0.0, (0.0,) * 12, (0.0,) * 12)
    online.reset(standing)
    approach = LegsReference((0.1,) * 12, (0.0,) * 12, follow=False)
    assert online.update(standing, approach).positions == approach.positions
    for sample in range(len(made.t)):
        # The wall clock stands still or runs ahead: one call is one period.
        command = online.update(standing, made.at(sample * 7e-3))
        assert command.positions == tuple(made.q[sample])
        np.testing.assert_allclose(command.velocities, made.q_dot[sample], atol=1e-9)
    after = online.update(standing, made.at(99.0))
    assert after.positions == tuple(made.q[-1])
    assert not any(after.velocities)


def test_law_that_prepared_nothing_does_not_run():
    law = InverseLaw(InverseLaw.Settings(), GaitModel(), 5e-3)
    with pytest.raises(RuntimeError, match="inverse was asked to run before it prepared"):
        law.update(LegsState(0.0, (), ()), LegsReference((), (), follow=True))


def test_six_landings_are_the_literal_three_steps_of_each_leg():
    law = TrapezoidNormLaw(TrapezoidNormSettings(), GaitModel(), 5e-3)
    made = law.prepare(WalkSettings(landings=6))
    assert made.duration == pytest.approx(93.0)
    assert made.advance == pytest.approx(0.240, abs=1e-9)
    assert len(made.near_singular_windows) == 12
    assert [segment.name for segment in made.segments][-2:] == ["swing left 6", "shift 6"]


def test_bob_straightens_the_standing_leg_in_mid_stance():
    law = TrapezoidNormLaw(TrapezoidNormSettings(), GaitModel(), 1e-3)
    made = law.prepare(WalkSettings(bob=BobSettings()))
    assert np.ptp(made.waist[:, 2]) == pytest.approx(4.1e-3, abs=0.05e-3)
    assert 0.24 < made.peak_knee_rate < 0.29
    middle = (made.t > 21.5) & (made.t < 23.5)
    right_knee = np.degrees(made.q[middle, KNEES[0]])
    assert right_knee == pytest.approx(np.full(len(right_knee), 1.0), abs=1e-3)
    assert made.advance == pytest.approx(0.120, abs=1e-8)
    assert made.mismatch() < 1e-8


def test_limited_norm_law_says_how_long_it_would_take():
    law = LimitedNormLaw(LimitedNormSettings(norm_rate=0.25), GaitModel(), 5e-3)
    with pytest.raises(InfeasibleMotion, match=r"^shift 1: .* takes 6\.802 s .* lasts 6 s"):
        law.prepare(WalkSettings())


def test_trapezoid_is_refused_where_a_joint_cannot_be_that_fast():
    model = GaitModel(LegGeometry(max_rate=0.2), BalanceSettings())
    law = TrapezoidNormLaw(TrapezoidNormSettings(), model, 5e-3)
    with pytest.raises(
        InfeasibleMotion, match=r"^shift 1: .* 0\.3092 rad/s.* at least 7\.363 s instead of 6 s"
    ):
        law.prepare(WalkSettings())


def test_limit_of_a_joint_is_refused_with_joint_and_instant():
    geometry = LegGeometry(max_angle=tuple(map(math.radians, (90, 30, 70, 40, 60, 24))))
    law = InverseLaw(InverseLaw.Settings(), GaitModel(geometry), 5e-3)
    with pytest.raises(
        InfeasibleMotion,
        match=r"at \d+\.\d+ s \(swing left 2\) left_knee would be at 56\.\d+ deg, outside 0 … 40",
    ):
        law.prepare(WalkSettings())


def test_step_beyond_reach_and_phase_too_short_are_refused():
    law = InverseLaw(InverseLaw.Settings(), GaitModel(), 5e-3)
    with pytest.raises(InfeasibleMotion, match=r"step of 200 mm with 39 mm of sway"):
        law.prepare(WalkSettings(step=0.2))
    with pytest.raises(InfeasibleMotion, match=r"less than two periods of 0\.005 s"):
        law.prepare(WalkSettings(first_shift_time=0.005))
