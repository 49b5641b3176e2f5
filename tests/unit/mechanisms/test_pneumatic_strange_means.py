"""What is said of a regulator whose mean is strange: short, slow, or frozen, and by how much."""

import math
import re

import numpy as np
import pytest
from joint_fakes import CHANNELS
from pressure_bench import (
    CALM,
    CYCLES,
    DEVIATION,
    LOOP,
    NEVER,
    START,
    STEP,
    TIME,
    Bench,
)  # fmt: skip
from scipy.signal import lfilter

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.settings import RegulatorModel

OFFSET = 12e3


def told(bench, most=4000, **off):
    """Return what is said of channels that are off for good."""
    with pytest.raises(SafetyError) as caught:
        bench.pass_by(most, **off)
    return str(caught.value)


@pytest.mark.parametrize(("way", "lost"), [(16e3, False), (-16e3, True)])
def test_one_mean_that_falls_may_be_the_supply_that_others_do_not_need_now(way, lost):
    bench = Bench(**CALM)
    bench.pass_by(2000)
    less = (
        ", or its chamber leaks, or the supply pressure is lost"  # air that is too much did not go
    )
    words = f"the regulator of ch2 is stuck or off, or its monitor is off{less * lost} ["
    assert words in told(bench, ch2=way)


def test_the_message_has_the_mean_and_its_bound():
    bench = Bench(**CALM)
    bench.pass_by(2000)
    said = told(bench, ch3=-16e3)
    numbers = re.search(
        r"valves: the regulator of ch3 is stuck or off, or its monitor is off, or its chamber "
        r"leaks, or the supply pressure is lost \[ch3: 184 kPa, setpoint 200 kPa; the mean is "
        r"(.*) kPa off what is usual, at most 12 kPa; as far off as 0.00 of a regulator of half "
        r"the bandwidth, at most "
        r"inf\]",
        said,
    )
    assert float(numbers[1]) == pytest.approx(-12.0, abs=0.1)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_two_means_that_fall_by_half_of_the_bound_are_the_supply(count):
    """From what is usual of each, which is not zero."""
    for short, supply in ((5e3, False), (7e3, True)):
        bench = Bench(**CALM)
        usual = dict(zip(CHANNELS, (9e3, -9e3, 6e3, 0.0), strict=True))
        bench.pass_by(3000, **usual)
        names = CHANNELS[:count]
        off = {name: usual[name] - (30e3 if name == "ch1" else short) for name in names}
        # The mean of one is over its bound only after the other has come near half of it.
        watch = bench.watch
        for channel, name in zip(watch._channels, CHANNELS, strict=True):
            channel.mean = off.get(name, channel.mean)
            channel.usual = usual[name]
        said = watch._explain_strange(0)
        assert ("the supply pressure is lost: " in said) is supply
        if supply:
            assert f"{', '.join(names)} fall short" in said


def test_what_had_more_than_it_was_asked_for_at_rest_cannot_go_so_low():
    """A floor is learnt as usual, and is not there any more where a chamber is filled beyond it."""
    half = 0.5 * OFFSET
    for usual, floor in ((math.nextafter(half, math.inf), True), (half, False)):
        bench = Bench(**CALM)
        bench.pass_by(2)
        for channel in bench.watch._channels:
            channel.usual, channel.mean = OFFSET, -1.0
        bench.watch._channels[1].usual = usual
        said = bench.watch._explain_strange(0)
        assert said.startswith("at rest no regulator goes as low as it was asked to, or ") is floor
        assert "the supply pressure is lost: ch1, ch2, ch3, ch4 fall short" in said


def test_half_of_the_bound_itself_is_not_short():
    bench = Bench(**CALM)
    bench.pass_by(2)
    one, other, *_ = bench.watch._channels
    one.mean, other.mean = -30e3, -0.5 * OFFSET
    assert "fall short" not in bench.watch._explain_strange(0)
    other.mean = math.nextafter(-0.5 * OFFSET, -math.inf)
    assert "supply pressure is lost: ch1, ch2 fall short" in bench.watch._explain_strange(0)


