"""What is said of a walk that asks a joint for more than it can do, before anything moves."""

import re

import pytest

from controllers.gait.footprints import Footstep
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.laws import LimitedNormLaw, LimitedNormSettings, MinimumJerkLaw, NoSettings
from controllers.gait.motions import SquatSettings
from controllers.gait.types import GaitModel
from rig.mechanisms.legs.remarks import remarks_of_plan, remarks_on_jumps


def squat(max_rate, speed):
    """Return a squat's plan by the rival that bounds no rates."""
    law = MinimumJerkLaw(NoSettings(), GaitModel(LegGeometry(max_rate=max_rate)), 1e-3)
    return law.prepare(SquatSettings(speed=speed))


def test_a_walk_that_keeps_the_rates_needs_no_words():
    assert remarks_of_plan(squat(4.76, 1.0)) == ()


@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_the_joint_the_instant_and_the_speed_that_fits_are_told(speed):
    plan = squat(4.76, speed)
    limit = 0.4 * float(plan.peak_rates.max())
    (note,) = remarks_of_plan(squat(limit, speed))
    at, joint, peak, share = re.search(
        r"after (\S+) s (\w+) would need (\S+) rad/s.* at (\S+) times", note.message
    ).groups()
    rates = plan.q_dot[:, AXIS_NAMES.index(joint)]
    assert float(peak) == pytest.approx(float(abs(rates).max()), rel=1e-3)
    assert abs(rates[round(float(at) / plan.period)]) == pytest.approx(float(peak), rel=1e-3)
    assert remarks_of_plan(squat(limit, speed * float(share))) == ()
    assert len(remarks_of_plan(squat(limit, speed * float(share) * 1.02))) == 1


@pytest.mark.parametrize(("speed", "is_told"), [(1.0, False), (5.5, True)])
def test_a_rate_that_jumps_within_a_period_is_told(speed, is_told):
    """A knee that turns round: the plain norm's law is within all rates, and no servo follows."""
    law = LimitedNormLaw(LimitedNormSettings(), GaitModel(LegGeometry()), 5e-3)
    plan = law.prepare(FootstepsSettings(steps=(Footstep("right", 0.004, -0.04),), speed=speed))
    notes = remarks_on_jumps(plan)
    assert bool(notes) == is_told
    if is_told:
        found = re.search(
            r"after (\S+) s (\w+) would change its rate by (\S+) rad/s", notes[0].message
        )
        at, joint, jump = found.groups()
        rates = plan.q_dot[:, AXIS_NAMES.index(joint)]
        k = round(float(at) / plan.period)
        assert abs(rates[k + 1] - rates[k]) == pytest.approx(float(jump), rel=5e-3)
        assert float(jump) > 0.5 * plan.geometry.max_rate
