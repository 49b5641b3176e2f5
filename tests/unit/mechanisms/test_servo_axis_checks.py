"""What is read of axes on servo drives, and what of it is a fault, on either side of each bound."""

import math
import random

import pytest
from pneumatic_fakes import FakeStop
from servo_fakes import (
    AGE,
    FOLLOWING,
    LOWER,
    NAMES,
    RATES,
    TINY,
    UPPER,
    BareAxes,
    Command,
    FakeServo,
    Reference,
    ServoBench,
)

from rig.hal import ConfigurationError, EmergencyStop, LimitExceeded, SafetyError, StaleReading
from rig.hal.quantities import Margin
from rig.mechanisms.servo.axes import AxisLimits, Kinds, ServoAxes
from rig.mechanisms.servo.columns import servo_columns
from rig.mechanisms.servo.settings import ServoLimits, ServoSettings


def wired(*servos):
    return BareAxes(
        AxisLimits(NAMES, LOWER, UPPER, RATES), ServoLimits(), servos, None, Kinds(*[tuple] * 3), 1
    )


def at(axis, angle):
    """Return all positions with one axis at an angle."""
    return {name: angle if name == axis else 0.0 for name in NAMES}


def test_readings_are_put_into_the_mechanisms_order():
    bench = ServoBench()
    bench.place(a=0.25, b=-0.5, c=1.0)
    bench.turn(a=1.0, b=2.0, c=3.0)
    assert bench.cycle(7.0) == (7.0, (0.25, -0.5, 1.0), (1.0, 2.0, 3.0))


@pytest.mark.parametrize("seed", range(8))
def test_a_state_is_recalled_from_its_row_to_the_bit(seed):
    chance = random.Random(seed)
    now = chance.uniform(0.0, 1e3)
    written = ServoBench()
    written.place(*[chance.uniform(low, high) for low, high in zip(LOWER, UPPER, strict=True)])
    written.turn(*[chance.gauss(0.0, 1.0) for _ in NAMES])
    written.left.t, written.right.t = now, now - chance.uniform(0.0, AGE)
    state = written.axes.read(now)
    command = Command(state.positions, state.velocities)
    row = written.axes.joint_row(state, Reference(*command, False), command, command)
    columns = [column.name for column in servo_columns(NAMES)]

    replayed = ServoBench()
    replayed.stop.pressed = True
    logged = dict(zip(columns, row, strict=True)) | {"clock": now}
    assert replayed.axes.recall(logged) == state
    replayed.axes.check(state, now)  # no row tells of the contact
    assert replayed.axes.stop_input() is None
    assert replayed.axes.joint_row(state, Reference(*command, False), command, command) == row


def test_readings_may_be_as_old_as_their_limit():
    bench = ServoBench()
    bench.left.t = bench.right.t = 1.0 - AGE
    assert bench.axes.read(1.0).t == 1.0


@pytest.mark.parametrize("oldest", ["left", "right"])
def test_the_device_with_the_oldest_reading_is_blamed(oldest):
    bench = ServoBench()
    bench.left.t = bench.right.t = 1.0 - 1.5 * AGE
    getattr(bench, oldest).t = 1.0 - 2.0 * AGE
    with pytest.raises(StaleReading) as caught:
        bench.axes.read(1.0)
    error = caught.value
    assert (error.device, error.age, error.bound) == (oldest, 2.0 * AGE, AGE)


def test_of_a_device_the_joint_is_named_that_was_not_heard_of():
    bench = ServoBench()
    bench.left.t, bench.right.t = 1.0 - 2.0 * AGE, 1.0
    bench.left.oldest_axis = "b"
    with pytest.raises(StaleReading, match=r"^left joint b: the last reading is") as caught:
        bench.axes.read(1.0)
    assert caught.value.device == "left"


def test_of_devices_with_equally_old_readings_the_first_is_blamed():
    with pytest.raises(StaleReading, match=r"^left: "):
        ServoBench().axes.read(1.0)


