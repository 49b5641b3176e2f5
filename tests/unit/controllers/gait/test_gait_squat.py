"""Knee bends from both knees straight, where the literal equation of both legs stands still."""

import numpy as np
import pytest
from gait_laws import LAWS

from controllers.gait.geometry import KNEES, LegGeometry
from controllers.gait.motions import SquatSettings
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase
from controllers.gait.types import GaitModel
from controllers.motion import InfeasibleMotion


@pytest.mark.parametrize("law", [law.name for law in LAWS])
def test_squat_starts_and_ends_with_straight_knees(plan, law):
    made = plan(law, "squat")
    assert made.duration == pytest.approx(12.0)
    np.testing.assert_allclose(made.q[[0, -1]], 0.0, atol=1e-7)
    depth = np.ptp(made.odometry()[:, 2])
    assert depth == pytest.approx(0.040, abs=1e-9)
    right, left = (made.q[:, knee] for knee in KNEES)
    np.testing.assert_allclose(right, left, atol=1e-9)
    # q4 = 2 acos((2 L - depth) / 2 L)
    assert np.degrees(right.max()) == pytest.approx(2 * np.degrees(np.arccos(0.8)), abs=1e-6)
    assert made.mismatch() < 1e-10


def test_knee_rates_stay_bounded_only_by_the_joints_length(plan):
    rates = {law.name: plan(law.name, "squat").peak_knee_rate for law in LAWS}
    assert rates["sc-trapezoid"] < rates["sc"] < 1.0 < rates["inverse"] / 5.0


def test_straight_legs_start_by_bending_both_knees_alike():
    geometry = LegGeometry()
    curve = PhaseCurve(geometry, SquatSettings().phases(geometry)[0], 1e-3)
    assert curve.rates()[1] == 0.0
    curve.follow_joints(1e-4)
    knees = curve.joints[KNEES[0]], curve.joints[KNEES[1]]
    assert knees[0] == pytest.approx(knees[1], rel=1e-9)
    assert knees[0] > 0.0
    assert curve.path > 0.0


def test_unequal_straight_legs_start_at_the_rates_that_keep_them_together():
    """One foot ahead: both legs straight, the demands differ, and so do the first rates."""
    geometry = LegGeometry()
    ahead = 0.03
    height = float(np.sqrt(geometry.reach**2 - ahead**2)) + geometry.ankle_height
    spacing = geometry.hip_half_spacing
    # Right hip above its ankle and a little lower foot, so that both are exactly at full reach.
    lower = height - geometry.ankle_height - geometry.reach
    feet = ((0.0, -spacing, lower), (ahead, spacing, 0.0))
    phase = SquatSettings().phases(geometry)[0]
    phase = phase._replace(waist=(0.0, 0.0, height), feet=feet, waist_travel=(0.03, 0.0, -0.02))
    curve = PhaseCurve(geometry, phase, 1e-3)
    for _ in range(400):
        curve.follow_joints(5e-4)
    np.testing.assert_allclose(curve.joints, curve.joints_at(curve.path), atol=1e-7)
    right, left = (curve.joints[knee] for knee in KNEES)
    assert right != pytest.approx(left, rel=0.05)


def test_straight_leg_without_demand_does_not_stop_the_other():
    """The literal equation of both legs would multiply everything by its zero determinant."""
    geometry = LegGeometry()
    spacing = geometry.hip_half_spacing
    phase = GaitPhase(
        name="swing right",
        duration=1.0,
        standing=(False, True),
        waist=(0.0, 0.0, geometry.reach + geometry.ankle_height),
        waist_travel=(0.0, 0.0, 0.0),
        feet=((0.0, -spacing, 0.001), (0.0, spacing, 0.0)),
        lift=0.03,
    )
    curve = PhaseCurve(geometry, phase, 1e-3)
    standing = curve.joints[6:]
    assert standing[3] == 0.0
    for _ in range(500):
        curve.follow_joints(1e-3)
    assert curve.path > 0.05
    assert curve.joints[6:] == standing
    np.testing.assert_allclose(curve.joints, curve.joints_at(curve.path), atol=1e-9)


def test_law_that_would_leave_the_reach_is_refused():
    kind = LAWS[2]
    law = kind(kind.Settings(), GaitModel(), 5e-3)
    geometry = LegGeometry()
    top, bottom = SquatSettings().phases(geometry)[:2]
    with pytest.raises(InfeasibleMotion, match=r"^up 1, 97\.6 % of the way: the hip"):
        higher = bottom._replace(waist_travel=(0.0, 0.0, 0.041))
        law.prepare(_Given((top, higher)))


class _Given:
    """A motion of given phases."""

    speed = 1.0

    def __init__(self, phases):
        self._phases = phases

    def phases(self, geometry):
        return self._phases
