"""A joint's motion before it moves: its laps, what is refused, and what is known of its poses."""

import math
from types import SimpleNamespace

import pytest
from joint_fakes import GEOMETRY, TILT, joint_limits, joint_settings
from pneumatic_fakes import BASE, HOME, PERIOD, STROKE

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.feasibility import FeasibilityCheck, antipode_tilt
from controllers.spherical_joint.paper_wire import PaperWires
from controllers.spherical_joint.poses import (
    axis_from_tilt,
    natural_rotation,
    paper_rotation,
    twist_of,
)
from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Segment
from rig.mechanisms.cylinder.references import Step
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.motion import JointDrawing, JointMotion, plan_motion
from rig.mechanisms.joint.reach import JointReach, bounds_of

ZERO = (0.0,) * 3
CONTROLLER = SimpleNamespace(settings=SimpleNamespace(wire="exact", pose="natural"))


class Leaning(JointDrawing):
    """A ring that leans to a side, and further from some instant on."""

    segments = (Segment("hold", 0.25, 0.5),)
    duration = 0.5
    repetitions = ()

    def __init__(self, tilt=0.0, then=None, since=0.0, azimuth=0.4, duration=0.5, laps=()):
        self.tilt, self.then, self.since = tilt, then, since
        self.azimuth = azimuth
        self.duration = duration
        self.repetitions = laps

    def at(self, t):
        tilt = self.then if self.then is not None and t >= self.since else self.tilt
        return JointReference(axis_from_tilt(tilt, self.azimuth), ZERO, ZERO, None, 5.0, (1.0, 2.0))


def plan(motion, controller=CONTROLLER, settings=None, **limits):
    return plan_motion(
        settings or joint_settings(joint_limits(**limits)), motion, controller, PERIOD
    )


# Laps ------------------------------------------------------------------------------------------


def test_the_whole_motion_is_a_segment_before_its_own():
    motion = JointMotion(Leaning(duration=2), PERIOD)
    assert motion.duration == 2.0
    assert motion.segments == (Segment("all", 0.0, 2.0), Segment("hold", 0.25, 0.5))


def test_a_reference_says_where_in_a_lap_it_is():
    """Three laps of 8 cycles from 4 cycles on."""
    motion = JointMotion(Leaning(laps=((4 * PERIOD, 8 * PERIOD, 3),)), PERIOD)
    laps = {tick: motion.at(tick * PERIOD).lap for tick in (3, 4, 11, 12, 19, 27, 28)}
    assert laps == {
        3: None, 4: (0, 0, 8), 11: (0, 7, 8), 12: (1, 0, 8), 19: (1, 7, 8), 27: (2, 7, 8), 28: None,
    }  # fmt: skip
    reference = motion.at(4 * PERIOD)
    assert reference._replace(lap=None) == Leaning().at(0.0)  # all else is the motion's


def test_a_time_between_cycles_belongs_to_the_nearer_one():
    motion = JointMotion(Leaning(laps=((0.0, 8 * PERIOD, 2),)), PERIOD)
    assert motion.at(2.4 * PERIOD).lap == (0, 2, 8)
    assert motion.at(2.6 * PERIOD).lap == (0, 3, 8)


def test_of_several_repetitions_the_one_that_runs_counts_and_one_lap_is_none():
    laps = ((0.0, 4 * PERIOD, 1), (8 * PERIOD, 4 * PERIOD, 2), (16 * PERIOD, 2 * PERIOD, 2))
    motion = JointMotion(Leaning(laps=laps), PERIOD)
    assert [motion.at(tick * PERIOD).lap for tick in (0, 8, 15, 16, 19, 20)] == [
        None, (0, 0, 4), (1, 3, 4), (0, 0, 2), (1, 1, 2), None,
    ]  # fmt: skip


# What is refused -----------------------------------------------------------------------------


def test_a_motion_may_lean_by_the_limit_and_not_further():
    plan(Leaning(TILT - 1e-9))
    with pytest.raises(ValueError, match=r"^after 0\.00 s: .*the tilt is 28\.6\d deg, max_tilt is"):
        plan(Leaning(TILT + 1e-9))


