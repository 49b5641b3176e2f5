"""What axes on servo drives may be told: range, rate, and a stop under a bounded deceleration."""

import itertools
import math
import random

import numpy as np
import pytest
from servo_fakes import (
    ACCELERATION,
    FOLLOWING,
    LOWER,
    NAMES,
    PERIOD,
    RATES,
    STEP,
    TINY,
    UPPER,
    Command,
    Reference,
    ServoBench,
)

from rig.hal import LimitExceeded
from rig.mechanisms.servo.axes import ServoAxes
from rig.mechanisms.servo.columns import servo_columns

NO_HITS = {"joint range": 0, "joint rate": 0, "joint acceleration": 0}


def at(axis, angle):
    return {name: angle if name == axis else 0.0 for name in NAMES}


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", NAMES)
def test_a_command_that_is_not_a_number_is_refused_by_name(axis, bad):
    bench = ServoBench()
    bench.start()
    with pytest.raises(LimitExceeded) as caught:
        bench.limit(**at(axis, bad))
    error, k = caught.value, NAMES.index(axis)
    assert error.quantity == f"commanded position of {axis}"
    assert (error.lower, error.upper, error.unit) == (LOWER[k], UPPER[k], "rad")
    bench.axes.write(Command((0.0,) * 3, (0.0,) * 3))
    assert bench.left.sent == bench.right.sent == []


@pytest.mark.parametrize("end", ["lower", "upper"])
@pytest.mark.parametrize("axis", NAMES)
def test_a_command_beyond_the_range_is_kept_in_it_and_counted(axis, end):
    bench = ServoBench()
    k = NAMES.index(axis)
    bound, way = (UPPER[k], 1.0) if end == "upper" else (LOWER[k], -1.0)
    bench.start(**at(axis, bound))
    assert bench.limit(**at(axis, bound)).positions[k] == bound
    assert bench.axes.limit_hits() == NO_HITS
    assert bench.limit(**at(axis, bound + way * TINY)).positions[k] == bound
    assert bench.axes.limit_hits() == NO_HITS | {"joint range": 1}


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("axis", NAMES)
def test_a_command_faster_than_the_rate_is_slowed_down_and_counted(axis, way):
    k = NAMES.index(axis)
    fastest = RATES[k]
    for excess, position, hits in (
        (0.0, fastest * PERIOD, 0),
        (0.9e-6, fastest * PERIOD, 0),  # rounding: not worth a count
        (1.1e-6, fastest * PERIOD, 1),
        (2.0, fastest * PERIOD, 1),
    ):
        bench = ServoBench()
        bench.start()
        applied = bench.limit(**at(axis, way * fastest * PERIOD * (1.0 + excess)))
        assert applied.positions[k] == way * position
        assert applied.velocities[k] == way * fastest
        assert [p for j, p in enumerate(applied.positions) if j != k] == [0.0, 0.0]
        assert bench.axes.limit_hits() == NO_HITS | {"joint rate": hits}


def test_a_rate_counts_from_what_was_applied_before():
    bench = ServoBench()
    bench.start(a=0.5)
    assert bench.limit(a=0.75).positions[0] == 0.5 + PERIOD
    assert bench.limit(a=0.75).positions[0] == 0.5 + 2 * PERIOD
    bench.start(a=-0.5)
    assert bench.limit(a=0.75).positions[0] == -0.5 + PERIOD


def test_the_first_command_of_all_is_taken_for_where_the_axes_are():
    bench = ServoBench()
    assert bench.limit(a=0.5, b=-1.0, c=2.0) == ((0.5, -1.0, 2.0), (0.0, 0.0, 0.0))
    assert bench.limit(a=0.5 + PERIOD, b=-1.0, c=2.0).velocities == (1.0, 0.0, 0.0)
    assert bench.axes.limit_hits() == NO_HITS


def test_the_speed_that_is_applied_is_that_of_the_step():
    bench = ServoBench()
    bench.start()
    assert bench.limit(a=0.25 * PERIOD, b=-1.5 * PERIOD).velocities == (0.25, -1.5, 0.0)


