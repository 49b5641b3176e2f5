"""Turning back at the boundary: the paper's Fig. 4 as numbers, and what the paper leaves out."""

import math
from dataclasses import replace

import numpy as np
import pytest
from arm_cases import START_FIG4, radians
from drawn_cases import hand_of

from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import TurnBack
from controllers.arm.region import (
    elbow_scale,
    region_for_acceleration,
    region_for_speed,
    region_for_twist,
    turn_back_scale,
)
from controllers.motion import InfeasibleMotion


def paper(path, period=1e-2, **geometry):
    return EscPaper(EscPaperSettings(), ArmGeometry(**geometry), period).prepare(path)


DEFAULTS = EscSettings()


def ours(path, period=1e-2, settings=DEFAULTS, **geometry):
    return Esc(settings, ArmGeometry(**geometry), period).prepare(path)


WIDE = {"position_min": (-20.0,) * 6, "position_max": (20.0,) * 6}
FAST = {"rate_limits": (10.0,) * 6}
# name: path, geometry, region in and out, crossing, end, peaks, reach, turned
FIG4 = {
    "+1": (
        TurnBack(),
        {},
        (4.77617, 6.08379),
        5.428940,
        10.858265,
        (0.0158, 0.4930, 0.99855, 1.1541, 0.3924, 1.1571),
        0.365151,
        0.718657,
    ),
    "-1": (
        TurnBack(),
        {"wrist_sign": -1},
        (4.78209, 6.08919),
        5.434136,
        10.868828,
        (0.0309, 0.4932, 0.99903, 0.1771, 0.3690, 0.3551),
        0.365528,
        0.719415,
    ),
    "fast turning": (
        TurnBack(turn_rate=0.7),
        {"wrist_sign": -1, **WIDE},
        (4.38061, 5.72123),
        5.055218,
        10.108790,
        (0.1768, 0.4773, 0.9648, 1.6135, 0.5723, 1.2058),
        0.338423,
        6.648333,
    ),
}


