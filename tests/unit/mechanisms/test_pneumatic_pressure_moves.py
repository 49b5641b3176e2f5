"""What is said of a pressure that is off, by whether it moves as its setpoint does."""

import math

import numpy as np
import pytest
from joint_fakes import CHANNELS
from pressure_bench import DEVIATION, NEVER, START, STEP, Bench

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.settings import RegulatorModel

OFFSET = 12e3
FILLS = "the regulator of ch2 fills faster than it empties, or its monitor is off"
ANY = "the regulator of ch2 is stuck or off, or its monitor is off"
STUCK = "the regulator of ch2 is stuck "
USUAL = -(2.0**14)
"""Deviation that ch2 has had from the start, Pa: no other changes by it."""


def swung(share, seed, mean=16e3, off=1.0, slowness=0.0):
    """Return what is said of ch2, which goes a share of a healthy one's way, and is far off."""
    rng = np.random.default_rng(seed)
    bench = Bench(deviation=NEVER, slow=NEVER, offset=NEVER)
    turn, size = 2.0 * math.pi * rng.uniform(4.0, 7.0), rng.uniform(80e3, 120e3)
    for cycle in range(400):
        bench.watch.send((START + size * math.sin(turn * cycle * STEP),) * 4)
        went = [channel.expected - START for channel in bench.watch._channels]
        bench.pass_by(1, **dict(zip(CHANNELS, went, strict=True)) | {"ch2": share * went[1]})
    watch = bench.watch
    watch._bounds = bounds = watch._bounds._replace(offset=OFFSET, deviation=DEVIATION, slow=0.4)
    channel = watch._channels[1]
    channel.usual, channel.off, channel.power = USUAL, off, 100.0 * size**2
    channel.mean = USUAL + mean
    channel.likeness = slowness * channel.most_slow(bounds) * channel.lag_power
    for other in (0, 2, 3):
        watch._channels[other].off = 0.0
    return watch, watch._explain_strange(1)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("share", "words"),
    [(1.5, FILLS), (0.55, FILLS), (0.45, ANY), (0.3, ANY), (0.2, STUCK), (0.0, STUCK)],
)
def test_a_pressure_that_is_high_in_the_mean_is_told_of_by_how_far_it_goes(share, words, seed):
    watch, said = swung(share, seed)
    # The bench has the healthy motion one cycle late.
    assert watch._ways.share_gone(1, 10e3) == pytest.approx(share, rel=0.03, abs=1e-9)
    assert words in said
    assert ("or it is slow" in said) is (share < 0.25)


@pytest.mark.parametrize(("share", "words"), [(0.25, ANY), (0.5, ANY), (0.5 + 1e-9, FILLS)])
def test_a_quarter_of_the_way_is_not_held_and_half_of_it_not_followed(share, words, monkeypatch):
    watch, _ = swung(1.0, 1)
    for way in ("share_gone", "follows"):
        monkeypatch.setattr(watch._ways, way, lambda k, least: share)
    assert words in watch._explain_strange(1)


@pytest.mark.parametrize(
    ("mean", "words"),
    [(-16e3, ANY), (0.5 * OFFSET, ANY), (0.5 * OFFSET + 2.0**-30, FILLS)],
)
def test_what_is_not_high_in_the_mean_does_not_fill_faster(mean, words):
    assert words in swung(1.0, 1, mean=mean)[1]


@pytest.mark.parametrize(("mean", "leaks"), [(1.0, False), (0.0, False), (-1.0, True)])
def test_only_what_is_low_in_the_mean_may_leak(mean, leaks):
    said = swung(1.0, 1, mean=mean)[1]
    assert ANY in said
    assert ("its chamber leaks" in said) is leaks


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_far_off_is_stuck_however_it_moved(sign):
    """A pressure that rises to the supply's goes a long way too."""
    more = math.nextafter(DEVIATION, math.inf)
    assert FILLS in swung(1.0, 1, off=sign * DEVIATION)[1]
    assert "stuck" in swung(1.0, 1, off=sign * more)[1]
    # Between half of it and all of it what is not high may be stuck, or slow.
    half = 0.5 * DEVIATION
    assert ANY in swung(1.0, 1, mean=-16e3, off=sign * half)[1]
    said = swung(1.0, 1, mean=-16e3, off=sign * math.nextafter(half, math.inf))[1]
    assert "stuck" in said and said.endswith(", or it is slow")


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_what_is_slow_in_size_and_not_in_shape_is_late(share):
    assert "late" not in swung(share, 2, slowness=1.0)[1]
    late = "the regulator of ch2 is slow, or answers late"
    assert swung(share, 2, slowness=1.0 + 1e-9, off=2.0 * DEVIATION)[1] == late
    assert STUCK in swung(0.1, 2, slowness=2.0)[1]