@pytest.mark.parametrize("since", [0.0, 0.2, 0.25, 0.5])
def test_every_hundredth_of_a_second_is_looked_at(since):
    with pytest.raises(ValueError, match=rf"^after {since:.2f} s: "):
        plan(Leaning(0.1, TILT + 0.01, since - 1e-9))
    plan(Leaning(0.1, TILT + 0.01, 0.5 + 1e-9))  # when it has ended


def test_a_limit_beyond_the_wires_geometry_is_refused_whatever_the_motion():
    with pytest.raises(ValueError, match=r"max_tilt \(90\.00 deg\) must be below"):
        plan(
            Leaning(0.0),
            settings=joint_settings(
                joint_limits(tilt=0.5 * math.pi),
                geometry=type(GEOMETRY)(ring_radius=12e-3),
            ),
        )


def test_a_rod_must_stay_in_its_cylinder():
    """The wire that the ring leans to gets 25 mm/rad shorter."""
    limits = joint_limits(tilt=1.2)
    short = joint_settings(limits, home=0.375 * HOME)
    with pytest.raises(ValueError, match=r"rod 1 would extend to -0\.53 mm, beyond 0\.00 mm"):
        plan(Leaning(0.49, azimuth=0.5 * math.pi), settings=short)
    plan(Leaning(0.45, azimuth=0.5 * math.pi), settings=short)
    long = joint_settings(limits, home=STROKE - 0.375 * HOME)
    with pytest.raises(ValueError, match=r"rod 3 would extend to 63\.03 mm, beyond 62\.50 mm"):
        plan(Leaning(0.49, azimuth=0.5 * math.pi), settings=long)


def test_what_is_no_reference_for_the_joint_is_refused():
    with pytest.raises(ValueError, match="not one for the spherical joint"):
        plan(Step(1e-3))


def test_the_controller_says_which_pose_it_believes_in():
    """The paper's pose spins the ring off the axes: another rod is the first out of its stroke."""
    paper = SimpleNamespace(settings=SimpleNamespace(wire="paper", pose="paper"))
    limits = joint_limits(tilt=1.2, tension=(0.0, 1e6), seat_margin=-math.pi)
    settings = joint_settings(limits, home=0.375 * HOME)
    refusals = []
    for controller in (CONTROLLER, paper):
        with pytest.raises(ValueError) as caught:
            plan(Leaning(0.8, azimuth=0.25 * math.pi), controller, settings)
        refusals.append(str(caught.value))
    assert refusals[0] != refusals[1]


def test_the_bounds_of_poses_are_those_of_the_profile():
    settings = joint_settings(joint_limits(seat_margin=0.1, free_wires=False))
    bounds = bounds_of(settings)
    assert (bounds.max_tilt, bounds.extension) == (TILT, (0.0, STROKE))
    assert bounds.home_extension == HOME
    assert (bounds.least_tension, bounds.most_tension) == (5.0, 90.0)
    assert bounds.total_tension == 4.0 * settings.area * BASE
    assert (bounds.seat_margin, bounds.free_wires) == (0.1, False)


# What is known --------------------------------------------------------------------------------


def test_what_is_told_of_poses_changes_every_twentieth_of_a_second():
    motion = plan(Leaning(0.1, 0.4, 0.299))
    upright = plan(Leaning(0.1)).pose
    leaning = plan(Leaning(0.4)).pose
    assert motion.pose == upright != leaning
    for t, pose in (
        (0.0, upright),
        (0.29, upright),
        (0.301, leaning),
        (0.5, leaning),
        (9, leaning),
    ):
        motion.at(t)
        assert motion.pose == pose
    # What is told of at 0.05, 0.10, 0.15 … 0.50 s counts from there on.
    for since, t, pose in (
        (0.03, 0.0, upright), (0.105, 0.12, upright), (0.149, 0.16, leaning), (0.49, 0.5, leaning),
    ):  # fmt: skip
        motion = plan(Leaning(0.1, 0.4, since))
        assert motion.pose == upright
        motion.at(t)
        assert motion.pose == pose
    assert SphericalJoint.plan(joint_settings(), Leaning(0.1), CONTROLLER, PERIOD).pose == upright


def test_the_least_tension_is_of_the_wires_that_hold_the_pose():
    reach = JointReach(joint_settings())
    settings = joint_settings()
    assert reach.at((0.0, 0.0, 1.0)).least_tension == pytest.approx(settings.area * BASE)
    assert reach.at(axis_from_tilt(0.5, 0.4)).least_tension < settings.area * BASE


