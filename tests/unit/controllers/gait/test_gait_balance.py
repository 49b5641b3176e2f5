"""Centre of mass and zero-moment point against the edge of the support."""

import math

import numpy as np
import pytest

from controllers.gait.balance import (
    GRAVITY,
    LinkCentres,
    link_centres,
    margin,
    standing_knee_torque,
    support_polygon,
    zero_moment_point,
)
from controllers.gait.geometry import LegGeometry
from controllers.gait.laws import InverseLaw, MinimumJerkLaw, TrapezoidNormLaw
from controllers.gait.leg_postures import leg_posture
from controllers.gait.motions import WalkSettings
from controllers.gait.types import BalanceSettings, GaitModel
from controllers.motion import InfeasibleMotion

GEOMETRY = LegGeometry()
FEET = ((0.0, -0.039, 0.0), (0.04, 0.039, 0.0))


def test_support_of_one_foot_is_its_sole():
    polygon = support_polygon(GEOMETRY, FEET, (False, True))
    assert len(polygon) == 4
    points = np.array([(0.04, 0.039), (0.04 + 0.0582, 0.039), (0.0, 0.039)])
    # Centred across; on the toe; 4.2 mm behind the heel.
    assert margin(polygon, points) == pytest.approx((0.031, 0.0, -0.0042))


def test_support_of_both_feet_is_the_hull():
    polygon = support_polygon(GEOMETRY, FEET, (True, True))
    assert len(polygon) == 6
    # 10 mm out from the middle of the edge between the right foot's outer toe and the left's inner.
    toes = np.array((0.0582, -0.07)), np.array((0.0982, 0.008))
    across = np.array((0.078, -0.04)) / np.hypot(0.078, 0.04)
    middle = 0.5 * (toes[0] + toes[1])
    points = np.array([middle + 0.01 * across, toes[0], middle - 0.01 * across])
    assert margin(polygon, points) == pytest.approx((-0.01, 0.0, 0.01), abs=1e-12)


def test_zero_moment_point_of_a_cart_on_a_table():
    """One mass at height z with acceleration a: it leans back by a z / g."""
    period, acceleration, height = 1e-3, 0.5, 0.24
    t = period * np.arange(400)
    x = 0.5 * acceleration * t**2
    positions = np.stack((x, 0.0 * t, np.full_like(t, height)), axis=1)[:, None, :]
    links = LinkCentres(np.array([6.0]), positions)
    point = zero_moment_point(links, period, 0.02)
    inside = slice(50, 350)
    expected = x[inside] - acceleration * height / GRAVITY
    np.testing.assert_allclose(point[inside, 0], expected, atol=1e-12)
    np.testing.assert_allclose(point[inside, 1], 0.0, atol=1e-15)


def test_resting_robot_has_its_zero_moment_point_under_its_centre():
    q = np.tile((0.0, 0.0, -0.3, 0.6, -0.3, 0.0) * 2, (5, 1))
    links = link_centres(GEOMETRY, q, np.zeros((5, 3)))
    point = zero_moment_point(links, 1e-3, 0.1)
    np.testing.assert_allclose(point, links.centre[:, :2], atol=1e-15)
    assert links.masses.sum() == pytest.approx(GEOMETRY.masses.total)


@pytest.mark.parametrize("law", ["inverse", "sc", "sc-trapezoid", "min-jerk"])
def test_margin_of_the_base_case(plan, law):
    made = plan(law)
    assert made.static_margin == pytest.approx(22.1e-3, abs=0.2e-3)
    assert made.margin == pytest.approx(22.0e-3, abs=0.2e-3)


def test_margin_is_least_while_one_foot_stands(plan):
    made = plan("sc-trapezoid")
    worst = made.phases[made.phase_number[np.argmin(made.balance.static_margin)]]
    assert worst.phase.standing != (True, True)
    # The swinging leg pulls the centre of mass inwards, 9 mm off the sole's middle.
    centred = [made.balance.static_margin[round(t / 1e-3)] for t in (15.0, 30.0)]
    assert min(centred) > 30e-3


def test_more_sway_centres_the_robot_over_its_foot():
    law = TrapezoidNormLaw(TrapezoidNormLaw.Settings(), GaitModel(), 5e-3)
    assert law.prepare(WalkSettings(sway=1.3)).static_margin == pytest.approx(30.6e-3, abs=0.3e-3)