def test_what_is_off_by_half_of_the_deviation_now_is_stuck_or_slow():
    for extra, words in ((0.0, "stuck or off, or its monitor is off ["), (1.0, "or it is slow")):
        bench = Bench(time=NEVER, offset=OFFSET)
        bench.pass_by(2000)
        assert words in told(bench, ch2=0.5 * DEVIATION + extra)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_bounds_themselves_are_kept(way):
    """Half of the deviation is well; the bound of the mean, and 0.7 of what it is off, no jump."""
    bench = Bench()
    bench.pass_by(1, ch2=way * 0.5 * DEVIATION)
    bench.pass_by(1, ch2=way * (0.5 * DEVIATION + 9e3))  # by less than a quarter since it was well
    assert "its pressure stays" in bench.watch.suspicion()
    bench = Bench(offset=OFFSET)
    bench.pass_by(1, ch2=way * OFFSET)
    assert bench.watch._channels[1].jump == OFFSET
    bench.pass_by(1, ch2=way * 45e3)
    channel = bench.watch._channels[1]
    channel.jump = 0.7 * 45e3
    assert "jumped" not in bench.watch.suspicion()
    channel.jump = math.nextafter(0.7 * 45e3, math.inf)
    assert "jumped" in bench.watch.suspicion()


def test_what_jumps_at_the_second_reading_has_its_time_too():
    bounds = PressureBounds(DEVIATION, 4 * STEP, DEVIATION, 4 * STEP, NEVER, 0.4, 2.5e3)
    watch = PressureWatch(bounds, RegulatorModel(), CHANNELS, "valves")
    watch.send((START,) * 4)
    watch.check((START,) * 4, 100.0)
    for cycle in range(4):
        watch.check((START + 50e3, *(START,) * 3), 100.0 + (cycle + 1) * STEP)
    with pytest.raises(SafetyError, match="ch1 is stuck open"):
        watch.check((START + 50e3, *(START,) * 3), 100.0 + 5 * STEP)
    for channel in watch._channels:
        assert channel.quick_at == 100.0 + 5 * STEP


def test_means_are_taken_over_their_times():
    """The mean over four time constants, what is usual over 5 s, slowness over 1 s."""
    rng = np.random.default_rng(5)
    response = RegulatorModel(40.0, 1.0)
    watch = PressureWatch(PressureBounds(*[NEVER] * 7), response, ["a"], "v")
    watch.send([START])
    watch.check([START], 100.0)
    offs, usuals, lags, now = [], [], [], 100.0
    for cycle in range(8000):
        now += STEP
        watch.send([START + 50e3 * math.sin(3e-3 * cycle)])
        watch.check([START + 20e3 + rng.normal(0.0, 5e3)], now)
        channel = watch._channels[0]
        offs.append(channel.off)
        lags.append(channel.slow - channel.expected)
        usuals.append(channel.usual)
    offs, lags, besides = np.array(offs), np.array(lags), np.array(offs) - np.array(usuals)

    def taken_over(values, time):
        share = STEP / (time + STEP)
        return lfilter([share], [1.0, share - 1.0], values)[-1]

    times = np.minimum(STEP * np.arange(1, 8001) + 0.1, 5.0)
    left = np.cumprod((times / (times + STEP))[::-1])[::-1]  # of what was there before each cycle
    weights = np.append(left[1:], 1.0) * STEP / (times + STEP)
    assert channel.usual == pytest.approx(float(weights @ offs))
    assert channel.mean == pytest.approx(taken_over(offs, 0.1))
    assert channel.lag_mean == pytest.approx(taken_over(np.abs(lags), 0.1))
    assert channel.power == pytest.approx(taken_over(besides**2, 1.0))
    assert channel.lag_power == pytest.approx(taken_over(lags**2, 1.0))
    assert channel.likeness == pytest.approx(taken_over(lags * besides, 1.0))


