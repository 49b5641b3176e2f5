"""Each limit of a pair of cylinders: nothing on the bound, a fault beside it, the right name."""

import math

import pytest
from pneumatic_fakes import (
    AGE,
    BASE,
    HOME,
    MISMATCH,
    PERIOD,
    REACH,
    SPEED,
    TINY,
    PairBench,
    pair_settings,
)  # fmt: skip

from rig.hal import DeviceFault, EmergencyStop, LimitExceeded, SafetyError, StaleReading

CHANNELS = "agonist", "antagonist"
DEVICES = {
    "regulators": "regulators",
    "agonist": "encoder-agonist",
    "antagonist": "encoder-antagonist",
}


def test_the_position_is_half_the_difference_of_the_rods_and_grows_as_the_agonist_pulls_in():
    bench = PairBench()
    bench.place(-0.0625 * HOME, 0.1875 * HOME)
    bench.regulators.reads = (11e3, 22e3)
    assert bench.cycle(0.5) == (0.5, 0.125 * HOME, 11e3, 22e3)


@pytest.mark.parametrize("device", DEVICES)
def test_a_reading_may_be_as_old_as_its_limit(device):
    bench = PairBench()
    bench.cycle(1.0)
    getattr(bench, device).t = 1.0 - AGE
    bench.cycle(1.0, fresh=False)


@pytest.mark.parametrize(("device", "name"), DEVICES.items())
def test_the_device_whose_reading_is_too_old_is_blamed(device, name):
    bench = PairBench()
    for other in DEVICES:  # these are older than need be, and not to blame
        getattr(bench, other).t = 1.0 - 0.5 * AGE
    getattr(bench, device).t = 1.0 - AGE - TINY
    with pytest.raises(StaleReading) as caught:
        bench.cycle(1.0, fresh=False)
    assert (caught.value.device, caught.value.bound) == (name, AGE)
    assert caught.value.age == AGE + TINY


def test_of_several_old_readings_the_oldest_is_blamed():
    for oldest, name in DEVICES.items():
        bench = PairBench()
        for device in DEVICES:
            getattr(bench, device).t = -2.0 * AGE
        getattr(bench, oldest).t = -3.0 * AGE
        with pytest.raises(StaleReading) as caught:
            bench.pair.read(0.0)
        assert (caught.value.device, caught.value.age) == (name, 3.0 * AGE)


def test_of_readings_that_are_equally_old_the_first_device_is_blamed():
    bench = PairBench()
    with pytest.raises(StaleReading, match=r"^encoder-agonist: "):
        bench.pair.read(1.0)
    bench.agonist.t = 1.0
    with pytest.raises(StaleReading, match=r"^encoder-antagonist: "):
        bench.pair.read(1.0)


def test_the_emergency_stop_is_heeded_before_anything_else():
    bench = PairBench()
    bench.move_to(2.0 * REACH)
    bench.stop.pressed, bench.stop.t = True, -1.0
    with pytest.raises(EmergencyStop, match="pressed or its circuit is open"):
        bench.cycle(0.0, fresh=False)


def test_a_stop_that_is_not_read_any_more_is_a_fault_of_its_own():
    bench = PairBench()
    bench.stop.t = -AGE
    bench.cycle(0.0, fresh=False)
    bench.stop.t = -AGE - TINY
    with pytest.raises(StaleReading) as caught:
        bench.cycle(0.0, fresh=False)
    assert (caught.value.device, caught.value.age, caught.value.bound) == (
        "the emergency stop that stop reads",
        AGE + TINY,
        AGE,
    )


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("where", [0, 1, 2])
def test_a_reading_that_is_not_a_number_is_a_fault(where, bad):
    bench = PairBench()
    pressures = [1e5, 1e5]
    if where == 2:
        bench.agonist.extension = bad
    else:
        pressures[where] = bad
    bench.regulators.reads = tuple(pressures)
    with pytest.raises(SafetyError, match="not a number"):
        bench.cycle(0.0)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_position_may_reach_its_limit_and_not_pass_it(sign):
    bench = PairBench()
    bench.move_to(sign * REACH)
    bench.cycle(0.0)
    bench.move_to(sign * (REACH + TINY))
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle(PERIOD)
    error = caught.value
    assert error.quantity == "position of the pair"
    assert (error.value, error.lower, error.upper, error.unit) == (
        sign * (REACH + TINY),
        -REACH,
        REACH,
        "m",
    )


@pytest.mark.parametrize("sign", [1, -1])
def test_the_rods_may_disagree_by_the_limit_and_not_by_more(sign):
    bench = PairBench()
    bench.place(sign * MISMATCH, sign * MISMATCH)
    bench.cycle(0.0)
    bench.place(sign * (MISMATCH + TINY), sign * (MISMATCH + TINY))
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle(PERIOD)
    error = caught.value
    # A wire holds its rod back: one that is slack lets it in, and none pushes it out.
    slack = "a wire is slack, or " if sign < 0 else ""
    lies = f"{slack}encoder-agonist or encoder-antagonist drifts or has a wrong scale, "
    lies += "or wires are softer than the profile says"
    cause = f"{lies}; or the carriage was pushed"
    assert error.quantity == f"mismatch of the two rods ({cause})"
    assert (error.value, error.lower, error.upper, error.unit) == (
        sign * (MISMATCH + TINY),
        -MISMATCH,
        MISMATCH,
        "m",
    )


