"""Circles through the elbow's and the shoulder's singularity; the corrected equations."""

import dataclasses
import math
import time

import numpy as np
import pytest
from arm_cases import ELBOW_CIRCLE, SHOULDER_CIRCLE
from twist_oracle import hand_of

from controllers.arm.circles import elbow_rate, shoulder_circle_rates
from controllers.arm.circular_trajectory import CircularTrajectory
from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, wrist_in_plane
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Circle
from controllers.motion import InfeasibleMotion

ARM = dimensions_of(ArmGeometry())
R1, R2, RATE = 0.55, 0.24, 0.4


def follow(path, period=1e-2, **geometry):
    return Esc(EscSettings(), ArmGeometry(**geometry), period).prepare(path)


def elbow_angle(gamma):
    """Return q3 on the circle from the law of cosines."""
    square = R1**2 + R2**2 + 2 * R1 * R2 * math.cos(gamma)
    return math.acos((square - ARM.a2**2 - ARM.a3**2) / (2 * ARM.a2 * ARM.a3))


def test_the_elbows_rate_against_differences():
    h = 1e-6
    for gamma in (0.2, 1.0, 2.0):
        q3 = elbow_angle(gamma)
        slope = (elbow_angle(gamma + RATE * h) - elbow_angle(gamma - RATE * h)) / (2 * h)
        assert elbow_rate(ARM, R1, R2, gamma, RATE, q3, 1.0) == pytest.approx(slope, abs=1e-8)


def test_equation_8_is_the_circle_with_a_square_root():
    """The paper prints ``2 r1 r2 / (a2 a3)`` before the sine and the cosine."""
    for gamma in (0.2, 1.0, 1.5, 2.0):
        q3 = elbow_angle(gamma)
        share = R1 * R2 / (ARM.a2 * ARM.a3)
        sine_and_cosine = 2 * math.sin(gamma / 2) * math.cos(q3 / 2)
        assert math.sqrt(share) * sine_and_cosine == pytest.approx(math.sin(q3), abs=1e-14)
        assert abs(share * sine_and_cosine - math.sin(q3)) > 0.01


def test_at_the_singularity_the_rate_is_finite_whatever_the_quotient():
    root = math.sqrt(R1 * R2 / (ARM.a2 * ARM.a3))
    assert elbow_rate(ARM, R1, R2, 0.0, RATE, 0.0, -1.0) == pytest.approx(-RATE * root)


@pytest.mark.parametrize("t", [0.5, 2.0, 4.0])
def test_q1_is_the_quotient_that_vanishes_on_the_shoulders_circle(t):
    """Off the axis ``v_y / c`` is half the circle's rate: eq. (9), which lacks r1, and (10)."""
    law = Esc(EscSettings(), ArmGeometry(), 1e-2)
    trajectory = CircularTrajectory(ARM, SHOULDER_CIRCLE)
    q = tuple(law.prepare(SHOULDER_CIRCLE).positions[round(t / 1e-2)])
    velocity = trajectory.wrist_velocity(t)
    c, _ = wrist_in_plane(ARM, q[1], q[2])
    across = -math.sin(q[0]) * velocity[0] + math.cos(q[0]) * velocity[1]
    rates = shoulder_circle_rates(ARM, q, velocity, SHOULDER_CIRCLE.rate)
    assert rates[0] == pytest.approx(across / c, rel=1e-9)
    assert rates[0] == 0.5 * SHOULDER_CIRCLE.rate


def test_half_a_circle_through_the_elbows_singularity():
    plan = follow(ELBOW_CIRCLE)
    assert plan.duration == pytest.approx(7.85, abs=5e-3)
    assert plan.peak_rates[2] == pytest.approx(0.368, abs=1e-3)
    assert plan.crossings == pytest.approx((plan.duration / 2,), abs=1e-7)
    assert plan.peak_accelerations[2] < 0.04
    assert plan.path_deviation < 1e-9
    assert plan.twist_residual < 1e-9
    assert np.linalg.norm(plan.twist[:-1, :3], axis=1) == pytest.approx(0.096, abs=1e-9)


