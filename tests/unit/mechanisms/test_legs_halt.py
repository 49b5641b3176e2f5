"""A stop of the legs in mid-walk: on their path, evenly slower, and said where."""

import math

import numpy as np
import pytest
from motion_fakes import MID, LegsBench, squat, straight_plan
from servo_fakes import ACCELERATION, PERIOD, STEP

from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.laws import InverseLaw, NoSettings
from controllers.gait.motions import SquatSettings
from controllers.gait.types import GaitModel, LegsCommand, LegsReference
from rig.hal import LimitExceeded
from rig.hal.motion import Segment
from rig.mechanisms.legs.facts import plan_facts
from rig.mechanisms.legs.halt import Halt
from rig.mechanisms.legs.mechanism import Legs, PlannedGait
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.servo.settings import ServoLimits

STILL = (0.0,) * 12


def places(halt, cycles):
    """Return where the first joint goes, in periods of the plan."""
    return [halt.advance()[0] / PERIOD for _ in range(cycles)]


def test_the_time_of_the_plan_runs_out_evenly():
    halt = Halt(straight_plan(), 4, ACCELERATION)  # 1 rad/s in steps of 1/8
    steps = np.diff([4.0, *places(halt, 10)])
    assert steps.tolist() == [7 / 8, 6 / 8, 5 / 8, 4 / 8, 3 / 8, 2 / 8, 1 / 8, 0.0, 0.0, 0.0]


def test_all_joints_stay_on_the_plans_curve():
    halt = Halt(straight_plan(speeds=(1.0, -0.5)), 4, ACCELERATION)
    for _ in range(10):
        one, other = halt.advance()
        assert other == -0.5 * one
    assert halt.end == (one, other)
    assert halt.end[0] == 7.5 * PERIOD


@pytest.mark.parametrize(
    ("speeds", "cycles"),
    [
        ((0.0, 0.0), 1),
        ((STEP, 0.0), 1),
        ((STEP + 1e-9, 0.0), 2),
        ((8 * STEP, 0.0), 8),
        ((8 * STEP + 1e-9, 0.0), 9),
        ((0.0, -8 * STEP - 1e-9), 9),
    ],
)
def test_the_fastest_joint_says_how_many_cycles_it_takes(speeds, cycles):
    moving = straight_plan()
    plan = moving._replace(q_dot=np.tile(speeds, (20, 1)))
    # n cycles go (n - 1) / 2 periods of the plan further.
    assert Halt(plan, 4, ACCELERATION).end[0] / PERIOD == pytest.approx(4.0 + 0.5 * (cycles - 1))


def test_the_speed_is_that_of_the_sample_and_not_of_another():
    plan = straight_plan()
    plan.q_dot[5] = (2.0, 0.0)
    assert Halt(plan, 5, ACCELERATION).end[0] / PERIOD == 5.0 + 7.5
    assert Halt(plan, 4, ACCELERATION).end[0] / PERIOD == 4.0 + 3.5


def test_a_halt_ends_with_the_plan_at_the_latest():
    halt = Halt(straight_plan(count=10), 8, ACCELERATION)
    assert halt.end[0] == 9 * PERIOD
    assert places(halt, 3) == [8.875, 9.0, 9.0]
    assert Halt(straight_plan(count=10), 9, ACCELERATION).end[0] == 9 * PERIOD


# The legs in the loop -------------------------------------------------------------------------


def test_before_the_walk_each_joint_brakes_by_itself():
    bench = LegsBench()
    state = bench.start(MID)
    assert bench.legs.resting_command(state).positions == MID
    bench.legs.motion = bench.motion
    bench.start(MID)
    moved = [p + PERIOD if k == 3 else p for k, p in enumerate(MID)]
    bench.legs.limit(LegsCommand(tuple(moved), STILL))
    stop = bench.legs.resting_command(state).positions
    assert stop[3] == pytest.approx(MID[3] + PERIOD + 0.5 / ACCELERATION)
    assert [p for k, p in enumerate(stop) if k != 3] == [p for k, p in enumerate(MID) if k != 3]


