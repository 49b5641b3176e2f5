"""What the singularity-consistent law is compared with leaves the path; it does not."""

import numpy as np
import pytest

from controllers.gait.clamped_and_damped import ClampedLaw, DampedGaitSettings, DampedLaw
from controllers.gait.footprints import StepNumbers
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import KNEES, LegGeometry
from controllers.gait.laws import LimitedNormLaw, LimitedNormSettings, TrapezoidNormLaw
from controllers.gait.mink_rival import MinkLaw, MinkSettings
from controllers.gait.motions import WalkSettings
from controllers.gait.per_leg import PerLegLaw, PerLegSettings
from controllers.gait.types import BalanceSettings, GaitModel
from controllers.motion import InfeasibleMotion

GEOMETRY = LegGeometry()
MODEL = GaitModel(GEOMETRY, BalanceSettings(min_margin=1e-6, response_time=1.0))
FAST = WalkSettings(speed=5.0, landings=1)


def test_clamped_joints_tear_the_waist_between_the_feet():
    made = ClampedLaw(ClampedLaw.Settings(), MODEL, 1e-3).prepare(FAST)
    assert made.peak_rates.max() == pytest.approx(GEOMETRY.max_rate)
    assert made.mismatch() > 2e-3
    assert made.off_path > 1e-3


@pytest.mark.parametrize(("damping", "mismatch"), [(0.01, 0.005e-3), (0.05, 0.05e-3)])
def test_damping_trades_rates_for_the_path(damping, mismatch):
    law = DampedLaw(DampedGaitSettings(damping), MODEL, 2e-3)
    made = law.prepare(FAST)
    plain = 19.0  # at this period
    assert 4.0 < made.peak_knee_rate < 0.8 * plain
    assert made.mismatch() > mismatch
    assert np.degrees(made.q[:, list(KNEES)].min()) > 1.2


def test_singularity_consistent_law_stays_on_the_path():
    law = TrapezoidNormLaw(TrapezoidNormLaw.Settings(), MODEL, 1e-3)
    made = law.prepare(FAST)
    assert made.off_path < 1e-9
    assert made.mismatch() < 1e-9
    assert made.peak_knee_rate < 1.3


def test_rivals_online_are_their_plans():
    law = DampedLaw(DampedGaitSettings(), MODEL, 5e-3)
    made = law.prepare(FAST)
    for sample in range(len(made.t)):
        command = law.update(None, made.at(0.0))
        np.testing.assert_array_equal(command.positions, made.q[sample])


def test_mink_keeps_the_rates_and_leaves_the_path():
    pytest.importorskip("mink")
    pytest.importorskip("daqp")
    made = MinkLaw(MinkSettings(), MODEL, 2e-3).prepare(FAST)
    assert made.peak_rates.max() <= GEOMETRY.max_rate * (1.0 + 1e-6)
    assert made.off_path > 0.05e-3


def test_mink_says_what_is_not_installed():
    with pytest.raises(
        InfeasibleMotion, match=r"needs the package (mink|no_such_solver), which is not installed"
    ):
        MinkLaw(MinkSettings(solver="no_such_solver"), MODEL, 2e-3)


def test_legs_on_their_own_tear_the_waist_where_one_system_does_not():
    model = GaitModel(GEOMETRY, BalanceSettings(min_margin=1e-6, response_time=1.0))
    one = LimitedNormLaw(LimitedNormSettings(), model, 5e-3).prepare(WalkSettings(landings=2))
    law = PerLegLaw(PerLegSettings(), model, 5e-3)
    made = law.prepare(WalkSettings(landings=2))
    assert one.mismatch() < 1e-9
    assert 3e-3 < made.mismatch() < 6e-3  # 4.31 mm where the paper's notes have it
    assert made.peak_rates.max() <= GEOMETRY.max_rate
    np.testing.assert_allclose(made.q[-1], one.q[-1], atol=1e-9)
    # Where one leg alone moves nothing is torn.
    swing = made.phases[1]
    np.testing.assert_allclose(made.q[swing.first, :6], one.q[swing.first, :6], atol=1e-9)


def test_law_of_each_leg_runs_as_it_was_planned():
    law = PerLegLaw(PerLegSettings(), MODEL, 5e-3)
    made = law.prepare(FAST)
    for sample in range(len(made.t)):
        command = law.update(None, made.at(0.0))
        np.testing.assert_array_equal(command.positions, made.q[sample])


@pytest.mark.parametrize("law", ["damped", "mink", "clamped"])
def test_rivals_follow_a_walk_that_turns(law):
    if law == "mink":
        pytest.importorskip("mink")
        pytest.importorskip("daqp")
    kind = {"damped": DampedLaw, "mink": MinkLaw, "clamped": ClampedLaw}[law]
    walk = FootstepsSettings(numbers=StepNumbers(count=2, turn=0.15), knee_min=0.5)
    made = kind(kind.Settings(), MODEL, 2e-2).prepare(walk)
    assert made.mismatch() < 2e-3
    assert made.off_path < 2e-3