@pytest.mark.parametrize("case", FIG4.values(), ids=FIG4)
def test_figure_4(case):
    path, geometry, region, crossing, end, peaks, reach, turned = case
    plan = paper(path, **geometry)
    np.testing.assert_allclose(plan.marks["region"], region, atol=2e-4)
    assert plan.crossings == pytest.approx((crossing,), abs=2e-4)
    assert plan.duration == pytest.approx(end, abs=2e-4)
    np.testing.assert_allclose(plan.peak_rates, peaks, atol=1e-3)
    along = plan.hand[:, 0] - plan.hand[0, 0]
    assert along.max() == pytest.approx(reach, abs=1e-5)
    assert along[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.sum(plan.scale[:-1, 1]) * plan.period * path.turn_rate == pytest.approx(
        turned, rel=2e-3
    )


def test_figure_4_at_its_ends_and_its_crossing():
    plan = paper(TurnBack(), period=1e-3)
    end = np.degrees(plan.positions[-1])
    np.testing.assert_allclose(
        end, (-3.04272, 139.07184, -114.48823, 171.73904, -86.90965, -118.83852), atol=2e-3
    )
    crossing = [np.interp(plan.crossings[0], plan.t, q) for q in plan.positions.T]
    np.testing.assert_allclose(
        np.degrees(crossing),
        (-0.64973, 86.97179, 0.0, 137.09365, -25.85053, -98.52248),
        atol=1e-3,
    )
    assert np.interp(plan.crossings[0], plan.t, plan.velocities[:, 2]) == pytest.approx(
        -0.998539, abs=1e-5
    )
    assert plan.peak_accelerations[2] == pytest.approx(0.748, abs=1e-3)
    assert (plan.velocities[:-1, 2] < 0.0).all()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("law", [paper, ours])
def test_nothing_leaves_the_line_the_command_or_the_limits(law, sign):
    plan = law(TurnBack(), wrist_sign=sign)
    assert plan.path_deviation < 1e-9
    assert plan.twist_residual < 1e-12
    assert np.ptp(plan.hand[:, 1:], axis=0).max() < 1e-9
    assert np.abs(plan.twist[:, 4:]).max() < 1e-12, "it turns about x alone"
    assert (plan.twist[:-1, 3] >= 0.0).all(), "and in one sense"
    entered, left = plan.marks["region"]
    outside = (plan.t < entered) | ((plan.t > left) & (plan.t < plan.duration))
    outside[-1] = False
    np.testing.assert_allclose(np.abs(plan.twist[outside, 0]), 0.07, atol=1e-14)
    assert len(plan.crossings) == 1
    assert plan.peak_rates[2] <= 1.0


def test_time_scales_with_speeds_and_limits():
    slow, fast = paper(TurnBack()), paper(TurnBack(speed=0.7, turn_rate=0.7), 1e-3, **FAST)
    assert 10.0 * fast.duration == pytest.approx(slow.duration, abs=1e-6)
    np.testing.assert_allclose(fast.peak_rates, 10.0 * slow.peak_rates, rtol=1e-5)


def test_the_printed_speed_is_refused_with_the_rate_that_would_do():
    with pytest.raises(InfeasibleMotion, match=r"5\.3173, more than 1.*at least 5\.3174 rad/s"):
        paper(TurnBack(speed=0.7, turn_rate=0.7))
    with pytest.raises(InfeasibleMotion, match=r"more than 1"):
        ours(TurnBack(speed=0.7, turn_rate=0.7))


@pytest.mark.parametrize("speed", [0.05, 0.07, 0.12])
def test_the_region_is_as_wide_as_equation_13_says(speed):
    geometry = ArmGeometry()
    radial = TurnBack(touch=radians(0, 60, 0, 0, 40, 0), direction=RADIAL, speed=speed, turn_rate=0)
    plan = paper(radial, period=2e-3)
    sin_qs = region_for_speed(geometry, speed)
    assert sin_qs == pytest.approx(1.5 * 0.79 / 0.156 * speed)
    assert plan.peak_rates[2] == pytest.approx(1.0, abs=1e-4), "on a radial line eq. (13) is exact"


RADIAL = (math.sin(math.radians(60)), 0.0, math.cos(math.radians(60)))


@pytest.mark.parametrize(
    "axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)]
)
def test_a_turning_tool_needs_a_wider_region(axis):
    geometry = ArmGeometry()
    path = TurnBack(axis=axis, turn_rate=0.5)
    plan = ours(path, **WIDE)
    assert plan.peak_rates[2] <= 1.0
    assert region_for_twist(geometry, 0.07, 0.5) > region_for_speed(geometry, 0.07)
    assert region_for_twist(geometry, 0.07, 0.0) == pytest.approx(region_for_speed(geometry, 0.07))


def test_without_that_width_a_turning_tool_breaks_the_limit():
    peaks = [
        paper(TurnBack(axis=axis, turn_rate=0.5), **WIDE).peak_rates[2]
        for axis in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    ]
    assert max(peaks) > 1.3


def test_the_region_keeps_the_acceleration_limit():
    limits = (10.0, 10.0, 0.5, 20.0, 20.0, 20.0)
    geometry = ArmGeometry(acceleration_limits=limits)
    assert region_for_acceleration(geometry, 0.07) == pytest.approx(
        (0.3545**2 / 0.5) ** (1 / 3), abs=1e-4
    )
    path = TurnBack(touch=radians(0, 60, 0, 0, 40, 0), direction=RADIAL, turn_rate=0.0)
    wide = ours(path, 1e-3, acceleration_limits=limits)
    narrow = ours(path, 1e-3, EscSettings(limit_acceleration=False), acceleration_limits=limits)
    assert wide.peak_accelerations[2] < 0.5 < narrow.peak_accelerations[2]


def test_the_scale_is_odd_smooth_and_one_outside():
    for sin_qs in (0.2, 0.9):
        b, per_elbow = turn_back_scale(0.0, sin_qs)
        assert (b, per_elbow) == (0.0, pytest.approx(1.5 / sin_qs))
        assert turn_back_scale(sin_qs, sin_qs)[0] == pytest.approx(1.0)
        slope = turn_back_scale(sin_qs, sin_qs)[0] - turn_back_scale(sin_qs - 1e-7, sin_qs)[0]
        assert abs(slope) < 1e-12
        for s3 in (0.1, 0.15, 0.95):
            assert turn_back_scale(-s3, sin_qs)[0] == -turn_back_scale(s3, sin_qs)[0]


def test_the_folded_arm_is_not_slowed():
    assert elbow_scale(math.radians(115), 0.95, 1.0).linear == 1.0
    assert elbow_scale(math.radians(65), 0.95, 1.0).linear < 1.0


def other_elbow():
    """Return the joints of Fig. 4's start with the elbow on the other side."""
    from controllers.arm.inverse import Branch, branch_of, inverse
    from controllers.arm.kinematics import dimensions_of, forward

    arm = dimensions_of(ArmGeometry())
    branch = branch_of(arm, START_FIG4)
    other = Branch(branch.shoulder, -branch.elbow, branch.wrist)
    return inverse(arm, forward(arm, START_FIG4), other)


def test_the_other_elbow_goes_the_same_way_in_the_same_time():
    start = other_elbow()
    assert start[2] < 0.0
    plan = ours(TurnBack(start=start))
    along = plan.hand[:, 0] - plan.hand[0, 0]
    assert along.min() > -1e-9
    assert along.max() > 0.36
    assert len(plan.crossings) == 1
    mirrored = ours(TurnBack(turn_rate=0.0)).duration
    assert ours(TurnBack(start=start, turn_rate=0.0)).duration == pytest.approx(mirrored, abs=1e-6)


def test_the_papers_law_refuses_the_other_elbow_rather_than_go_backwards():
    with pytest.raises(InfeasibleMotion, match="against its command"):
        paper(TurnBack(start=other_elbow()))


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (TurnBack(travel=0.2), r"within 0\.2 m"),
        (TurnBack(start=radians(0, 60, 20, 30, -50, 0)), r"inside the region: \|S3\| = 0\.3420"),
        (TurnBack(start=radians(0, 90, 0, 30, -50, 0), direction=(0, 0, 1)), "tangential"),
        (TurnBack(start=radians(0, 90, 0, 30, -50, 0)), "at the elbow's singularity"),
        (
            TurnBack(start=START_FIG4, direction=(-0.423695, 0.0, -0.026941), turn_rate=0.0),
            "the line meets the inner boundary",
        ),
    ],
)
@pytest.mark.parametrize("law", [paper, ours])
def test_what_cannot_be_done_is_refused(law, path, message):
    with pytest.raises(InfeasibleMotion, match=message):
        law(path)


