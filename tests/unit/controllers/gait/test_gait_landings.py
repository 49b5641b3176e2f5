"""Where feet come down as servos yield, and how much room they have there."""

import math

import numpy as np
import pytest

from controllers.gait.correction_settings import SagSettings
from controllers.gait.footprints import Footstep, StepNumbers
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.landings import landings
from controllers.gait.sag import sag_offsets
from controllers.gait.smooth import SmoothLaw, SmoothSettings
from controllers.gait.types import GaitModel
from rig.mechanisms.legs.remarks import remarks_on_edges

GEOMETRY = LegGeometry()
SOLE = GEOMETRY.sole.front + GEOMETRY.sole.back


def plan_of(**settings):
    law = SmoothLaw(SmoothSettings(), GaitModel(GEOMETRY), 5e-3)
    return law.prepare(FootstepsSettings(**settings))


def stairs(**numbers):
    asked = StepNumbers(**{"count": 2, "length": 0.1, "rise": 0.01, "together": True, **numbers})
    return plan_of(numbers=asked, lift=0.024, ahead=0.008, follow=0.025)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_commanded_against_sag_never_jumps(seed):
    """A foot bears nothing yet when it has come down: its leg is not pushed at once."""
    rng = np.random.default_rng((271, seed))
    numbers = StepNumbers(
        count=3, first=("left", "right")[seed % 2], length=float(rng.uniform(0.0, 0.04)),
        aside=float(rng.uniform(-0.01, 0.01)), turn=float(rng.uniform(-0.2, 0.2)),
    )  # fmt: skip
    plan = plan_of(numbers=numbers, ahead=float(rng.uniform(0.0, 0.015)))
    offsets = sag_offsets(plan, SagSettings())
    rates = np.abs(np.diff(offsets, axis=0)) / plan.period
    assert np.abs(offsets).max() > 5e-3
    assert rates.max() < 0.15, "rad/s; 2.6 where a foot bore its share at once"


def test_the_room_is_that_between_the_prints_of_two_treads():
    room = [landing.room for landing in landings(stairs(length=0.107), 150.0)]
    assert room[:2] == pytest.approx([0.107 - SOLE] * 2, abs=1e-9)
    assert math.isinf(room[-1]), "nothing is higher than the last tread"
    level = landings(stairs(rise=0.0), 150.0)
    assert all(math.isinf(landing.room) for landing in level)


def test_stiffer_servos_bring_feet_nearer_to_their_prints():
    plan = stairs()
    soft, stiff = ([landing.off for landing in landings(plan, k)] for k in (100.0, 1e4))
    assert np.array(soft) == pytest.approx(100.0 * np.array(stiff), rel=0.1)
    assert max(soft) > 2e-3


@pytest.mark.parametrize(("length", "is_told"), [(0.1, True), (0.115, False)])
def test_too_little_room_is_told_with_step_room_and_remedy(length, is_told):
    plan = stairs(length=length)
    notes = remarks_on_edges(plan, None)
    assert bool(notes) == is_told
    if is_told:
        ((_, words),) = notes
        assert f"{(length - SOLE) * 1e3:.1f} mm beside a print that is 10 mm higher" in words
        assert "legs.sag={}" in words
    assert not remarks_on_edges(plan, SagSettings())


def test_a_slope_is_no_edge():
    lean = math.radians(-3.0)
    steps = tuple(
        Footstep(foot, x, y, height=-x * math.tan(lean), pitch=lean)
        for foot, x, y in (("left", 0.03, 0.039), ("right", 0.06, -0.039), ("left", 0.06, 0.039))
    )
    plan = plan_of(steps=steps, start_pitch=lean)
    assert all(math.isinf(landing.room) for landing in landings(plan, 150.0))
