"""An arm's motion as the loop follows it: end, segments and log, and what is known of it."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest
from motion_fakes import PATH, ArmBench, arm_motion, arm_plan
from servo_fakes import ACCELERATION, PERIOD

from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.optimum import least_time
from controllers.arm.paths import Circle, TurnBack
from controllers.arm.places.frames import TaughtFrame
from controllers.arm.pose_path import PosePath
from controllers.arm.types import ArmCommand, ArmReference
from controllers.motion import InfeasibleMotion
from rig.config.diagnostics import Problems
from rig.config.located import Source
from rig.config.settings import build
from rig.config.yaml_loader import parse
from rig.hal import LimitExceeded
from rig.hal.motion import Segment
from rig.mechanisms.arm.facts import facts_of_plan, return_error
from rig.mechanisms.arm.mechanism import SETTLING, Arm
from rig.mechanisms.arm.settings import ArmSettings
from rig.mechanisms.servo.settings import ServoLimits

STILL = (0.0,) * 6


def facts(**changes):
    return {
        name: fact.value
        for name, fact in facts_of_plan(arm_plan(**changes), ArmGeometry(), PATH).items()
    }


def test_the_end_of_the_motion_is_held_for_a_quarter_of_a_second():
    assert arm_motion(count=5).duration == 4 * PERIOD + 0.25
    assert SETTLING == 0.25


@pytest.mark.parametrize(
    ("duration", "end"),
    [
        (3.5 * PERIOD, 3.5 * PERIOD),  # the path ends between two cycles
        (4.0 * PERIOD, 4.0 * PERIOD),
        (4.5 * PERIOD, 4.0 * PERIOD),  # nothing is commanded after the last one
        (0.5 * PERIOD, PERIOD),  # a law that halts where it starts has one cycle
        (0.0, PERIOD),
    ],
)
def test_the_path_is_what_is_left_without_settling(duration, end):
    motion = arm_motion(duration=duration)
    assert motion.segments == (
        Segment("all", 0.0, 4 * PERIOD + SETTLING),
        Segment("path", 0.0, end),
    )


@pytest.mark.parametrize(
    ("marks", "region"),
    [
        ((), None),
        ((PERIOD,), None),  # entered and never left
        ((PERIOD, 2 * PERIOD), (PERIOD, 2 * PERIOD)),
        ((PERIOD, 99.0), (PERIOD, 4 * PERIOD + SETTLING)),
    ],
)
def test_a_region_that_is_entered_and_left_is_a_segment(marks, region):
    segments = {name: span for name, *span in arm_motion(marks={"region": marks}).segments}
    assert segments.get("region") == (None if region is None else list(region))
    assert len(segments) == (2 if region is None else 3)


def test_after_its_last_cycle_the_motion_rests_at_its_end():
    motion = arm_motion(count=5)
    last = (4 / 64,) * 6
    assert motion.at(4.0 * PERIOD) == (last, (1.0,) * 6, True, None)
    assert motion.at(4.5 * PERIOD) == (last, (1.0,) * 6, True, None)
    assert motion.at(math.nextafter(4.5 * PERIOD, 1.0)) == (last, STILL, True, None)
    assert motion.at(motion.duration) == (last, STILL, True, None)
    assert motion.at(0.0).positions == STILL
    assert motion.waits  # for a cycle that comes late: no step is left out


def test_the_plans_columns_are_those_of_the_cycle_and_of_the_last_one_after_it():
    motion = arm_motion(count=3)
    assert [motion.sample(number)[0] for number in (-1, 0, 1, 2, 3)] == [0.0, 0.0, 1.0, 2.0, 2.0]
    hand, elbow, wrist = slice(0, 3), slice(3, 6), slice(6, 9)
    row = motion.sample(2)
    assert len(row) == 30
    assert row[hand] == (2.0,) * 3
    assert math.dist(row[elbow], (0.0, 0.0, 0.0)) == pytest.approx(0.4)  # the shoulder is there
    assert math.dist(row[wrist], row[elbow]) == pytest.approx(0.39)
    assert row[9:21] == (2.0,) * 12
    assert row[21:24] == (0.5 + 2 / 64,) * 3
    assert row[24:] == (2.0, 2.0, 2.25, 2.0, 2.0, 2.0)


def planned(bench, following):
    """Return the planned hand that a cycle logs."""
    state = bench.arm.read(0.0)
    reference = ArmReference(STILL, STILL, following)
    row = bench.arm.row(state, reference, ArmCommand(STILL, STILL), ArmCommand(STILL, STILL))
    named = {column.name: value for column, value in zip(bench.arm.columns, row, strict=True)}
    return named["reference.hand_x"]


def test_the_log_goes_on_with_the_plan_only_while_it_is_followed():
    bench = ArmBench()
    assert planned(bench, False) == 0.0  # nothing is planned
    bench.arm.motion = arm_motion(count=5)
    assert [planned(bench, follow) for follow in (False, False, True, True, False, True)] == [
        0.0, 0.0, 0.0, 1.0, 2.0, 2.0,
    ]  # fmt: skip
    bench.arm.start_limiting(bench.arm.read(0.0))
    assert planned(bench, True) == 0.0


def test_a_stop_takes_as_long_as_the_fastest_joint_and_the_settling():
    geometry = ArmGeometry()
    assert ArmBench().arm.stopping_time == max(geometry.rate_limits) / ACCELERATION + 0.25


def test_the_limits_are_those_of_the_geometry_each_at_its_joint():
    bench = ArmBench()
    geometry = ArmGeometry()
    assert bench.arm.joints.lower == geometry.position_min
    assert bench.arm.joints.upper == geometry.position_max
    assert bench.arm.joints.rates == geometry.rate_limits
    bench.servo.angles = (0.0, 0.0, 2.8 + 0.126, 0.0, 0.0, 0.0)
    with pytest.raises(LimitExceeded, match="position of q3"):
        bench.arm.check(bench.arm.read(0.0), 0.0)


def test_what_is_no_reference_for_an_arm_is_refused():
    with pytest.raises(ValueError, match="not one for an arm"):
        Arm.plan(ArmSettings(("servo",), None), object(), None, PERIOD)


def test_an_approach_goes_from_rest_to_rest():
    start, end = ArmReference(STILL, STILL, False), ArmReference((1.0,) * 6, STILL, False)
    assert Arm.approach(start, end, 2.0, 1.0) == ((0.5,) * 6, (0.9375,) * 6, False, None)


# What is known beforehand --------------------------------------------------------------------


def test_the_duration_is_held_against_the_least_one():
    least = least_time(ArmGeometry(), PATH)
    known = facts(duration=3.0)
    assert (known["time_end"], known["time_optimum"]) == (3.0, least)
    assert known["time_over_optimum"] == 3.0 / least
    assert (known["outcome"], known["completes"]) == (0.0, 1.0)
    for number, outcome in enumerate(("done", "halts", "stalls")):
        known = facts(outcome=outcome)
        assert (known["outcome"], known["completes"]) == (number, number == 0)
        assert math.isinf(known["time_over_optimum"]) == (number > 0)


def test_a_list_for_a_tuple_takes_the_same_time():
    assert least_time(ArmGeometry(rate_limits=[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]), PATH) == least_time(
        ArmGeometry(), PATH
    )


def test_the_time_in_a_region_needs_its_entry_and_its_exit():
    assert facts(marks={"region": (1.0, 3.5)})["dwell_time"] == 2.5
    assert math.isinf(facts(marks={"region": (1.0,)})["dwell_time"])
    assert math.isinf(facts()["dwell_time"])


def test_rates_are_told_of_the_arm_and_of_the_wrist():
    rates = np.array([[1.0, -2.0, 3.0, 4.0, 5.0, -6.0]] * 4)
    rates[2] = 0.5 * rates[2]  # a step down, and one up
    known = facts(count=4, velocities=rates)
    assert (known["peak_rate_arm"], known["peak_rate_wrist"]) == (3.0, 6.0)
    assert [known[f"peak_rate_q{k}"] for k in range(1, 7)] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert known["peak_acceleration_arm"] == 1.5 / PERIOD
    assert known["peak_acceleration"] == 3.0 / PERIOD
    for joint in range(6):
        rates = np.ones((4, 6))
        rates[1, joint] = -7.0
        known = facts(count=4, velocities=rates)
        assert (known["peak_rate_arm"] == 7.0) is (joint < 3)
        assert (known["peak_rate_wrist"] == 7.0) is (joint >= 3)


def test_an_index_that_changes_its_sign_is_crossed_and_not_only_neared():
    indices = np.array([[0.3, 0.2, -0.1], [0.1, -0.2, -0.4], [0.2, -0.3, -0.3]])
    known = facts(count=3, indices=indices)
    assert [known[f"crosses_{name}"] for name in ("shoulder", "elbow", "wrist")] == [0, 1, 0]
    assert [known[f"closest_{name}"] for name in ("shoulder", "elbow", "wrist")] == [0.1, 0, 0.1]
    assert known["elbow_sign_changes"] == 1.0
    assert 0.0 < known["time_crossing"] < PERIOD
    assert known["closest_boundary"] == 0.0
    known = facts(count=3, inside=np.array([0.5, -0.25, 0.75]))
    assert (known["elbow_sign_changes"], known["closest_boundary"]) == (0.0, 0.25)
    assert math.isinf(known["time_crossing"])


def test_an_index_may_be_crossed_at_any_step():
    for step in range(4):
        signs = np.where(np.arange(5) <= step, 0.3, -0.3)
        known = facts(count=5, indices=np.column_stack([signs, np.full(5, 0.2), np.full(5, 0.2)]))
        assert (known["crosses_shoulder"], known["crosses_wrist"]) == (1.0, 0.0)


def test_an_index_that_touches_zero_is_not_crossed():
    known = facts(count=3, indices=np.array([[0.3] * 3, [0.0] * 3, [0.2] * 3]))
    assert known["crosses_shoulder"] == known["closest_shoulder"] == 0.0


def test_joints_that_end_whole_turns_apart_have_returned():
    start = np.zeros(3)
    assert return_error(start, np.array([math.tau, -2 * math.tau, 0.0])) < 1e-12
    assert return_error(start, np.array([0.1, math.tau - 0.3, 0.0])) == pytest.approx(0.3)
    assert return_error(start, np.array([math.pi, 0.0, 0.0])) == pytest.approx(math.pi)
    assert return_error(start, np.array([1.1 * math.pi, 0.0, 0.0])) == pytest.approx(0.9 * math.pi)
    assert return_error(start + 0.5, start + 0.75) == 0.25
    places = np.zeros((4, 6))
    places[:, 2] = (0.25, 9.0, 9.5, 1.0)
    assert facts(count=4, positions=places)["return_error"] == 0.75


def test_a_path_is_seen_in_the_frame_of_the_rig_that_it_names():
    axes = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    table = TaughtFrame((0.4, 0.1, 0.2), on_x=(0.4, 0.3, 0.2), in_xy=(0.3, 0.3, 0.2))
    settings = ArmSettings(servos=("drives",), limits=ServoLimits(), frames={"table": table})
    law = LookAhead(LookAheadSettings(), settings.geometry, PERIOD)
    seen = PosePath(points=((0.0, 0.0, 0.0), (0.05, 0.02, 0.0)), frame="table")
    motion = Arm.plan(settings, seen, law, PERIOD)
    _, slowed = Arm.slowed(settings, seen, law, PERIOD, 0.5)
    ends = [np.array(axes) @ point + table.origin for point in seen.points]
    for made in (motion, slowed):
        np.testing.assert_allclose(made.plan.hand[[0, -1]], ends, atol=1e-9)
    with pytest.raises(InfeasibleMotion, match="of the rig table"):
        Arm.plan(settings, replace(seen, frame="chair"), law, PERIOD)


def test_a_frame_that_says_no_axes_is_one_error_at_its_place():
    text = "points: [[0, 0, 0], [1, 0, 0]]\nframe: {on_x: [1, 0, 0], in_xy: [2, 0, 1.0e-4]}\n"
    problems = Problems()
    assert build(PosePath, parse(Source("path.yaml", text), problems), problems) is None
    (only,) = problems.error().diagnostics
    assert (only.mark.line, only.mark.column) == (2, 1)
    assert only.message.startswith("in_xy is 0.1 mm from the line")


def test_a_slow_motion_is_held_against_the_same_way_at_its_own_speed():
    """It is sampled at a speed at which that does not take a minute and a gigabyte."""
    geometry = ArmGeometry()
    begun = time.process_time()
    circle = Circle(rate=0.002)
    assert least_time(geometry, circle) == pytest.approx(math.pi / 0.002, rel=1e-6)
    line = TurnBack(speed=0.0005, turn_rate=0.0)
    length = math.sqrt(geometry.reach**2 - 0.026941**2) - 0.423695  # of the wrist, along x
    assert least_time(geometry, line) == pytest.approx(2.0 * length / 0.0005, rel=1e-5)
    assert time.process_time() - begun < 10.0
