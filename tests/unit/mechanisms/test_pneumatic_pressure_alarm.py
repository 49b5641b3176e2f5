"""A regulator that is stuck: how far, for how long, and which words for which signs."""

import math
import re

import numpy as np
import pytest
from joint_fakes import CHANNELS
from pressure_bench import (
    CALM,
    CYCLES,
    DEVIATION,
    NEVER,
    START,
    STEP,
    Bench,
    pressure_bounds,
)  # fmt: skip

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.settings import RegulatorModel


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("channel", CHANNELS)
def test_a_pressure_may_be_off_by_the_deviation_for_ever(channel, sign):
    bench = Bench()
    bench.pass_by(10 * CYCLES, **{channel: sign * DEVIATION})
    bench.pass_by(CYCLES, **{channel: sign * (DEVIATION + 1.0)})
    with pytest.raises(SafetyError, match=rf"^valves: .*regulator of {channel}.* \[{channel}: "):
        bench.pass_by(1, **{channel: sign * (DEVIATION + 1.0)})


def test_the_message_has_the_numbers_and_their_bounds():
    assert Bench().what(ch3=50e3) == (
        "valves: the regulator of ch3 is stuck open: its pressure rises [ch3: 250 kPa, setpoint "
        "200 kPa, +50 kPa off a healthy regulator for 0.017 s, at most 40 kPa for 0.0156 s]"
    )


def test_a_pressure_that_was_well_meanwhile_has_its_time_again():
    bench = Bench()
    for _ in range(3):
        bench.pass_by(CYCLES, ch2=-50e3)
        bench.pass_by(1)
    bench.what(ch2=-50e3)


def test_the_channel_that_was_off_first_is_the_one_that_is_told_of():
    bench = Bench()
    bench.pass_by(1, ch4=50e3)
    with pytest.raises(SafetyError, match=r"\[ch4: "):
        bench.pass_by(CYCLES, ch1=45e3, ch4=50e3)


def test_the_signs_say_what_is_stuck():
    moved = 0.25 * DEVIATION
    assert "ch1 is stuck open: its pressure rises" in Bench().what(ch1=50e3)
    assert "ch1 is stuck venting, or its tube is off: its pressure falls" in Bench().what(ch1=-50e3)
    # The setpoint moves and the pressure hardly does: by a quarter of the deviation.
    for setpoint, way, said, beyond in (
        (START - 100e3, 1.0, "stuck closed: its pressure stays", "stuck open"),
        (START + 100e3, -1.0, "stuck closed, or its chamber leaks: its pres", "stuck venting"),
    ):
        for extra, words in ((0.0, said), (1.0, beyond)):
            bench = Bench()
            bench.watch.send((START, setpoint, START, START))
            with pytest.raises(SafetyError) as caught:
                while True:
                    was_well = bench.watch._channels[1].well_at
                    gone = was_well < bench.now  # from then on it has moved
                    bench.pass_by(1, ch2=way * (moved + extra) if gone else 0.0)
            assert f"the regulator of ch2 is {words}" in str(caught.value)


def test_several_that_fall_short_are_the_supply():
    half = 0.5 * DEVIATION
    assert "supply pressure is lost: ch1, ch4 fall short" in Bench().what(
        ch1=-50e3, ch4=-half - 1.0
    )
    assert "the regulator of ch1" in Bench().what(ch1=-50e3, ch4=-half)
    assert "supply pressure is lost: ch1, ch2, ch3, ch4 fall short" in Bench().what(
        ch1=-50e3, ch2=-50e3, ch3=-50e3, ch4=-50e3
    )
    # What is worst is not short of anything: the others are not the supply's.
    assert "the regulator of ch2 is stuck open" in Bench().what(ch1=-45e3, ch2=50e3, ch3=-45e3)


def test_of_two_that_are_off_the_further_one_is_named():
    assert "the regulator of ch3 is stuck open" in Bench().what(ch1=45e3, ch3=50e3)


def test_a_suspicion_needs_half_of_the_deviation():
    bench = Bench()
    bench.pass_by(1, ch2=0.5 * DEVIATION, ch3=-0.5 * DEVIATION)
    assert bench.watch.suspicion() is None
    bench.pass_by(1, ch2=0.5 * DEVIATION + 1.0)
    said = bench.watch.suspicion()
    assert said.startswith("valves: the regulator of ch2 is stuck closed: its pressure stays")
    assert said.endswith("[ch2: +20 kPa off a healthy regulator, at most 40 kPa]")
    bench.pass_by(1, ch2=10e3, ch3=-0.5 * DEVIATION - 1.0)
    assert "the regulator of ch3" in bench.watch.suspicion()
    fresh = PressureWatch(pressure_bounds(), RegulatorModel(), CHANNELS, "valves")
    assert fresh.suspicion() is None