def test_while_no_chamber_pulls_the_carriage_may_have_been_pushed():
    """Below half of the breakaway force at the pistons a wire may be slack."""
    taut = 0.5 * pair_settings().friction.breakaway / pair_settings().area
    full, empty = taut + 1.0, taut - 1.0
    for pressures, pushed in (
        ((BASE, BASE), False), ((taut, taut), False), ((full, empty), True), ((empty, full), True),
    ):  # fmt: skip
        bench = PairBench()
        bench.regulators.reads = pressures
        bench.cycle(0.0)
        bench.place(MISMATCH + TINY, MISMATCH + TINY)
        with pytest.raises(LimitExceeded) as caught:
            bench.cycle(PERIOD)
        words = "; or the carriage was pushed while its wires were slack)"
        assert caught.value.quantity.endswith(words) is pushed, pressures


@pytest.mark.parametrize("frozen", ["agonist", "antagonist"])
def test_a_rod_that_has_not_moved_since_they_agreed_is_named(frozen):
    bench = PairBench()
    bench.cycle(0.0)
    moves = 2.0 * MISMATCH + 2.0 * TINY
    bench.place(*((0.0, moves) if frozen == "agonist" else (moves, 0.0)))
    with pytest.raises(LimitExceeded, match=rf"\(encoder-{frozen} is frozen\)"):
        bench.cycle(PERIOD)


@pytest.mark.parametrize("behind", ["agonist", "antagonist"])
def test_a_rod_whose_chamber_is_empty_stays_behind_a_push_and_is_not_frozen(behind):
    bench = PairBench()
    bench.regulators.reads = (0.0, 0.0)
    bench.cycle(0.0)
    moves = 2.0 * MISMATCH + 2.0 * TINY
    bench.place(*((0.0, moves) if behind == "agonist" else (moves, 0.0)))
    with pytest.raises(LimitExceeded, match=rf"the rod of {behind} stays behind.*was pushed"):
        bench.cycle(PERIOD)


@pytest.mark.parametrize("pulled", [0, 1])
@pytest.mark.parametrize(
    ("out", "runs_in", "is_push"),
    [
        (0.4, 0.4, True),
        (0.4, 0.05, True),
        (0.4, 0.03, False),
        (0.1, 0.1, False),
        (-0.4, 0.4, False),
    ],
)
def test_a_rod_that_is_pulled_out_before_its_encoder_complains_was_pushed(
    pulled, out, runs_in, is_push
):
    """Ways of the last whole cycle, over what the permitted speed covers in it."""
    bench, way = PairBench(), SPEED * PERIOD
    bench.cycle(0.0)
    ways = [-runs_in * way, -runs_in * way]
    ways[pulled] = out * way
    bench.place(*ways)
    state = bench.cycle(PERIOD)
    name = f"encoder-{CHANNELS[pulled]}"
    error = DeviceFault(name, "it jumps")
    found = bench.pair.explain(error, state)
    if is_push:
        assert str(found) == (
            f"the carriage was pushed or struck: it pulls the rod of {CHANNELS[pulled]} out "
            f"({error})"
        )
    else:
        assert found is error


def test_a_rod_is_frozen_since_it_moved_last():
    bench = PairBench()
    bench.cycle(0.0)
    both = 0.5 * MISMATCH
    bench.place(both, both)
    bench.cycle(PERIOD)
    bench.place(both + 3.0 * MISMATCH, both)  # the antagonist stands since then, not since home
    with pytest.raises(LimitExceeded, match=r"\(encoder-antagonist is frozen\)"):
        bench.cycle(2.0 * PERIOD)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_pair_may_go_as_fast_as_its_limit_and_not_faster(sign):
    window = 2.0**-6
    for beyond, fault in ((0.0, False), (TINY, True)):
        bench = PairBench()
        bench.cycle(0.0)
        bench.move_to(sign * (SPEED * window + beyond))
        if not fault:
            bench.cycle(window)
            continue
        with pytest.raises(LimitExceeded) as caught:
            bench.cycle(window)
        error = caught.value
        assert error.quantity == "speed of the pair"
        assert error.value == sign * (SPEED + TINY / window)
        assert (error.lower, error.upper, error.unit) == (-SPEED, SPEED, "m/s")


def test_the_speed_is_judged_over_ten_milliseconds():
    bench = PairBench()
    bench.cycle(0.0)
    bench.move_to(0.8 * REACH)
    bench.cycle(math.nextafter(0.01, 0.0))
    with pytest.raises(LimitExceeded, match="speed of the pair"):
        bench.cycle(0.01)


def test_each_window_of_speed_starts_where_the_last_one_ended():
    bench = PairBench()
    window = 2.0**-6
    bench.cycle(0.0)
    bench.cycle(window)  # at rest
    bench.move_to(SPEED * window + TINY)
    with pytest.raises(LimitExceeded) as caught:
        bench.cycle(2.0 * window)
    assert caught.value.value == SPEED + TINY / window


def test_a_new_motion_forgets_where_the_pair_was():
    bench = PairBench()
    state = bench.cycle(0.0)
    bench.move_to(0.9 * REACH)
    bench.pair.start_limiting(state)
    bench.cycle(0.01)  # would be fast
    bench.move_to(-0.9 * REACH)
    with pytest.raises(LimitExceeded, match="speed"):
        bench.cycle(0.02)
