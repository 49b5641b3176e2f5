"""A walk is planned twice, at the loop's period and finely: what is said holds for both."""

import re
from types import SimpleNamespace

import pytest

from controllers.gait.footprints import Footstep, StepNumbers
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.laws import LimitedNormLaw, LimitedNormSettings
from controllers.gait.types import GaitModel
from controllers.motion import InfeasibleMotion
from rig.mechanisms.legs.ground import prints_off_ground
from rig.mechanisms.legs.mechanism import Legs
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.servo.settings import ServoLimits

PERIOD = 5e-3
SETTINGS = LegsSettings(("servo",), ServoLimits())


def sideways(speed, aside=12.263e-3):
    numbers = StepNumbers(count=2, length=0.0, aside=-aside, together=True)
    return FootstepsSettings(
        numbers=numbers, first_shift_time=3.0, shift_time=2.72, swing_time=2.17, speed=speed
    )


def plan(speed):
    law = LimitedNormLaw(LimitedNormSettings(), GaitModel(LegGeometry()), PERIOD)
    return Legs.plan(SETTINGS, sideways(speed), law, PERIOD)


def test_a_speed_that_is_named_is_accepted_at_both_periods():
    """Finely the zero-moment point is elsewhere: a speed that the loop bears may be refused."""
    with pytest.raises(InfeasibleMotion, match="zero-moment point") as refused:
        plan(2.855)
    (speed,) = re.findall(r"at a speed of (\S+) instead", str(refused.value))
    assert plan(float(speed)).plan.margin >= SETTINGS.balance.min_margin


def test_nothing_of_a_refused_walk_is_left_to_run():
    law = LimitedNormLaw(LimitedNormSettings(), GaitModel(LegGeometry()), PERIOD)
    finer = law.finer(1e-3)
    law.prepare(sideways(1.0))
    with pytest.raises(InfeasibleMotion):
        finer.prepare(sideways(2.855))
    for each in (law, finer):
        with pytest.raises(RuntimeError, match="before it prepared a motion"):
            each.update(None, SimpleNamespace(follow=True))


@pytest.mark.parametrize(
    ("rise", "ground", "said"),
    [
        (-0.012, 0.0, "12 mm below the start, and the simulated ground there is level with"),
        (0.012, -0.02, "12 mm above the start, and the simulated ground there is level with"),
        (0.0, 0.01, "level with the start, and the simulated ground there is 10 mm above the"),
    ],
)
def test_a_print_off_the_simulated_ground_is_told_as_above_or_below(rise, ground, said):
    numbers = StepNumbers(count=1, length=0.1, rise=rise, together=True)
    block = SimpleNamespace(start=0.05, length=1.0, height=ground, slope=0.0)
    plant = SimpleNamespace(terrain=(block,), floor_pitch=0.0, floor_roll=0.0)
    (note,) = prints_off_ground(LegGeometry(), FootstepsSettings(numbers=numbers), plant)
    assert said in note


@pytest.mark.parametrize(
    ("length", "heading", "edge"), [(0.1, 0.0, None), (0.085, 0.0, 100.0), (0.1, 0.3, 100.0)]
)
def test_a_print_that_reaches_under_the_edge_of_higher_ground_is_told(length, heading, edge):
    """Its ankle is on its tread; a corner of the sole that is turned, or too near, is not."""
    blocks = [SimpleNamespace(start=-1.0, length=1.1, height=0.01, slope=0.0)]
    plant = SimpleNamespace(terrain=tuple(blocks), floor_pitch=0.0, floor_roll=0.0)
    at = 0.1 + (length - 0.1) + LegGeometry().sole.back
    steps = (Footstep("left", 0.05, 0.039, height=0.01), Footstep("right", at, -0.039, heading))
    notes = prints_off_ground(LegGeometry(), FootstepsSettings(steps=steps), plant)
    assert bool(notes) == (edge is not None)
    if edge is not None:
        words = f"step 2 is planned to land on an edge: at x {edge:.1f} mm, still under the sole"
        assert words in notes[0]
        assert "is 10 mm higher" in notes[0]


@pytest.mark.parametrize(("edge", "is_told"), [(0.164, False), (0.173, True)])
def test_a_swing_that_is_caught_by_the_edge_that_it_leaves_is_told(edge, is_told):
    """The plan knows of its prints only; the tread from which it steps down goes on beyond them."""
    prints = ((0.105, 0.012), (0.21, 0.0))
    steps = [
        Footstep(foot, x, y, height=height)
        for x, height in prints
        for foot, y in (("left", 0.039), ("right", -0.039))
    ]
    tread = SimpleNamespace(start=0.064, length=edge - 0.064, height=0.012, slope=0.0)
    plant = SimpleNamespace(terrain=(tread,), floor_pitch=0.0, floor_roll=0.0)
    walk = FootstepsSettings(steps=tuple(steps), lift=0.024, ahead=0.006, follow=0.035)
    notes = prints_off_ground(LegGeometry(), walk, plant)
    assert bool(notes) == is_told
    if is_told:
        words = r"swing left 3, (\d+) % of the way, would bring the sole (\S+) mm into"
        percent, depth = re.match(words, notes[0]).groups()
        assert 50 < int(percent) < 100
        assert 0.2 < float(depth) < 12.0


def test_a_floor_that_slopes_otherwise_than_the_plan_begins_is_told():
    def told(pitch, roll, **settings):
        plant = SimpleNamespace(terrain=(), floor_pitch=pitch, floor_roll=roll)
        walk = FootstepsSettings(numbers=StepNumbers(count=3), **settings)
        return prints_off_ground(LegGeometry(), walk, plant)

    tilts = {"start_pitch": 0.06, "start_roll": -0.04}
    assert told(0.06, -0.04, **tilts) == ()
    (note,) = told(0.06, 0.0, **tilts)
    assert "a roll of -2.292 deg (reference.start_roll)" in note
    assert "has 0 deg (plant.floor_roll)" in note
    (note,) = told(0.06, 0.0)
    assert "a pitch of 0 deg" in note