@pytest.mark.parametrize(
    ("off", "words"),
    [
        (21e3, "is stuck open: its pressure rises"),
        (39e3, "is stuck open: its pressure rises"),
        (-21e3, "is stuck venting, or its tube is off: its pressure falls"),
        (-39e3, "is stuck venting, or its tube is off: its pressure falls"),
    ],
)
@pytest.mark.parametrize("channel", CHANNELS)
def test_a_suspicion_says_where_the_pressure_went(channel, off, words):
    """Between half of the deviation and the whole of it, too."""
    bench = Bench()
    bench.pass_by(3, **{channel: off})
    assert f"the regulator of {channel} {words}" in bench.watch.suspicion()


def follow(response, model, deviation, duration=0.3):
    """Let pressures answer a step of setpoints as `model` says; the watch believes in `response`.

    The model is the closed form of second order under, at or above critical damping.
    """
    bench = Bench(response, deviation=deviation, time=STEP)
    bench.watch.send((START + 100e3,) * 4)
    rate, damping = model
    began = bench.now
    while bench.now < began + duration:
        t = bench.now + STEP - began
        root = math.sqrt(abs(damping**2 - 1.0)) * rate
        if damping < 1.0:
            both = math.cos(root * t), math.sin(root * t) / root
        else:
            both = math.cosh(root * t), math.sinh(root * t) / root
        share = 1.0 - math.exp(-damping * rate * t) * (both[0] + damping * rate * both[1])
        bench.pass_by(1, **dict.fromkeys(CHANNELS, 100e3 * share))


@pytest.mark.parametrize("model", [(40.0, 0.7), (40.0, 1.3), (60.0, 0.9)])
def test_a_healthy_regulator_is_of_second_order(model):
    response = RegulatorModel(*model, dead_time=0.0)
    follow(response, model, 2.5e3)
    rate, damping = model
    for other in ((1.15 * rate, damping), (0.85 * rate, damping), (rate, 1.2 * damping)):
        with pytest.raises(SafetyError):
            follow(response, other, 2.5e3)


def test_a_pressure_stays_where_it_was_when_it_was_last_well():
    """All rise by 100 kPa; on the way down one stays up."""
    bench = Bench()
    with pytest.raises(SafetyError, match="ch2 is stuck closed: its pressure stays"):
        for cycle in range(800):
            bench.watch.send((START + 100e3 if cycle < 400 else START,) * 4)
            turns = 40.0 * STEP * (cycle % 400 + 1)
            share = 1.0 - math.exp(-turns) * (1.0 + turns)
            up = 100e3 * (share if cycle < 400 else 1.0 - share)
            stays = max(up, 100e3 * (cycle > 400)) + cycle % 2  # as its monitor's noise has it
            bench.pass_by(1, ch1=up, ch2=stays, ch3=up, ch4=up)
    assert 400 < cycle < 500


def test_time_that_stands_still_or_goes_back_starts_anew():
    for step in (0.0, -1.0):
        bench = Bench()
        bench.pass_by(CYCLES, ch1=50e3)
        bench.now += step
        bench.watch.check((START + 50e3, *(START,) * 3), bench.now)
        # It has just been well where it is; 50 kPa over its setpoint it would be on its way down.
        bench.watch.send((START + 50e3, *(START,) * 3))
        bench.pass_by(3 * CYCLES, ch1=50e3)


def test_nothing_is_expected_before_the_first_setpoints():
    watch = PressureWatch(pressure_bounds(), RegulatorModel(), CHANNELS, "valves")
    for cycle in range(5 * CYCLES):
        watch.check((cycle * 50e3,) * 4, cycle * STEP)


# The mean, and slowness ---------------------------------------------------------------------------

MEAN_TIME, USUAL_TIME = 4.0 / 40.0, 5.0
SETTLED = 2048
"""Cycles after which what is usual follows far more slowly than the mean."""


def cycles_until(raises, bench, most, **off):
    for cycle in range(most):
        try:
            bench.pass_by(1, **off)
        except SafetyError as error:
            assert raises in str(error)
            return cycle + 1
    return None


@pytest.mark.parametrize("seed", range(4))
def test_a_monitor_that_is_off_for_good_is_found_by_its_mean(seed):
    """The mean comes near within four time constants; what is usual, over seconds."""
    rng = np.random.default_rng(seed)
    off, channel = rng.choice([-1.0, 1.0]) * rng.uniform(14e3, 60e3), CHANNELS[rng.integers(4)]
    bench = Bench(**CALM)
    bench.pass_by(8 * round(USUAL_TIME / STEP))
    took = cycles_until(
        f"of {channel} is stuck or off, or its monitor is off", bench, 4000, **{channel: off}
    )
    share = 12e3 / abs(off)  # of the way, which the usual goes too, but 50 times as slowly
    assert took * STEP == pytest.approx(-MEAN_TIME * math.log(1.0 - share), rel=0.2)


