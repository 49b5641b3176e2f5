"""Lines past and through shoulder and wrist, and all laws side by side."""

from functools import cache

import numpy as np
import pytest
from arm_cases import (
    ELBOW_CIRCLE,
    SHOULDER_CIRCLE,
    SHOULDER_HIT,
    SHOULDER_MISS,
    WRIST_HIT,
    WRIST_MISS,
)
from drawn_cases import WIDE, faults_of

from controllers.arm.axis_path import axis_path_of_line
from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Line, TurnBack
from controllers.arm.plain import (
    DampedLeastSquares,
    DampedSettings,
    Inverse,
    InverseSettings,
    ServoHalt,
    ServoHaltSettings,
)
from controllers.arm.retiming import Timing, retime, velocity_limited_time
from controllers.arm.trajectories import make_trajectory
from controllers.motion import InfeasibleMotion

GEOMETRY = ArmGeometry()
ARM = dimensions_of(GEOMETRY)
RATES = np.array(GEOMETRY.rate_limits)
ACCELERATIONS = np.array(GEOMETRY.acceleration_limits)
LAWS = {
    "inverse": (Inverse, InverseSettings(), 1e-3),
    "dls": (DampedLeastSquares, DampedSettings(), 1e-2),
    "servo-halt": (ServoHalt, ServoHaltSettings(), 1e-2),
    "esc-paper": (EscPaper, EscPaperSettings(), 5e-3),
    "esc": (Esc, EscSettings(), 5e-3),
    "look-ahead": (LookAhead, LookAheadSettings(), 5e-3),
}


@cache
def plan_of(law, path):
    kind, settings, period = LAWS[law]
    return kind(settings, GEOMETRY, period).prepare(path)


@cache
def optimum(path):
    return velocity_limited_time(axis_path_of_line(ARM, make_trajectory(ARM, path)), RATES)


LINES = {
    "shoulder miss": SHOULDER_MISS,
    "wrist miss": WRIST_MISS,
    "shoulder hit": SHOULDER_HIT,
    "wrist hit": WRIST_HIT,
}


def test_the_velocity_limited_optimum():
    assert optimum(SHOULDER_MISS) == pytest.approx(6.58, abs=0.01)
    assert optimum(WRIST_MISS) == pytest.approx(3.85, abs=0.03)
    assert optimum(WRIST_HIT) == pytest.approx(3.0, abs=1e-3)
    assert optimum(SHOULDER_HIT) == pytest.approx(4.0, abs=1e-3)


@pytest.mark.parametrize("path", LINES.values(), ids=LINES)
def test_look_ahead_is_as_fast_as_the_limits_allow(path):
    plan = plan_of("look-ahead", path)
    assert optimum(path) <= plan.duration <= 1.10 * optimum(path)
    assert plan.path_deviation < 1e-5
    assert (plan.peak_rates <= RATES).all()
    assert (plan.peak_accelerations <= ACCELERATIONS).all()
    assert np.linalg.norm(plan.twist[:, :3], axis=1).max() <= path.speed * (1 + 2e-4)
    assert np.abs(plan.velocities[[0, -1]]).max() < 1e-9, "from rest to rest"


@pytest.mark.parametrize("path", LINES.values(), ids=LINES)
def test_esc_takes_no_longer_than_the_rates_require(path):
    plan = plan_of("esc", path)
    assert plan.outcome == "done"
    assert plan.duration == pytest.approx(optimum(path), rel=1e-3)
    assert plan.path_deviation < 1e-5
    assert plan.twist_residual < 1e-6
    assert (plan.peak_rates <= RATES).all()


def test_the_papers_law_loses_near_misses_and_stalls_on_hits():
    shoulder, wrist = plan_of("esc-paper", SHOULDER_MISS), plan_of("esc-paper", WRIST_MISS)
    assert shoulder.duration == pytest.approx(11.5, abs=0.15)
    assert shoulder.duration / optimum(SHOULDER_MISS) == pytest.approx(1.74, abs=0.03)
    assert wrist.duration > 1.2 * optimum(WRIST_MISS)
    for plan in (shoulder, wrist):
        assert plan.path_deviation < 1e-8
        assert plan.twist_residual < 1e-9
        assert (plan.peak_rates <= 1.001 * RATES).all()
    for path in (WRIST_HIT, SHOULDER_HIT):
        stalled = plan_of("esc-paper", path)
        gone = np.linalg.norm(stalled.hand[-1] - stalled.hand[0])
        assert stalled.outcome == "stalls"
        assert gone == pytest.approx(path.before, abs=1e-3)
        assert gone < path.before + 1e-9


def test_the_plain_inverse_breaks_the_limits():
    peaks = plan_of("inverse", SHOULDER_MISS).peak_rates
    assert peaks[0] == pytest.approx(52, abs=2)
    assert peaks[5] > 40
    assert plan_of("inverse", WRIST_MISS).peak_rates[3] == pytest.approx(14, abs=1)
    line = plan_of("inverse", TurnBack())
    assert line.peak_rates[2] > 15
    assert line.crossings == ()
    assert line.duration == pytest.approx(10.44, abs=0.02)
    assert plan_of("inverse", SHOULDER_CIRCLE).peak_rates[0] == pytest.approx(7.8, abs=0.5)
    assert plan_of("inverse", ELBOW_CIRCLE).peak_accelerations.max() > 300


def test_damped_least_squares_keeps_the_limits_and_leaves_the_path():
    for path, deviation in ((SHOULDER_MISS, 2e-3), (WRIST_MISS, 8e-3), (TurnBack(), 3e-4)):
        plan = plan_of("dls", path)
        assert (plan.peak_rates <= RATES).all()
        assert plan.path_deviation > deviation
        assert plan.crossings == ()
    assert plan_of("dls", TurnBack()).inside.min() > 2e-3, "it turns back before the boundary"