def test_a_law_in_half_precision_does_not_make_the_setpoints_coarse():
    bench = ServoBench()
    bench.start()
    bench.limit(a=np.float16(0.25 * PERIOD))
    applied = bench.limit(a=np.float16(0.5 * PERIOD))
    assert [type(one) for one in (*applied.positions, *applied.velocities)] == [float] * 6


def test_only_what_was_limited_is_sent_and_only_once():
    bench = ServoBench()
    bench.start()
    applied = bench.limit(a=PERIOD, b=2 * PERIOD, c=0.5 * PERIOD)
    bench.axes.write(applied)
    bench.axes.write(applied)  # a fault: the drives slow down by themselves
    assert bench.left.sent == [(0.5 * PERIOD, PERIOD)]
    assert bench.right.sent == [(2 * PERIOD,)]


# A stop in mid-motion -----------------------------------------------------------------------


def test_before_anything_moves_resting_is_where_the_axes_are():
    bench = ServoBench()
    bench.place(a=0.5, b=-0.5, c=1.0)
    state = bench.cycle()
    assert bench.axes.resting_command(state) == ((0.5, -0.5, 1.0), (0.0,) * 3)
    assert bench.axes.energised_command(state).positions == (0.5, -0.5, 1.0)
    assert bench.axes.reference_of(state) == ((0.5, -0.5, 1.0), (0.0,) * 3, False)
    assert bench.axes.released_command() == ((0.0,) * 3, (0.0,) * 3)


def test_drives_brake_by_themselves_when_they_are_let_go_of():
    assert ServoBench().axes.brakes_itself is True


def test_what_was_applied_counts_more_than_what_is_measured():
    bench = ServoBench()
    state = bench.start(a=0.5)
    bench.place(a=0.5625)
    bench.limit(a=0.5)
    state = bench.cycle()
    assert bench.axes.energised_command(state) == ((0.5, 0.0, 0.0), (0.0,) * 3)
    assert bench.axes.reference_of(state) == ((0.5, 0.0, 0.0), (0.0,) * 3, False)
    assert bench.axes.released_command() == ((0.5, 0.0, 0.0), (0.0,) * 3)