@pytest.mark.parametrize("bandwidth", [400.0, 1500.0])
def test_the_mean_of_a_quick_valve_is_taken_over_as_long_as_a_slip_lasts(bandwidth):
    quick = RegulatorModel(bandwidth=bandwidth, dead_time=0.0)
    bench = Bench(quick, **CALM)
    bench.pass_by(8 * round(USUAL_TIME / STEP))
    took = cycles_until("of ch2 is stuck or off, or its monitor is off", bench, 4000, ch2=20e3)
    assert took * STEP == pytest.approx(-0.05 * math.log(1.0 - 12.0 / 20.0), rel=0.05)


def test_what_a_regulator_is_off_from_the_start_is_usual():
    """As one is that nobody has calibrated: for more there is the deviation."""
    bench = Bench(**CALM)
    for _ in range(4000):
        bench.pass_by(1, ch1=20e3, ch2=-20e3)
    assert cycles_until("ch2", bench, 4000, ch1=20e3, ch2=-35e3) is not None


def swing(bench, rng, channel, factor):
    """Swing all setpoints, one regulator being slower; yield its deviation and what is said."""
    rates, pressures = [0.0] * 4, [START] * 4
    phase, frequency = rng.uniform(0.0, 6.0), rng.uniform(0.5, 2.0)
    for cycle in range(4000):
        away = 60e3 * math.sin(2.0 * math.pi * frequency * cycle * STEP + phase)
        sent = [START + (-1.0) ** k * away for k in range(4)]
        bench.watch.send(sent)
        for k in range(4):
            rate = 40.0 / (factor if k == channel else 1.0)
            for _ in range(4):
                step = STEP / 4
                pull = rate**2 * (sent[k] - pressures[k])
                rates[k] = (rates[k] + step * pull) / (1.0 + step * 2.0 * rate)
                pressures[k] += step * rates[k]
        off = {name: p - START for name, p in zip(CHANNELS, pressures, strict=True)}
        said = None
        try:
            bench.pass_by(1, **off)
        except SafetyError as error:
            said = str(error)
        yield bench.watch._channels[channel].off, said


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.2, 1.4, 1.8, 2.5, 3.0])
@pytest.mark.parametrize("seed", range(2))
def test_a_regulator_that_takes_much_longer_is_slow(seed, factor):
    rng = np.random.default_rng(seed)
    channel = int(rng.integers(4))
    bench = Bench(deviation=NEVER, offset=NEVER, slow=0.4)
    seen = next((said for _, said in swing(bench, rng, channel, factor) if said), None)
    if factor >= 1.8:
        assert f"the regulator of {CHANNELS[channel]} is slow [" in seen  # and not late
    else:
        assert seen is None


def test_a_setpoint_that_stands_still_shows_no_slowness():
    bench = Bench(deviation=NEVER, offset=NEVER, slow=0.4)
    for k in range(4000):
        bench.pass_by(1, ch1=10e3 * math.sin(0.1 * k))


@pytest.mark.parametrize("seed", range(2))
def test_a_regulator_that_is_slow_is_suspected_of_that_and_of_nothing_else(seed):
    """A fault that comes of it asks for the suspicion."""
    rng = np.random.default_rng(seed)
    channel = int(rng.integers(4))
    bench = Bench(deviation=10e3, time=NEVER, offset=NEVER, slow=0.4)
    suspicions = [
        str(bench.watch.suspicion())
        for off, said in swing(bench, rng, channel, 2.5)
        if said and abs(off) > 5e3
    ]
    assert len(suspicions) > 100
    words = f"valves: the regulator of {CHANNELS[channel]} is slow"
    assert all(suspicion.startswith(words) for suspicion in suspicions)


@pytest.mark.parametrize("seed", range(4))
def test_several_whose_means_fall_are_the_supply(seed):
    rng = np.random.default_rng(seed)
    low = sorted(rng.choice(CHANNELS, size=rng.integers(2, 5), replace=False))
    bench = Bench(**CALM)
    bench.pass_by(SETTLED)
    words = f"the supply pressure is lost: {', '.join(low)} fall short, or all are slow ["
    assert cycles_until(words, bench, 4000, **dict.fromkeys(low, -30e3)) is not None