def test_in_mid_walk_the_legs_rest_where_the_halt_ends():
    bench = LegsBench()
    state = bench.follow(20)
    halt = Halt(bench.plan, 19, ACCELERATION)
    stop = bench.legs.resting_command(state)
    assert stop == (halt.end, STILL)
    assert bench.legs.released_command() == stop
    for _ in range(30):
        applied = bench.legs.limit(LegsCommand(MID, STILL))  # whatever is asked for
        assert applied.positions == pytest.approx(halt.advance(), abs=1e-12)
    assert applied.positions == pytest.approx(stop.positions, abs=1e-12)
    assert bench.legs.limit_hits()["joint acceleration"] == 0


def test_a_new_motion_forgets_the_halt():
    bench = LegsBench()
    bench.legs.resting_command(bench.follow(20))
    state = bench.start(MID)
    assert bench.legs.limit(LegsCommand(MID, STILL)).positions == MID
    assert bench.legs.pose_held() is None
    assert bench.legs.resting_command(state).positions == MID


@pytest.mark.parametrize(("before_the_end", "done"), [(3, False), (2, True), (1, True), (0, True)])
def test_a_stop_near_the_end_is_the_plans_own_end(before_the_end, done):
    bench = LegsBench()
    count = len(bench.plan.t)
    state = bench.follow(count - before_the_end)
    end = tuple(bench.plan.q[-1].tolist())
    stop = bench.legs.resting_command(state).positions
    if done:
        assert stop == end
        assert bench.legs._halt is None
        assert bench.legs.released_command().positions == end
    else:
        assert bench.legs._halt is not None


def test_the_log_goes_on_with_the_plan_only_while_it_is_followed():
    bench = LegsBench()
    bench.servo.angles = MID
    state = bench.legs.read(0.0)
    rest = LegsCommand(MID, STILL)
    unplanned = bench.legs.row(state, LegsReference(MID, STILL, False), rest, rest)
    assert len(unplanned) == len(bench.legs.columns)
    assert unplanned[-26:] == (0.0,) * 26
    bench.legs.motion = bench.motion
    logged = []
    for follow in (False, True, True, False, True):
        row = bench.legs.row(state, LegsReference(MID, STILL, follow), rest, rest)
        assert len(row) == len(bench.legs.columns)
        logged.append(row[-26:])
    assert logged == [bench.motion.sample(k) for k in (0, 0, 1, 2, 2)]


def test_the_plans_columns_are_those_of_the_cycle_and_of_the_nearest_one_beyond_it():
    motion, plan = LegsBench().motion, LegsBench().plan
    last = len(plan.t) - 1
    for number, row in ((-1, 0), (0, 0), (1, 1), (40, 40), (last, last), (last + 1, last)):
        logged = motion.sample(number)
        assert logged[:3] == tuple(plan.waist[row].tolist())
        assert logged[3:9] == tuple(plan.feet[row].ravel().tolist())
        assert logged[9:13] == (*plan.balance.centre[row, :2], *plan.balance.zero_moment[row])
        assert logged[13:15] == (plan.balance.static_margin[row], plan.balance.margin[row])
        assert logged[15:17] == (plan.phase_number[row], plan.path[row])
        assert logged[17:24] == (plan.yaw[row], *plan.attitudes[row].ravel())
        assert logged[24:] == plan.phases[int(plan.phase_number[row])].phase.standing
    assert motion.sample(0) != motion.sample(1)
    assert motion.sample(last) != motion.sample(last - 1)


def test_a_fault_says_where_the_legs_are_held_and_how_safely():
    bench = LegsBench()
    bench.follow(20)
    margin = bench.plan.balance.static_margin
    said = bench.legs.pose_held()
    assert said == (
        f"the legs are held where they are at {19 * PERIOD:.3f} s of the reference (down 1); "
        f"there the centre of mass is {margin[19] * 1e3:.1f} mm inside the edge of the support"
    )
    bench.follow(round(1.5 / PERIOD))
    assert "(up 1)" in bench.legs.pose_held()