def test_half_a_circle_through_the_shoulders_axis():
    plan = follow(SHOULDER_CIRCLE)
    assert plan.duration == pytest.approx(5.236, abs=5e-4)
    assert plan.peak_rates[0] == pytest.approx(0.3, abs=1e-9)
    c = plan.indices[:, 0]
    assert c[0] < 0.0 < c[-1]
    np.testing.assert_allclose(plan.velocities[:-1, 0], 0.3, atol=1e-12)
    assert plan.path_deviation < 1e-9
    assert plan.twist_residual < 1e-9


@pytest.mark.parametrize(
    ("plane", "side"),
    [
        (0.7, -1),
        *(
            pytest.param(plane, side, marks=pytest.mark.slow)
            for plane, side in ((0.0, 1), (0.0, -1), (0.7, 1), (math.pi / 2, 1), (math.pi / 2, -1))
        ),
    ],
)
def test_twice_round_leads_back_to_the_same_joints(plane, side):
    wide = {"position_min": (-30.0,) * 6, "position_max": (30.0,) * 6}
    path = Circle(plane=plane, side=side, radius=0.1, begin=-1.0, end=4 * math.pi - 1.0, rate=1.0)
    plan = follow(path, 1e-2, **wide)
    turns = (plan.positions[-1] - plan.positions[0]) / (2 * math.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6 / (2 * math.pi))
    assert abs(turns[2]) < 1e-6
    assert len(plan.crossings) == 2
    once = np.argmin(np.abs(plan.t - 2 * math.pi))
    assert abs(plan.positions[once, 2] - plan.positions[0, 2]) > 0.5, "once round is not enough"


def test_twice_round_the_shoulders_circle():
    wide = {"position_min": (-30.0,) * 6, "position_max": (30.0,) * 6}
    touch = (0.0, 0.0, 2.0, 0.5, -0.8, 0.0)
    path = Circle("shoulder", touch, radius=0.1, begin=-1.0, end=4 * math.pi - 1.0, rate=0.8)
    plan = follow(path, 1e-2, **wide)
    turns = (plan.positions[-1] - plan.positions[0]) / (2 * math.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6 / (2 * math.pi))
    assert turns[0] == pytest.approx(1.0, abs=1e-9)


def test_the_papers_law_takes_circles_alike():
    paper = EscPaper(EscPaperSettings(), ArmGeometry(), 1e-2).prepare(ELBOW_CIRCLE)
    np.testing.assert_array_equal(paper.positions, follow(ELBOW_CIRCLE).positions)


@pytest.mark.parametrize(
    "geometry",
    [{"a2": 0.4, "a3": 0.4}, {"elbow_offset": 0.06}, {"wrist_sign": -1, "base_height": 1.0}],
)
@pytest.mark.parametrize("path", [ELBOW_CIRCLE, SHOULDER_CIRCLE], ids=["elbow", "shoulder"])
def test_other_arms_take_circles_as_well(geometry, path):
    plan = follow(path, **geometry)
    assert plan.path_deviation < 1e-8
    assert plan.twist_residual < 1e-8


SECOND = {"shoulder": (0.0, 0.0, 2.0, 0.5), "elbow": (0.0, 1.0, 0.0, 0.5)}
GAMMAS = {"through": (-1.5, 1.5), "from": (0.0, 1.5), "to": (-1.5, 0.0)}


def fast(law, path):
    """Return a plan within the 30 s that such a circle once took, and 40 GiB."""
    law.longest = 600.0
    began = time.process_time()
    plan = law.prepare(path)
    assert time.process_time() - began < 5.0
    return plan


@pytest.mark.parametrize("gammas", GAMMAS)
@pytest.mark.parametrize("through", SECOND)
@pytest.mark.parametrize("rate", [0.39, 0.4])
def test_a_circle_goes_through_the_wrists_singularity_as_well(through, gammas, rate):
    """There q4 and q6 are quotients of roundings: they must not turn by a million radians."""
    begin, end = GAMMAS[gammas]
    touch = (*SECOND[through], 0.0, 0.0)
    path = Circle(through, touch, radius=0.15, rate=rate, begin=begin, end=end)
    for kind, settings in ((Esc, EscSettings()), (LookAhead, LookAheadSettings())):
        plan = fast(kind(settings, ArmGeometry(), 5e-3), path)
        assert plan.duration == pytest.approx((end - begin) / rate, abs=0.05)
        limits = ArmGeometry()
        assert (plan.rates / np.array(limits.rate_limits)).max() < 0.4
        circle = CircularTrajectory(ARM, path)
        for q, place in zip(plan.positions[::7], plan.path[::7], strict=True):
            at, turn = hand_of(limits, q)
            assert np.linalg.norm(at - place) < 1e-9
            assert np.linalg.norm(turn.as_matrix() - np.array(circle.pose(0.0).rotation)) < 1e-8