def test_a_stop_in_mid_motion_ends_where_the_deceleration_leads():
    bench = ServoBench()
    state = bench.start()
    a, b, _ = bench.move(a=1.0, b=-2.0, cycles=4)
    stop = bench.axes.resting_command(state)
    assert stop == ((a + 0.5 / ACCELERATION, b - 2.0 / ACCELERATION, 0.0), (0.0,) * 3)
    assert bench.axes.released_command() == stop


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_a_stop_in_mid_motion_ends_within_the_range(end):
    bench = ServoBench()
    bound, way = (UPPER[0], 1.0) if end == "upper" else (LOWER[0], -1.0)
    state = bench.start(a=bound - way * 2 * PERIOD)
    bench.move(a=way)
    stop = bench.axes.resting_command(state).positions
    assert stop[0] == bound
    for _ in range(20):
        assert LOWER[0] <= bench.limit(*stop).positions[0] <= UPPER[0]
    applied = bench.axes._applied
    assert (applied[0], bench.axes._speeds[0]) == (bound, 0.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_stop_is_reached_under_the_deceleration(way):
    bench = ServoBench()
    state = bench.start()
    bench.move(b=2.0 * way, cycles=3)
    stop = bench.axes.resting_command(state)
    speeds, places = [2.0 * way], []
    for _ in range(40):
        applied = bench.axes.limit(stop)
        speeds.append(applied.velocities[1])
        places.append(way * applied.positions[1])
    changes = [abs(after - before) for before, after in itertools.pairwise(speeds)]
    assert max(changes) == pytest.approx(STEP)
    assert places[-1] == way * stop.positions[1]
    assert speeds[-1] == 0.0
    assert max(places) == pytest.approx(places[-1], abs=1e-15), "it does not swing over"
    assert bench.axes.limit_hits()["joint acceleration"] > 0


def braking(speed, distance):
    """Brake from a speed with a way to go; return the speed that is applied and the counts."""
    bench = ServoBench()
    state = bench.start()
    (_, place, _) = bench.move(b=speed, cycles=2)
    bench.axes.resting_command(state)
    applied = bench.limit(b=place + distance)
    return applied.velocities[1], bench.axes.limit_hits()


def test_a_change_of_speed_by_one_step_of_deceleration_is_no_hit():
    assert braking(STEP, STEP * PERIOD) == (STEP, NO_HITS)
    assert braking(2.0 * STEP, STEP * PERIOD) == (STEP, NO_HITS)
    assert braking(-2.0 * STEP, -STEP * PERIOD) == (-STEP, NO_HITS)
    hit = NO_HITS | {"joint acceleration": 1}
    assert braking(2.0 * STEP + TINY, STEP * PERIOD) == (STEP + TINY, hit)
    assert braking(-2.0 * STEP - TINY, -STEP * PERIOD) == (-STEP - TINY, hit)


def test_beyond_that_the_speed_changes_by_one_step():
    hit = NO_HITS | {"joint acceleration": 1}
    assert braking(0.5, 0.0) == (0.5 - STEP, hit)
    assert braking(-0.5, 0.0) == (-0.5 + STEP, hit)
    assert braking(0.5, -0.25) == (0.5 - STEP, hit)
    assert braking(0.5, 0.25) == (0.5 + STEP, hit)


def test_a_braking_axis_is_no_faster_than_it_can_still_stop():
    falls = [7.5, 6.5, 5.5, 4.5, 3.5, 2.5, 1.5, 0.5]  # in steps of deceleration
    distance = sum(falls) * STEP * PERIOD
    speed, _ = braking(8.0 * STEP, distance)
    assert speed == pytest.approx(7.5 * STEP, rel=1e-12)
    speed, _ = braking(-8.0 * STEP, -distance)
    assert speed == pytest.approx(-7.5 * STEP, rel=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_a_stop_from_any_speed_neither_swings_over_nor_brakes_harder(seed):
    chance = random.Random(seed)
    bench = ServoBench()
    state = bench.start(b=-1.0)
    bench.move(b=chance.uniform(0.01, RATES[1]), cycles=chance.randint(2, 5))
    stop = bench.axes.resting_command(state).positions
    before, speed = bench.axes._applied[1], bench.axes._speeds[1]
    for _ in range(40):
        (_, place, _), (_, now, _) = bench.limit(*stop)
        assert before - 1e-12 <= place <= stop[1] + 1e-12
        assert abs(now - speed) <= STEP + 1e-12
        before, speed = place, now
    assert (place, now) == (pytest.approx(stop[1], abs=1e-12), pytest.approx(0.0, abs=1e-12))


def test_the_range_comes_before_a_gentle_stop():
    bench = ServoBench()
    state = bench.start(b=UPPER[1] - 3 * PERIOD)
    bench.move(b=2.0)
    bench.axes.resting_command(state)
    assert bench.limit(b=UPPER[1]) == ((0.0, UPPER[1], 0.0), (0.0, 1.0, 0.0))
    bench = ServoBench()
    state = bench.start(b=LOWER[1] + 3 * PERIOD)
    bench.move(b=-2.0)
    bench.axes.resting_command(state)
    assert bench.limit(b=LOWER[1]) == ((0.0, LOWER[1], 0.0), (0.0, -1.0, 0.0))


def test_a_new_motion_forgets_where_the_last_one_stopped():
    bench = ServoBench()
    bench.start(a=0.5)
    bench.axes.resting_command(bench.axes.read(0.0))
    bench.start(a=0.25)
    assert bench.axes.released_command().positions == (0.25, 0.0, 0.0)


def test_from_outside_the_range_an_axis_comes_back_at_its_rate():
    bench = ServoBench()
    bench.start(a=UPPER[0] + FOLLOWING)
    assert bench.limit(0.0, 0.0, 0.0).positions[0] == UPPER[0] + FOLLOWING - RATES[0] * PERIOD


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_millionth_more_than_the_rate_is_no_hit(way):
    bench = ServoBench()
    most = 1.0 + 1e-6
    for speed, hits in ((most, 0), (math.nextafter(most, 2.0), 1)):
        bench.start()
        assert bench.limit(way * speed * PERIOD, 0.0, 0.0).positions[0] == way * PERIOD
        assert bench.axes.limit_hits()["joint rate"] == hits


def test_a_new_motion_is_not_braked():
    bench = ServoBench()
    state = bench.start()
    bench.move(b=2.0)
    bench.axes.resting_command(state)
    bench.axes.start_limiting(state)
    assert bench.limit(b=2.0 * PERIOD).velocities[1] == 2.0
    bench.axes.start_limiting(state)
    assert bench.axes.resting_command(state).positions == (0.0, 0.0, 0.0)  # at rest


# What goes between ---------------------------------------------------------------------------


def test_a_blend_goes_from_its_start_to_its_end():
    blend = ServoBench().axes.blend
    start, end = Command((0.0, 1.0, 2.0), (1.0,) * 3), Command((1.0, -1.0, 2.0), (1.0,) * 3)
    assert blend(start, end, 0.0) == (start.positions, (0.0,) * 3)
    assert blend(start, end, 1.0) == (end.positions, (0.0,) * 3)
    assert blend(start, end, 0.25) == ((0.25, 0.5, 2.0), (0.0,) * 3)


def test_at_the_end_of_a_motion_axes_stop_where_it_leaves_them(monkeypatch):
    bench = ServoBench()
    state = bench.start()
    bench.move(a=RATES[0], cycles=4)
    end = (0.5, -0.25, 0.125)
    monkeypatch.setattr(bench.axes, "_end_of_motion", lambda: end)
    assert bench.axes.resting_command(state) == Command(end, (0.0,) * 3)
    assert bench.axes.released_command() == Command(end, (0.0,) * 3)
    # The law's own last step: only rate and range bound it, and no acceleration.
    assert bench.limit(*end).velocities == (RATES[0], -RATES[1], RATES[2])
    assert bench.axes.limit_hits()["joint acceleration"] == 0


def test_an_approach_goes_from_rest_to_rest():
    start, end = Command((0.0, 1.0), ()), Command((1.0, 1.0), ())
    way = ServoAxes.approach_joints
    assert way(Reference, start, end, 2.0, 0.0) == ((0.0, 1.0), (0.0, 0.0), False)
    assert way(Reference, start, end, 2.0, 1.0) == ((0.5, 1.0), (0.9375, 0.0), False)
    positions, velocities, _ = way(Reference, start, end, 2.0, 2.0)
    assert (positions, velocities) == ((1.0, 1.0), (0.0, 0.0))


def test_the_row_has_a_value_for_each_column():
    bench = ServoBench()
    bench.place(1, 2, 3)
    bench.turn(4, 5, 6)
    bench.left.t, bench.right.t = 0.0, PERIOD
    state = bench.axes.read(PERIOD)
    reference = Reference((7, 8, 9), (10, 11, 12), True)
    row = bench.axes.joint_row(
        state, reference, Command((13, 14, 15), (16, 17, 18)), Command((19, 20, 21), (22, 23, 24))
    )
    named = {column.name: value for column, value in zip(servo_columns(NAMES), row, strict=True)}
    numbers = iter(range(1, 25))
    wanted = {}
    for group in ("reading", "reference", "command", "applied"):
        for what in ("position", "velocity"):
            wanted |= {f"{group}.{what}_{name}": next(numbers) for name in NAMES}
    assert named == wanted | {"reading.age": PERIOD}
    assert [column.unit for column in servo_columns(("x",))] == [
        "rad", "rad/s", "s", "rad", "rad/s", "rad", "rad/s", "rad", "rad/s",
    ]  # fmt: skip