@pytest.mark.parametrize("far", [1.0, -1.0])
def test_what_is_beyond_all_that_a_healthy_one_had_does_not_come_late(far, monkeypatch):
    watch, _ = swung(1.0, 2, slowness=2.0, off=far * 2.0 * DEVIATION)
    late = "the regulator of ch2 is slow, or answers late"
    for beyond, is_late in ((DEVIATION, True), (math.nextafter(DEVIATION, math.inf), False)):
        monkeypatch.setattr(watch._ways, "beyond", lambda k, far=beyond: far)
        said = watch._explain_strange(1)
        assert (said == late) is is_late
    assert "stuck" in said and said.endswith(", or it is slow")


def test_four_time_constants_of_the_past_are_looked_at():
    """With 64 rad/s these are 64 cycles of a 1024th of a second."""
    bench = Bench(RegulatorModel(64.0, 1.0, dead_time=0.0))
    bench.pass_by(500)
    past = bench.watch._ways._past
    assert len(past) == 65
    assert past[-1][0] == bench.now and past[0][0] == bench.now - 64 * STEP
    bench.now -= STEP
    bench.pass_by(3)
    assert len(past) == 2


@pytest.mark.parametrize("seed", range(2))
def test_of_what_hardly_moves_nothing_is_said_but_that_it_is_off(seed):
    """A healthy one must have gone by more than twice the hysteresis, rms."""
    watch, said = swung(0.0, seed)
    assert STUCK in said
    healthy = np.std([row[1] for _, _, row in watch._ways._past])
    for loop, words in ((0.499 * healthy, STUCK), (0.501 * healthy, ANY)):
        watch._bounds = watch._bounds._replace(loop=loop)
        assert words in watch._explain_strange(1)


RATE, SLOW, LOOP = 95e3, 0.5, 2.5e3
"""A chamber fills by so many Pa/s, which a regulator of half the bandwidth is 4.75 kPa late for."""


def filled(slowed, static, bandwidth=40.0, since=0.0):
    """Return what is said of a regulator so many times slower in a long ramp, and what is usual."""
    bounds = PressureBounds(NEVER, NEVER, NEVER, NEVER, OFFSET, SLOW, LOOP)
    watch = PressureWatch(bounds, RegulatorModel(bandwidth, 1.0), ["ch1"], "regulators")
    pressure, rate, own = 0.0, 0.0, bandwidth / slowed
    for cycle in range(round(2.5 / STEP)):
        setpoint = RATE * max(cycle * STEP - 1.0, 0.0)  # it rests for a second before
        for _ in range(10):
            rate += 0.1 * STEP * own * (own * (setpoint - pressure) - 2.0 * rate)
            pressure += 0.1 * STEP * rate
        watch.send([setpoint])
        try:
            watch.check([pressure + static * (cycle * STEP >= since)], cycle * STEP)
        except SafetyError as error:
            return str(error), watch._channels[0].usual
    return None, watch._channels[0].usual


@pytest.mark.parametrize("static", [-8e3, 0.0, 8e3])
def test_what_a_slow_regulator_is_late_by_in_a_long_ramp_is_not_usual_for_it(static):
    """It was: a mean over all that had been took the ramp for its own."""
    said, usual = filled(4.5, static)
    assert "the regulator of ch1 is stuck, slow or off, or its monitor is off" in said
    assert usual == pytest.approx(static, abs=1.5e3)
    said, usual = filled(1.5, static)
    assert said is None
    assert usual == pytest.approx(static, abs=1.5e3)


@pytest.mark.parametrize(("bandwidth", "is_usual"), [(72.0, False), (80.0, True)])
def test_what_a_regulator_is_off_in_a_slow_ramp_is_usual(bandwidth, is_usual):
    """By less than the hysteresis one of half the bandwidth is late for it: 76 rad/s."""
    said, usual = filled(1.0, 8e3, bandwidth, since=1.2)
    assert said is None
    assert (usual > 3e3) is is_usual and (usual < 0.5e3) is not is_usual


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_is_ahead_of_a_healthy_one_is_not_slow(sign):
    bench = Bench(deviation=NEVER, slow=NEVER, offset=NEVER, loop=LOOP)
    channel, bounds = bench.watch._channels[0], bench.watch._bounds
    channel.likeness = sign
    for late, slow in ((LOOP, False), (1.001 * LOOP, sign > 0.0)):
        channel.lag_mean = late
        assert channel.may_be_slow(bounds) is slow