def test_the_nearest_instant_that_is_safe_is_told():
    bench = LegsBench()
    bench.follow(20)
    margin = bench.plan.balance.static_margin
    margin[15:] = 0.0
    margin[14] = bench.legs.settings.balance.min_margin  # on the bound is safe
    assert f"are at {14 * PERIOD:.3f} s" in bench.legs.pose_held()
    margin[14] -= 1e-9
    assert f"are at {13 * PERIOD:.3f} s" in bench.legs.pose_held()


def test_without_a_walk_nothing_is_said_of_a_held_pose():
    bench = LegsBench()
    bench.start(MID)
    assert bench.legs.pose_held() is None
    bench.legs.motion = bench.motion
    assert bench.legs.pose_held() is None


def test_the_limits_are_those_of_the_geometry_mirrored_on_the_right():
    bench, geometry = LegsBench(), LegGeometry()
    joints = bench.legs.joints
    assert tuple(zip(joints.lower, joints.upper, strict=True)) == geometry.limits
    assert joints.rates == (geometry.max_rate,) * 12
    roll = AXIS_NAMES.index("right_hip_roll")
    beyond = list(MID)
    beyond[roll] = math.radians(20.0) + 0.126
    bench.servo.angles = tuple(beyond)
    with pytest.raises(LimitExceeded, match="position of right_hip_roll"):
        bench.legs.check(bench.legs.read(0.0), 0.0)


def test_a_plan_is_timed_and_told_phase_by_phase():
    bench = LegsBench()
    assert bench.motion.duration == pytest.approx(2.0)
    assert bench.motion.segments == (
        Segment("all", 0.0, bench.motion.duration),
        Segment("down 1", 0.0, 1.0),
        Segment("up 1", 1.0, 2.0),
    )
    assert bench.motion.at(5 * PERIOD).positions == tuple(bench.plan.q[5].tolist())
    assert bench.motion.waits


def test_what_is_no_reference_for_legs_is_refused():
    with pytest.raises(ValueError, match="not one for legs"):
        Legs.plan(LegsSettings(("servo",), ServoLimits()), object(), None, PERIOD)


def test_an_approach_goes_from_rest_to_rest():
    start, end = LegsReference(STILL, STILL, False), LegsReference((1.0,) * 12, STILL, False)
    assert Legs.approach(start, end, 2.0, 1.0) == ((0.5,) * 12, (0.9375,) * 12, False)


# What is known beforehand ----------------------------------------------------------------------


def test_peak_rates_are_those_of_the_fine_plan():
    coarse, fine = squat(), squat(depth=0.05)
    known = plan_facts(coarse, fine, 0.25)
    assert known["peak_knee_rate"].value == fine.peak_knee_rate > coarse.peak_knee_rate
    assert known["rate_jump"].value == fine.greatest_jump
    assert known["plan_duration"].value == coarse.duration
    assert known["advance_lost"].value == pytest.approx(0.25)
    assert known["min_knee"].value == pytest.approx(0.5)
    assert known["start_knee"].value == pytest.approx(0.5)
    assert known["knee_torque_saved"].value == 0.0


@pytest.mark.parametrize(("period", "fine"), [(PERIOD, 1e-3), (0.5e-3, 0.5e-3)])
def test_peak_rates_are_worked_out_at_a_kilohertz_at_least(period, fine):
    reference = SquatSettings(knee_min=0.0, time=0.5, repeats=1)
    law = InverseLaw(NoSettings(), GaitModel(), period)
    motion = Legs.plan(LegsSettings(("servo",), ServoLimits()), reference, law, period)
    finely = InverseLaw(NoSettings(), GaitModel(), fine).prepare(reference)
    assert motion.facts["peak_knee_rate"].value == finely.peak_knee_rate
    assert motion.plan.period == period
    assert motion.facts["advance_lost"].value < 1e-9  # it was to go nowhere


def test_a_straight_knee_belongs_to_an_instant_that_is_near_it():
    """Straight at the start, at the turn and at the end: only the start is no instant's."""
    gait = PlannedGait(squat(knee_min=0.0, repeats=2), squat(knee_min=0.0, repeats=2))
    assert gait.facts["near_singular_windows"].value == 3.0
    assert gait.facts["near_singular_astray"].value == 1.0