def test_plan_out_of_balance_is_refused_with_the_instant():
    law = InverseLaw(InverseLaw.Settings(), GaitModel(), 5e-3)
    with pytest.raises(InfeasibleMotion, match=r"^at \d+\.\d+ s \(swing .*\) the centre of mass"):
        law.prepare(WalkSettings(sway=0.2))
    with pytest.raises(
        InfeasibleMotion, match=r"moment point would be \d\S* mm outside .* is 5 mm inside"
    ):
        law.prepare(WalkSettings(speed=10.0))


def test_bound_comes_from_the_profile():
    strict = GaitModel(GEOMETRY, BalanceSettings(min_margin=25e-3))
    law = TrapezoidNormLaw(TrapezoidNormLaw.Settings(), strict, 5e-3)
    with pytest.raises(InfeasibleMotion, match=r"22\.\d mm inside .* the bound is 25 mm"):
        law.prepare(WalkSettings())


def test_fastest_walk_that_keeps_the_margin():
    durations = {}
    for kind in (TrapezoidNormLaw, MinimumJerkLaw):
        law = kind(kind.Settings(), GaitModel(), 5e-3)
        made = law.prepare(WalkSettings(speed=4.0, fastest=True))
        assert 5.0e-3 <= made.margin < 6.5e-3
        durations[kind.name] = made.duration
        with pytest.raises(InfeasibleMotion, match="zero-moment point"):
            law.prepare(WalkSettings(speed=48.0 / made.duration * 1.03))
    assert durations["sc-trapezoid"] == pytest.approx(5.25, abs=0.1)
    assert durations["min-jerk"] == pytest.approx(5.9, abs=0.2)


def test_pose_to_hold_is_the_nearest_that_stands_safely(plan):
    made = plan("sc-trapezoid")
    assert made.nearest_stable(20.0, 5e-3) == pytest.approx(20.0)
    held = made.nearest_stable(20.0, 30e-3)
    assert 0.0 < 20.0 - held < 3.0
    assert made.balance.static_margin[round(held / 1e-3)] >= 30e-3
    with pytest.raises(ValueError, match=r"at no instant .* 90 mm inside"):
        made.nearest_stable(20.0, 90e-3)


def test_standing_knee_bears_what_is_above_it(plan):
    """A hanging shank, ankle and foot apart, the torque is the weight times its lever."""
    made = plan("sc-trapezoid")
    sample = round(22.5 / 1e-3)  # the left leg swings
    q, waist = made.q[sample : sample + 1], made.waist[sample : sample + 1]
    torque = standing_knee_torque(GEOMETRY, 0, q, waist)
    masses = GEOMETRY.masses
    below = masses.shank + masses.ankle + masses.foot
    knee = leg_posture(GEOMETRY, 0, q).knee[0] + waist[0]
    links = link_centres(GEOMETRY, q, waist)
    others = [k for k in range(11) if k not in (3, 4, 5)]
    centre = links.masses[others] @ links.positions[0, others] / links.masses[others].sum()
    roll = q[0, 5]
    ahead, aside = (centre - knee)[:2]
    lever = ahead * np.cos(roll)  # the knee's axis leans with the leg; aside counts for nothing
    weight = GRAVITY * (masses.total - below)
    assert torque[0] == pytest.approx(weight * lever, rel=1e-9)
    assert aside != 0.0


def test_standing_knee_bears_less_the_straighter_it_is():
    law = TrapezoidNormLaw(TrapezoidNormLaw.Settings(), GaitModel(), 5e-3)
    torques = []
    for degrees in (1.0, 10.0, 20.0, 30.0, 40.0):
        made = law.prepare(WalkSettings(knee_min=math.radians(degrees)))
        swings = [planned for planned in made.phases if sum(planned.phase.standing) == 1]
        torques.append(
            np.mean(
                np.concatenate(
                    [
                        np.abs(
                            standing_knee_torque(
                                GEOMETRY,
                                planned.phase.standing.index(True),
                                made.q[planned.first : planned.last],
                                made.waist[planned.first : planned.last],
                            )
                        )
                        for planned in swings
                    ]
                )
            )
        )
    assert torques == pytest.approx((0.68, 0.76, 0.97, 1.25, 1.56), rel=0.03)


@pytest.mark.parametrize("motion", ["walk", "walk 5x", "walk with bob"])
def test_every_instant_of_a_plan_is_one_to_hold(plan, motion):
    """So the safe instant that is nearest to a fault is the one that it happens at."""
    made = plan("sc-trapezoid", motion, 5e-3)
    bound = made.static_margin
    assert bound >= 21.9e-3
    for t in made.t[::100].tolist():
        assert made.nearest_stable(t, bound) == t