def test_a_motion_that_shows_too_little_shows_no_slowness():
    """Of a slow regulator's deviation there must be more than twice the hysteresis, rms."""
    bench = Bench(deviation=NEVER, slow=0.4, offset=OFFSET)
    bench.pass_by(2)
    channel, bounds = bench.watch._channels[0], bench.watch._bounds
    channel.likeness = 1e7
    channel.lag_power = (2.0 * bounds.loop) ** 2
    assert channel.slowness(bounds) == 0.0
    channel.lag_power = math.nextafter(channel.lag_power, math.inf)
    assert channel.slowness(bounds) == 1e7 / channel.lag_power
    channel.lag_power = 0.25
    assert channel.most_slow(bounds) == bounds.slow + bounds.loop / 0.5
    channel.lag_power = 0.0
    assert channel.most_slow(bounds) == math.inf


def test_what_is_exactly_as_expected_keeps_a_bound_of_nothing():
    Bench(deviation=NEVER, slow=NEVER, offset=0.0).pass_by(100)


@pytest.mark.parametrize(("share", "found"), [(0.8, False), (1.3, True)])
def test_while_a_pressure_moves_its_mean_may_be_off_by_what_a_slow_one_would_be(share, found):
    """Under a sine the bound is `offset` and `slow` of the mean lag of half the bandwidth."""
    bench = Bench(RegulatorModel(40.0, 1.0), deviation=NEVER, slow=0.4, offset=4e3, loop=1e12)
    rate, swing = 2.0 * math.pi * 2.0, 60e3

    def answer(bandwidth):
        return 1.0 / (1.0 + 1j * rate / bandwidth) ** 2

    lag = abs(answer(20.0) - answer(40.0)) * swing * 2.0 / math.pi
    off = share * (4e3 + 0.4 * lag)
    healthy = answer(40.0)
    raised = False
    for cycle in range(6000):
        t = cycle * STEP
        turn = complex(math.cos(rate * t), math.sin(rate * t))
        bench.watch.send((START + swing * turn.imag,) * 4)
        later = turn * complex(math.cos(rate * STEP), math.sin(rate * STEP))
        pressure = swing * (healthy * later).imag * min(cycle / 50, 1.0)
        extra = off * min(max(cycle - 4500, 0) / 50, 1.0)  # what jumps is told at once
        try:
            bench.pass_by(1, ch1=pressure, ch2=pressure, ch3=pressure + extra, ch4=pressure)
        except SafetyError as error:
            assert "[ch3: " in str(error)
            raised = True
            break
    assert raised is found


def test_the_strangest_channel_is_told_of_by_its_share_of_what_is_permitted():
    """Bounds differ from channel to channel: one moves, another stands still."""
    bench = Bench(deviation=NEVER, slow=0.4, offset=OFFSET)
    bench.pass_by(2)
    still, moves, off, calm = bench.watch._channels
    still.mean = 1.6 * OFFSET
    moves.lag_mean, moves.mean = 60e3, 0.95 * (OFFSET + 0.4 * 60e3)
    off.mean, off.usual = 30e3, 28e3
    calm.mean, calm.usual = 0.0, 18e3
    bounds = bench.watch._bounds
    shares = [channel.strangeness(bounds) for channel in bench.watch._channels]
    assert shares == pytest.approx([1.6, 0.95, 2.0 / 12.0, 1.5])
    with pytest.raises(SafetyError, match=r"\[ch1: "):
        bench.watch._raise_strange()


def test_a_slow_channel_is_the_strangest_by_its_share_too():
    """The bound of slowness is `slow` and what the hysteresis hides of the motion."""
    bench = Bench(deviation=NEVER, slow=0.4, offset=OFFSET)
    bench.pass_by(2)
    much, little, *_ = bench.watch._channels
    much.lag_power, much.likeness = 50e3**2, 0.5 * 50e3**2
    little.lag_power, little.likeness = 6e3**2, 0.75 * 6e3**2
    bounds = bench.watch._bounds
    assert much.strangeness(bounds) == pytest.approx(0.5 / (0.4 + 2.5e3 / 50e3))
    assert little.strangeness(bounds) == pytest.approx(0.75 / (0.4 + 2.5e3 / 6e3))
    with pytest.raises(SafetyError, match=r"\[ch1: "):
        bench.watch._raise_strange()