@pytest.mark.parametrize("oldest", ["left", "right"])
def test_a_reading_just_too_old_is_a_fault_beside_a_fresh_one(oldest):
    bench = ServoBench()
    bench.left.t = bench.right.t = 1.0
    getattr(bench, oldest).t = 1.0 - AGE - 2.0**-30
    assert bench.axes.read(1.0).t == 1.0, "times are sums, and rounded"
    getattr(bench, oldest).t = 1.0 - AGE - 2.0**-28
    with pytest.raises(StaleReading) as caught:
        bench.axes.read(1.0)
    assert caught.value.device == oldest


def test_the_emergency_stop_is_heeded_before_anything_else():
    bench = ServoBench()
    bench.place(a=9.0)
    bench.stop.pressed, bench.stop.t = True, -9.0
    with pytest.raises(EmergencyStop, match="pressed or its circuit is open"):
        bench.axes.check(bench.axes.read(0.0), 0.0)


def test_a_stop_that_is_not_read_any_more_is_a_fault_of_its_own():
    bench = ServoBench()
    state = bench.axes.read(0.0)
    bench.stop.t = -AGE
    bench.axes.check(state, 0.0)
    bench.stop.t = -AGE - TINY
    with pytest.raises(StaleReading) as caught:
        bench.axes.check(state, 0.0)
    error = caught.value
    assert (error.device, error.age, error.bound) == (
        "the emergency stop that stop reads",
        AGE + TINY,
        AGE,
    )


def test_the_device_that_reads_the_stop_is_told():
    bench = ServoBench()
    assert bench.axes.stop_input() is bench.stop
    assert wired(FakeServo("all", NAMES)).stop_input() is None