@pytest.mark.parametrize("through", SECOND)
@pytest.mark.parametrize("miss", [1e-5, 1e-3])
def test_a_circle_misses_the_wrists_singularity(through, miss):
    """Known ahead it takes the time that q4 needs; at full speed it is refused with that rate."""
    path = Circle(through, (*SECOND[through], miss, 0.0), radius=0.15, rate=0.4)
    path = dataclasses.replace(path, begin=-1.5, end=1.5)
    plan = fast(LookAhead(LookAheadSettings(), ArmGeometry(), 5e-3), path)
    assert plan.duration == pytest.approx(7.5 + math.pi / 2, rel=0.02)
    assert (plan.rates / np.array(ArmGeometry().rate_limits)).max() < 1.001
    for q, place in zip(plan.positions, plan.path, strict=True):
        assert np.linalg.norm(hand_of(ArmGeometry(), q)[0] - place) < 1e-7
    with pytest.raises(InfeasibleMotion, match=r"q[46] would need \d\S+ rad/s, beyond its limit"):
        fast(Esc(EscSettings(), ArmGeometry(), 5e-3), path)


def test_a_motion_that_would_take_too_long_is_refused_before_it_is_sampled():
    path = Circle(rate=1e-4)
    law = LookAhead(LookAheadSettings(), ArmGeometry(), 5e-3)
    with pytest.raises(InfeasibleMotion, match="takes at least"):
        fast(law, path)


def test_a_circle_needs_an_arm_without_shoulder_offset():
    with pytest.raises(InfeasibleMotion, match=r"0\.05 m"):
        follow(ELBOW_CIRCLE, shoulder_offset=0.05)
    with pytest.raises(InfeasibleMotion, match="no less than the reach"):
        follow(Circle(radius=0.8))
    with pytest.raises(InfeasibleMotion, match="cannot be begun"):
        follow(Circle("shoulder", (0, 0, 0.4, 0.5, -0.8, 0), radius=0.3))


def test_the_poses_are_those_of_the_twist():
    h = 1e-6
    for path in (ELBOW_CIRCLE, SHOULDER_CIRCLE):
        trajectory = CircularTrajectory(ARM, path)
        for t in (0.5, 2.0, 4.0):
            ahead, behind = trajectory.pose(t + h).position, trajectory.pose(t - h).position
            linear = np.subtract(ahead, behind) / (2 * h)
            np.testing.assert_allclose(trajectory.twist(t).linear, linear, atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("begins", [True, False])
def test_a_circle_that_ends_or_begins_in_the_singularity_crosses_there_or_nowhere(seed, begins):
    """The rounded elbow has a sign there and no rate: Newton's method divided by zero."""
    rng = np.random.default_rng((47, seed))
    scale = rng.uniform(0.03, 1.0)
    way = rng.uniform(0.1, 0.6)
    path = Circle(
        touch=(rng.uniform(-3, 3), rng.uniform(-0.8, 0.8), 0.0, -1.0, 0.5, 0.0),
        radius=rng.uniform(0.05, 0.3) * scale, side=int(rng.choice((-1, 1))), rate=0.4,
        begin=0.0 if begins else -way, end=way if begins else 0.0,
    )  # fmt: skip
    links = {"a2": 0.4 * scale, "a3": 0.48 * scale, "d6": 0.08 * scale}
    plan = follow(path, period=5e-3, rate_limits=(1.0,) * 3 + (2.0,) * 3, **links)
    at = 0.0 if begins else plan.duration
    assert all(abs(t - at) <= 5e-3 for t in plan.crossings)