def test_slow_is_what_is_slow_in_size_and_in_shape():
    bench = Bench(deviation=NEVER, slow=0.4, offset=OFFSET)
    bench.pass_by(2)
    channel, bounds = bench.watch._channels[0], bench.watch._bounds
    channel.lag_power = 20e3**2
    least = bounds.slow + bounds.loop / 20e3
    channel.likeness = least * channel.lag_power
    channel.power = 0.0
    assert not channel.is_slow(bounds)
    assert not channel.compare(0.0, 0.0, bounds)
    channel.likeness *= 1.0 + 1e-9
    assert channel.is_slow(bounds)
    assert channel.compare(0.0, 0.0, bounds)
    # In step with a slow one by a share of its power: above the root of 0.6 of the product.
    channel.likeness = 0.75 * channel.lag_power
    limit = channel.likeness**2 / (0.6 * channel.lag_power)
    for power, slow in ((0.999 * limit, True), (1.001 * limit, False)):
        channel.power = power
        assert channel.is_slow(bounds) is slow
    channel.likeness = math.sqrt(0.6 * channel.lag_power * channel.power)
    assert not channel.is_slow(bounds)


def test_a_regulator_is_slow_for_four_time_constants_before_it_is_told():
    """With 64 rad/s they are a sixteenth of a second, a whole number of cycles."""
    bench = Bench(RegulatorModel(64.0, 1.0), deviation=NEVER, slow=0.4, offset=NEVER)
    pressure = rate = 0.0
    slow_since = None
    with pytest.raises(SafetyError, match="the regulator of ch1 is slow"):
        for cycle in range(20_000):
            sent = 60e3 * math.sin(8.0 * cycle * STEP)
            bench.watch.send((START + sent, START, START, START))
            for _ in range(4):  # a quarter of the bandwidth
                step = STEP / 4
                rate = (rate + step * 16.0**2 * (sent - pressure)) / (1.0 + step * 32.0)
                pressure += step * rate
            slow_since = bench.watch._channels[0].quick_at
            bench.pass_by(1, ch1=pressure)
    assert bench.watch._channels[0].quick_at == slow_since
    assert bench.now - slow_since == 4.0 / 64.0 + STEP


@pytest.mark.parametrize(("goes", "is_told"), [(4.7e3, False), (6.5e3, True), (40e3, True)])
def test_a_monitor_that_says_the_very_same_while_its_setpoint_moves_is_frozen(goes, is_told):
    """Its deviation is permitted still; twice the hysteresis is what the pressure has to move."""
    bench = Bench(deviation=NEVER)

    def pass_by(cycles):
        for k in range(cycles):
            noise = 1.0 + k % 2
            bench.pass_by(1, **dict.fromkeys(("ch1", "ch2", "ch4"), noise), ch3=stays or noise)

    stays = 0.0
    pass_by(1024)
    stays = 56.0
    bench.watch.send([START, START, START + goes, START])
    pass_by(2)
    if not is_told:
        pass_by(64 * CYCLES)
        return
    with pytest.raises(SafetyError) as caught:
        pass_by(16 * CYCLES)
    words = (
        r"valves: the monitor of ch3 is frozen, or its regulator is stuck \[ch3: exactly "
        r"200\.1 kPa for (\S+) s, at most 0\.0156 s while a healthy regulator goes by (\S+) kPa\]"
    )
    lasted, gone = map(float, re.fullmatch(words, str(caught.value)).groups())
    assert TIME < lasted < 16 * TIME
    assert 2e-3 * LOOP <= gone < 1.06e-3 * goes


@pytest.mark.parametrize(("value", "is_told"), [(4.0 * LOOP, False), (4.0 * LOOP + 1e3, True)])
def test_an_empty_chamber_is_filled_though_its_monitor_says_the_same_until_then(value, is_told):
    bench = Bench(deviation=NEVER, starts=(value,) * 4)
    for k in range(1024):
        bench.pass_by(1, **dict.fromkeys(CHANNELS, -1.0 - k % 2))
    bench.watch.send([value + 40e3, value, value, value])
    if is_told:
        with pytest.raises(SafetyError, match="the monitor of ch1 is frozen"):
            bench.pass_by(16 * CYCLES)
    else:
        bench.pass_by(16 * CYCLES)