@pytest.mark.parametrize(
    ("off", "words"), [(30e3, "stuck open: its pressure rises"), (-30e3, "stuck venting, or its")]
)
@pytest.mark.parametrize("channel", CHANNELS)
def test_what_is_far_off_in_the_mean_is_stuck_or_slow(channel, off, words):
    bench = Bench(time=NEVER, offset=12e3)
    bench.pass_by(SETTLED)
    with pytest.raises(SafetyError, match=f"regulator of {channel} is {words}.*, or it is slow"):
        bench.pass_by(4000, **{channel: off})


# Dead time ----------------------------------------------------------------------------------------


def late_by(dead, seed, told):
    """Let all setpoints swing, and pressures answer after a dead time; return deviations and lags.

    The watch is told another one, or the same.
    """
    rng = np.random.default_rng(seed)
    bench = Bench(RegulatorModel(dead_time=told), deviation=NEVER, offset=NEVER, slow=NEVER)
    rate = pressure = 0.0
    queue = [0.0] * round(dead / STEP)
    frequency, size = rng.uniform(0.5, 4.0), rng.uniform(30e3, 90e3)
    found = []
    for cycle in range(1000):
        sent = size * math.sin(2.0 * math.pi * frequency * cycle * STEP)
        bench.watch.send((START + sent,) * 4)
        queue.append(sent)
        acting = queue.pop(0)
        rate = (rate + STEP * 1600.0 * (acting - pressure)) / (1.0 + STEP * 80.0)
        pressure += STEP * rate
        bench.pass_by(1, **dict.fromkeys(CHANNELS, pressure))
        channel = bench.watch._channels[2]
        found.append((channel.off, channel.slow - channel.expected))
    return np.array(found[300:])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("cycles", [0, 1, 16])
def test_a_healthy_regulator_answers_after_its_dead_time(cycles, seed):
    dead = cycles * STEP
    off, lag = late_by(dead, seed, dead).T
    assert np.abs(off).max() < 1e-6
    assert np.abs(lag).max() > 1e3
    if cycles:
        assert np.abs(late_by(dead, seed, dead - STEP)[:, 0]).max() > 50.0


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("cycles", [0, 5, 15])
def test_one_that_answers_sooner_is_healthy_too(cycles, seed):
    """What is told may be a guess, or the worst channel's; only where it turns round it shows."""
    off, lag = late_by(cycles * STEP, seed, 16 * STEP).T
    assert np.abs(off).max() < 0.1 * np.abs(lag).max()
    assert np.mean(np.abs(off) > 1e-6) < 0.2


@pytest.mark.parametrize("more", [4e-3, 10e-3])
@pytest.mark.parametrize("seed", range(2))
def test_a_regulator_that_is_late_is_not_called_slow(seed, more):
    """It is by as much in step with a slow one as it is late: less than a healthy one may be."""
    off, lag = late_by(16 * STEP + more, seed, 16 * STEP).T
    assert (off @ lag) / (lag @ lag) < 0.5


def test_setpoints_from_before_a_pause_are_forgotten():
    bench = Bench(RegulatorModel(dead_time=8 * STEP), deviation=NEVER, slow=NEVER, offset=NEVER)
    bench.watch.send((START + 100e3,) * 4)
    bench.pass_by(4)
    bench.now -= STEP
    bench.watch.send((START,) * 4)
    bench.pass_by(200)
    assert bench.watch._channels[0].expected == START


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("jump", [25e3, -25e3])
def test_a_monitor_that_jumps_is_told_at_once_whatever_else_is_permitted(channel, jump):
    bench = Bench(deviation=NEVER, slow=NEVER, offset=12e3)
    for cycle in range(50):
        bench.pass_by(1, **dict.fromkeys(CHANNELS, 10.0 * (cycle % 3)))
    bench.pass_by(1, **{channel: jump})
    bench.pass_by(1, **{channel: jump + 10.0})
    size = re.escape(f"{jump * 1e-3:+.0f}")
    told = rf"the monitor of {channel} has jumped.*\[{channel}: by {size} kPa .* 24 kPa"
    with pytest.raises(SafetyError, match=told):
        bench.pass_by(1, **{channel: jump})


def test_no_monitor_jumps_by_less_than_twice_the_offset_at_rest():
    bench = Bench(deviation=NEVER, slow=NEVER, offset=12e3)
    for cycle in range(50):
        bench.pass_by(1, ch1=10.0 * (cycle % 3))
    bench.pass_by(3, ch1=23.9e3)


def test_pressures_after_time_that_went_back_are_held_against_none_before():
    bench = Bench(deviation=NEVER, slow=NEVER, offset=12e3)
    for cycle in range(50):
        bench.pass_by(1, ch1=10.0 * (cycle % 3))
    bench.now -= 2.0 * STEP
    for cycle in range(5):
        bench.pass_by(1, ch1=50e3 + 10.0 * (cycle % 3))