@pytest.mark.parametrize("law", [paper, ours])
def test_no_speed_is_named_where_no_speed_is_slow_enough(law):
    """At S5 = 0 q6 would have to jump at any speed; that the region is too narrow comes second."""
    start = (-1.412, -2.738, 2.19, 1.048, 0.0, -2.493)
    path = TurnBack(start=start, direction=(0.54, 1.79, -1.59), speed=0.2,
                    axis=(-0.85, -0.29, -0.3), turn_rate=-0.183)  # fmt: skip
    tame = {"rate_limits": (1.49,) * 6}
    with pytest.raises(InfeasibleMotion, match=r"wrist's singularity \(S5 = 0\)"):
        law(path, **tame)


def test_a_joint_limit_on_the_path_is_named_with_its_time():
    lower = (-3.2, -3.2, -1.0, -7.0, -3.0, -7.0)
    with pytest.raises(InfeasibleMotion, match=r"after \d+\.\d+ s q3 would be at -57\.\d+ deg"):
        paper(TurnBack(), position_min=lower)


@pytest.mark.parametrize(
    "geometry",
    [
        {"a2": 0.4, "a3": 0.4},
        {"a2": 0.45, "a3": 0.3, "elbow_offset": 0.05, "base_height": 0.4},
        {"shoulder_offset": 0.06, "wrist_sign": -1},
    ],
)
def test_other_arms_turn_back_as_well(geometry):
    plan = ours(TurnBack(), **geometry)
    assert len(plan.crossings) == 1
    assert plan.path_deviation < 1e-9
    assert plan.twist_residual < 1e-12
    assert (plan.peak_rates <= ArmGeometry().rate_limits).all()