@pytest.mark.parametrize("sector", [0, 1, 5, 12, 30, 47])
def test_the_reach_is_where_poses_stop_being_possible(sector):
    settings = joint_settings(home=0.5 * HOME)
    azimuth = math.tau * sector / 48
    reach = JointReach(settings)
    limit = reach.at(axis_from_tilt(0.1, azimuth)).reach
    bounds = bounds_of(joint_settings(joint_limits(tilt=0.5 * math.pi), home=0.5 * HOME))
    check = FeasibilityCheck(GEOMETRY, bounds)
    step = min(antipode_tilt(GEOMETRY), 0.5 * math.pi) / 2**10
    assert limit == pytest.approx(
        step * round(limit / step), rel=1e-12
    )  # ten halvings of a right angle
    assert not check.check_pose(axis_from_tilt(limit, azimuth))
    assert check.check_pose(axis_from_tilt(limit + step, azimuth))
    # A direction belongs to the nearest of 48.
    for aside in (-0.49, 0.49):
        axis = axis_from_tilt(0.1, azimuth + aside * math.tau / 48)
        assert reach.at(axis).reach == limit


def test_the_papers_errors_are_those_of_its_worst_wire():
    reach = JointReach(joint_settings())
    exact, paper = ExactWires(GEOMETRY), PaperWires(GEOMETRY)
    axis = axis_from_tilt(0.7, 0.6)
    its, natural = paper_rotation(axis), natural_rotation(axis)
    errors = [p - e for p, e in zip(paper.lengths(its), exact.lengths(its), strict=True)]
    gaps = [p - n for p, n in zip(exact.lengths(its), exact.lengths(natural), strict=True)]
    assert reach.paper_error(axis) == max(map(abs, errors)) > 0.0
    assert reach.at(axis).paper_error == reach.paper_error(axis)
    assert reach.pose_gap(axis) == max(map(abs, gaps)) > max(gaps[0], 0.0)


def test_the_facts_are_the_worst_and_the_best_round_about():
    settings = joint_settings(home=0.5 * HOME)
    reach = JointReach(settings)
    facts = {name: fact.value for name, fact in reach.facts().items()}
    about = [axis_from_tilt(0.1, math.tau * k / 48) for k in range(48)]
    reaches = [reach.at(axis).reach for axis in about]
    assert facts["reachable_tilt"] == min(reaches) < max(reaches) == facts["reachable_tilt_best"]
    for degrees in (20, 40, 60):
        circle = [axis_from_tilt(math.radians(degrees), math.tau * k / 48) for k in range(48)]
        assert facts[f"paper_wire_error_{degrees}deg"] == max(map(reach.paper_error, circle))
        assert facts[f"paper_pose_gap_{degrees}deg"] == max(map(reach.pose_gap, circle))
        assert facts[f"paper_twist_{degrees}deg"] == max(
            abs(twist_of(paper_rotation(axis))) for axis in circle
        )
    assert len(facts) == 2 + 3 * 3


def test_tilts_beyond_the_wires_geometry_are_not_told_of():
    narrow = type(GEOMETRY)(ring_radius=8e-3, adjust_radius=15e-3, adjust_depth=30e-3)
    highest = math.degrees(antipode_tilt(narrow))
    assert 40.0 < highest < 60.0
    told = JointReach(joint_settings(geometry=narrow)).facts()
    assert "paper_twist_40deg" in told
    assert "paper_twist_60deg" not in told


def test_an_approach_is_the_shortest_way():
    start = JointReference(axis_from_tilt(0.4, 0.0), ZERO, ZERO)
    end = JointReference(axis_from_tilt(0.4, math.pi), ZERO, ZERO)
    middle = SphericalJoint.approach(start, end, 2.0, 1.0)
    assert middle.axis == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert middle.velocity == pytest.approx((-1.875 * 0.8 / 2.0, 0.0, 0.0), abs=1e-12)
    assert SphericalJoint.approach(start, end, 2.0, 0.0).axis == pytest.approx(start.axis)
    assert SphericalJoint.approach(start, end, 2.0, 2.0).axis == pytest.approx(end.axis)