def test_servo_halt_does_not_finish():
    for path in (TurnBack(), SHOULDER_MISS, WRIST_MISS, WRIST_HIT, ELBOW_CIRCLE):
        plan = plan_of("servo-halt", path)
        assert plan.outcome == "halts"
        assert (plan.peak_rates <= RATES).all()
        assert plan.crossings == ()
    assert plan_of("servo-halt", TurnBack()).inside.min() > 0.02


def test_look_ahead_at_the_boundary():
    path = TurnBack()
    esc, ahead = plan_of("esc", path), plan_of("look-ahead", path)
    assert ahead.duration < esc.duration
    assert len(ahead.crossings) == 1
    assert ahead.path_deviation < 1e-8
    assert ahead.twist_residual < 1e-5
    assert (ahead.peak_rates <= RATES).all()
    assert (ahead.peak_accelerations <= ACCELERATIONS).all()
    for circle in (ELBOW_CIRCLE, SHOULDER_CIRCLE):
        plan = plan_of("look-ahead", circle)
        assert plan.duration < 1.02 * plan_of("esc", circle).duration
        assert plan.path_deviation < 1e-8
        assert (plan.peak_accelerations <= ACCELERATIONS).all()


@pytest.mark.parametrize(
    "geometry",
    [
        {"elbow_offset": 0.05, "wrist_sign": -1, "base_height": 0.3},
        pytest.param({"a2": 0.4, "a3": 0.4}, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("path", LINES.values(), ids=LINES)
def test_other_arms_pass_as_well(geometry, path):
    other = ArmGeometry(**geometry)
    plan = LookAhead(LookAheadSettings(), other, 5e-3).prepare(path)
    assert plan.path_deviation < 1e-5
    assert plan.outcome == "done"
    assert (plan.peak_rates <= RATES).all()


def test_a_line_that_leaves_the_workspace_is_refused_with_the_distance():
    path = Line(middle=(0.0, 0.7, 1.2, 0.3, 0.8, 0.0), before=0.1, after=0.6)
    for law in ("esc", "look-ahead"):
        with pytest.raises(InfeasibleMotion, match=r"after 0\.\d+ m of 0\.7000 m .*to 0\.79 m"):
            plan_of(law, path)


def test_turning_the_tool_on_a_line():
    path = Line(middle=(0.2, 0.4, 1.5, 0.3, 0.8, 0.1), direction=(0.3, 1.0, 0.2), turn_rate=0.4)
    plan = plan_of("look-ahead", path)
    turned = np.sum(plan.scale[:, 1]) * plan.period * path.turn_rate
    assert turned == pytest.approx(0.4 * 0.3 / 0.1, rel=1e-2)
    assert plan.twist_residual < 1e-6


def test_timing_against_the_closed_form_of_one_joint():
    """A joint that goes one radian from rest to rest: a trapezoid of velocity."""
    from controllers.arm.axis_path import AxisPath

    share = np.linspace(0.0, 1.0, 200)
    path = AxisPath([(float(x), 0.0, 0.0, 0.0, 0.0, 0.0) for x in share], share, share)
    timing = retime(path, (0.5,) * 6, (2.0,) * 6)
    a = 0.98 * 2.0
    assert timing.duration == pytest.approx(1.0 / 0.5 + 0.5 / a, rel=1e-3)
    s, speed = timing.at(np.array([0.0, 0.1, timing.duration]))
    assert s == pytest.approx((0.0, 0.5 * a * 0.01, 1.0), abs=1e-6)
    assert speed[1] == pytest.approx(a * 0.1, rel=1e-6)
    assert isinstance(timing, Timing)


def test_timing_against_toppra():
    toppra = pytest.importorskip("toppra")
    constraint, algorithm = (
        pytest.importorskip("toppra.constraint"),
        pytest.importorskip("toppra.algorithm"),
    )
    path = axis_path_of_line(ARM, make_trajectory(ARM, WRIST_MISS))
    grid = np.linspace(0.0, path.length, 1500)
    spline = toppra.SplineInterpolator(grid, path.joints(grid))
    limits = [
        constraint.JointVelocityConstraint(np.column_stack((-RATES, RATES))),
        constraint.JointAccelerationConstraint(
            np.column_stack((-ACCELERATIONS, ACCELERATIONS)) * 0.98
        ),
    ]
    solved = algorithm.TOPPRA(limits, spline, gridpoints=grid).compute_parameterization(0, 0)[1]
    theirs = float(np.sum(2 * np.diff(grid) / (solved[:-1] + solved[1:])))
    # The hand's own speed limit is not theirs: ours is without it here, too.
    path.way = lambda s, order=0: np.full((len(s), 2), 1e-9)
    assert retime(path, RATES, ACCELERATIONS).duration == pytest.approx(theirs, rel=5e-3)


def test_a_line_that_no_lower_limit_of_single_joints_helps_is_slowed_as_a_whole():
    """A micrometre past the axis of q1, and as short as that takes: 10.04 rad/s^2 were left."""
    geometry = ArmGeometry(wrist_sign=-1, **WIDE)
    path = Line(
        middle=(-0.56037988, 1.08573396, 0.89780859, 2.01071661, -0.38290331, 2.60480817),
        shoulder_distance=1e-6,
        direction=(0.21510314, 0.37980107, 0.99092074),
        before=0.00120468,
        after=0.01704685,
        speed=0.14758266,
        axis=(1.13063193, -0.8373016536, 0.22007285),
        turn_rate=0.2826178,
    )
    plan = LookAhead(LookAheadSettings(), geometry, 5e-3).prepare(path)
    assert faults_of(geometry, path, plan, range(6), range(6)) == []