def test_axes_do_without_a_stop():
    servo = FakeServo("all", NAMES)
    axes = wired(servo)
    servo.angles = (1.0, 0.0, 0.0)
    kinds = ServoBench().axes._kinds
    axes.check(kinds.state(0.0, (0.0,) * 3, (0.0,) * 3), 0.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", NAMES)
def test_a_reading_that_is_not_a_number_is_a_fault(axis, bad):
    bench = ServoBench()
    bench.place(**at(axis, bad))
    with pytest.raises(SafetyError, match="not a number"):
        bench.cycle()


@pytest.mark.parametrize("end", ["lower", "upper"])
@pytest.mark.parametrize("axis", NAMES)
def test_an_axis_may_be_beyond_its_range_by_what_it_may_lag(axis, end):
    bench = ServoBench()
    k = NAMES.index(axis)
    bound, way = (UPPER[k], 1.0) if end == "upper" else (LOWER[k], -1.0)
    bench.place(**at(axis, bound + way * FOLLOWING))
    bench.cycle()
    bench.place(**at(axis, bound + way * (FOLLOWING + TINY)))
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle()
    error = caught.value
    assert (error.quantity, error.unit) == (f"position of {axis}", "rad")
    assert (error.lower, error.upper) == (LOWER[k], UPPER[k])
    assert error.value == bound + way * (FOLLOWING + TINY)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("axis", NAMES)
def test_an_axis_may_lag_by_the_limit_and_not_by_more(axis, way):
    bench = ServoBench()
    bench.start()
    bench.place(**at(axis, way * FOLLOWING))
    bench.cycle()
    bench.place(**at(axis, way * (FOLLOWING + TINY)))
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle()
    error = caught.value
    assert error.quantity == f"distance of {axis} from where it was sent"
    assert (error.value, error.lower, error.upper, error.unit) == (
        FOLLOWING + TINY,
        0.0,
        FOLLOWING,
        "rad",
    )


def test_the_axis_that_lags_most_is_named():
    bench = ServoBench()
    bench.start()
    bench.place(a=2 * FOLLOWING, b=-3 * FOLLOWING, c=FOLLOWING)
    with pytest.raises(LimitExceeded, match="distance of b from where it was sent"):
        bench.cycle()


def test_before_anything_was_sent_no_axis_lags():
    bench = ServoBench()
    bench.place(a=0.9, b=-1.9, c=2.9)
    bench.cycle()


def test_a_lag_is_the_distance_from_what_was_applied_and_not_from_what_was_wanted():
    bench = ServoBench(stuck=1.0)
    bench.start()
    bench.limit(a=0.75)  # the rate permits 1/64 rad
    bench.place(a=1 / 64 - FOLLOWING)
    bench.cycle()
    bench.place(a=1 / 64 - FOLLOWING - TINY)
    with pytest.raises(LimitExceeded, match="distance of a"):
        bench.cycle()


@pytest.mark.parametrize(
    ("servos", "message"),
    [
        (({"left": "ab"},), "no servo device has the joint 'c'; they have a, b"),
        (({"left": "abc"}, {"right": "c"}), "left: two drives move the joint 'c'"),
        (
            ({"left": "abc"}, {"right": "d"}),
            "right: the mechanism has no joint 'd'; it has a, b, c",
        ),
    ],
)
def test_devices_must_have_each_axis_once(servos, message):
    made = [FakeServo(name, tuple(axes)) for servo in servos for name, axes in servo.items()]
    with pytest.raises(ConfigurationError) as caught:
        wired(*made)
    assert str(caught.value) == message


def test_devices_are_picked_by_the_names_in_the_profile():
    left, right, stop = FakeServo("left", "a"), FakeServo("right", "b"), FakeStop()
    devices = {"left": left, "right": right, "stop": stop}
    pick = ServoAxes.pick
    assert pick("arm", ServoSettings(("right", "left"), ServoLimits()), devices) == (
        [right, left],
        None,
    )
    with_stop = ServoSettings(("left",), ServoLimits(), "stop")
    assert pick("arm", with_stop, devices) == ([left], stop)
    with pytest.raises(ConfigurationError, match=r"arm\.servos: stop is no ServoBus"):
        pick("arm", ServoSettings(("stop",), ServoLimits()), devices)
    with pytest.raises(ConfigurationError, match=r"arm\.emergency_stop: left is no"):
        pick("arm", ServoSettings(("left",), ServoLimits(), "left"), devices)
    assert ServoAxes.wiring(with_stop) == {}


@pytest.mark.parametrize(
    ("place", "lag", "late", "speed", "nearest"),
    [
        ({}, {"a": 0.75 * FOLLOWING}, 0.0, 0.0, Margin("following error", 0.25)),
        ({}, {"b": -0.75 * FOLLOWING}, 0.0, 0.0, Margin("following error", 0.25)),
        ({}, {}, 0.875 * AGE, 0.0, Margin("reading age", 0.125)),
        ({"a": 0.875}, {}, 0.0, 0.0, Margin("a range", 0.125)),
        ({"b": -1.875}, {}, 0.0, 0.0, Margin("b range", 0.1)),
        ({}, {}, 0.0, 0.375, Margin("c rate", 0.25)),
        ({}, {}, 0.0, -0.375, Margin("c rate", 0.25)),
    ],
)
def test_the_nearest_limit_is_told(place, lag, late, speed, nearest):
    bench = ServoBench()
    bench.start(**({"b": -0.75, "c": 1.25} | place))  # the middle of their ranges
    bench.move(c=speed)
    sent = dict(zip(NAMES, bench.axes._applied, strict=True))
    bench.place(**{name: angle + lag.get(name, 0.0) for name, angle in sent.items()})
    bench.left.t = bench.right.t = bench.stop.t = 1.0 - late
    state = bench.axes.read(1.0)
    bench.axes.check(state, 1.0)
    assert bench.axes.worst_margin(state, None, 1.0) == nearest


def test_before_anything_was_sent_only_readings_and_ranges_are_near_a_limit():
    bench = ServoBench()
    bench.place(a=0.5, b=-0.75, c=1.25)
    assert bench.axes.worst_margin(bench.cycle(), None, 0.0) == Margin("a range", 0.5)


def test_what_a_profile_leaves_out_is_as_its_documentation_says():
    limits = ServoLimits()
    assert (limits.following, limits.reading_age, limits.acceleration) == (0.15, 0.03, 10.0)


def test_a_joint_that_is_sent_away_and_stays_is_told_with_its_device():
    bench = ServoBench(stuck=1 / 128)
    bench.start()
    for cycle in range(1, 4):
        bench.limit(a=cycle / 64)  # as fast as the rate permits
        bench.place(a=cycle / 64)
        bench.cycle()
    with pytest.raises(LimitExceeded, match="way that left joint a was sent and does not go"):
        for cycle in range(4, 40):
            bench.limit(a=cycle / 64)
            bench.cycle()