def test_wrist_and_elbow_together():
    radial = TurnBack(touch=radians(0, 60, 0, 0, 0, 0), direction=(1.0, 0.0, 0.3), turn_rate=0.0)
    plan = ours(radial)
    s3, s5 = plan.indices[:, 1], plan.indices[:, 2]
    middle = np.argmin(np.abs(s3))
    assert abs(s5[middle]) < 0.01
    assert s5[0] * s5[-1] < 0.0
    assert len(plan.crossings) == 1
    assert plan.outcome == "done"
    assert plan.path_deviation < 1e-9
    beside = TurnBack(touch=radians(0, 60, 0, 30, 1, 0), direction=(1.0, 0.0, 0.3), turn_rate=0.02)
    plan = ours(beside)
    assert plan.outcome == "done"
    assert (plan.peak_rates <= ArmGeometry().rate_limits).all()
    assert plan.path_deviation < 1e-8


STALLS = ArmGeometry(
    **WIDE,
    a2=0.5915429488170001,
    a3=0.88972136692,
    d6=0.259185300049,
    rate_limits=(6.91225, 2.61042, 4.33309, 1.00962, 3.86569, 0.765787),
    acceleration_limits=(34.5612, 13.0521, 21.6655, 5.0481, 19.3285, 3.82894),
)
STALLING = TurnBack(
    start=(
        -2.555566983967113, 1.5213445854532563, 0.39859510646301777,
        -1.2175515177815763, 0.435775033481256, 2.561569501805403,
    ),
    direction=(-0.5486536121637022, 1.5759290046815946, 0.937904739170218),
    speed=0.05458979304349299,
    axis=(2.139916132360379, -0.5781021044800462, 0.5542365518397604),
    turn_rate=0.4259791770918002,
)  # fmt: skip
"""A drawn arm and line: the tool's turning brings the wrist to the boundary across the line."""


def test_look_ahead_leaves_no_half_of_a_line_out_that_esc_does_not_turn_back_on():
    """The hand was done there, 0.568 m away."""
    with pytest.raises(InfeasibleMotion, match=r"esc, which stalls 0\.568 m from the start"):
        LookAhead(LookAheadSettings(), STALLS, 5e-3).prepare(STALLING)


@pytest.mark.parametrize("width", [0.1236, 0.2, 0.3, 0.38])
def test_where_esc_stalls_its_own_twist_comes_to_rest_whatever_the_regions_width(width):
    """So it cannot pass there and keep its promise of the twist (b v, b^2 w).

    About S3 = 0 and the radial speed 0 the rates of both are linear: fitted to the plan's samples,
    their matrix has a negative trace and a positive determinant, and so attracts from all sides.
    """
    plan = Esc(EscSettings(elbow_region=width), STALLS, 5e-3).prepare(STALLING)
    assert plan.outcome == "stalls"
    way = np.array(STALLING.direction) / np.linalg.norm(STALLING.direction)
    tool = np.array([0.0, 0.0, STALLS.d6])

    def radial(q):
        hand, turn = hand_of(STALLS, q)
        wrist = hand - turn @ tool - np.array([0.0, 0.0, STALLS.base_height])
        return way @ wrist / np.linalg.norm(wrist)

    states = np.array([(math.sin(q[2]), radial(q)) for q in plan.positions[:-1]])
    rates = np.gradient(states, 5e-3, axis=0)
    near = (np.abs(states) < 2e-2).all(axis=1) & (np.abs(states[:, 0]) > 1e-6)
    assert near.sum() > 1000
    matrix = np.linalg.lstsq(states[near], rates[near], rcond=None)[0].T
    assert np.trace(matrix) < -0.2
    assert np.linalg.det(matrix) > 0.05
    assert np.linalg.eigvals(matrix).real.max() < -0.1


def test_a_tool_that_does_not_turn_passes_where_esc_stalls():
    plan = Esc(EscSettings(), STALLS, 5e-3).prepare(replace(STALLING, turn_rate=0.0))
    assert plan.outcome == "done"
    assert len(plan.crossings) == 1
