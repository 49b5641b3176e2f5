"""A pressure beside all that a late regulator does is told sooner than one that is late."""

import math

import numpy as np
import pytest
from pressure_bench import DEVIATION, NEVER, START, STEP, Bench
from scipy import signal

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.settings import RegulatorModel


@pytest.mark.parametrize("way", [-50e3, 50e3])
def test_what_nobody_asked_to_move_has_less_time_than_what_was_asked(way):
    """What goes beside all that a late regulator does throws its pair before a step is over."""
    still = Bench(unasked=3 * STEP)
    still.pass_by(3, ch3=way)
    with pytest.raises(SafetyError, match=f"ch3.* even of a late one, .*40 kPa for {3 * STEP:.3g}"):
        still.pass_by(1, ch3=way)
    for share, patient in ((1.0, True), (0.3, True), (0.2, False), (-0.4, False), (-1.0, False)):
        asked = Bench(unasked=3 * STEP)
        asked.watch.send((START, START, START + math.copysign(1.0, way) * share * DEVIATION, START))
        if patient:
            asked.pass_by(5, ch3=way)
            continue
        with pytest.raises(SafetyError, match=f"at most 40 kPa for {3 * STEP:.3g} s"):
            asked.pass_by(5, ch3=way)


@pytest.mark.parametrize("way", [-1.0, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_what_strays_is_beside_the_setpoint_and_every_answer_to_it(seed, way):
    """Whichever of setpoint, prompt, late and slow answers is the nearest, and what is usual."""
    rng = np.random.default_rng([seed, int(way > 0)])
    bench = Bench(RegulatorModel(dead_time=3 * STEP), deviation=NEVER, stray=30e3, unasked=STEP)
    channel = bench.watch._channels[2]
    parts = ("expected", "prompt", "slow", "quick")
    for part in parts:
        setattr(channel, part, START + rng.uniform(-50e3, 50e3))
    channel.usual = rng.uniform(-5e3, 5e3)
    setpoint = START + rng.uniform(-50e3, 50e3)
    ends = [setpoint, *(getattr(channel, part) for part in parts)]
    edge = channel.usual + (max(ends) if way > 0 else min(ends)) + way * 30e3
    assert not channel.strays(edge - way * 1.0, setpoint, 30e3)
    assert channel.strays(edge + way * 1.0, setpoint, 30e3)
    for between in channel.usual + rng.uniform(min(ends), max(ends), 50):
        assert not channel.strays(between, setpoint, 1e3)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_at_its_bound_it_does_not_stray(way):
    channel = Bench().watch._channels[0]
    channel.expected, channel.prompt, channel.slow = START, START, START + way * 20e3
    channel.quick = START
    setpoint = START + way * 50e3
    assert channel.strays(setpoint + way * 30e3, setpoint, 30e3) is False
    assert channel.strays(START - way * 30e3, setpoint, 30e3) is False
    assert channel.strays(setpoint + way * 30001.0, setpoint, 30e3) is True
    assert channel.strays(START - way * 30001.0, setpoint, 30e3) is True


@pytest.mark.parametrize("seed", range(3))
def test_what_strays_and_falls_is_said_to_fall_whatever_is_permitted_of_a_step(seed):
    rng = np.random.default_rng(seed)
    bench = Bench(deviation=400e3, stray=33e3, unasked=5 * STEP)
    for share in np.linspace(0.0, 1.0, 20):
        try:
            bench.pass_by(1, ch2=-share * rng.uniform(60e3, 90e3))
        except SafetyError as error:
            assert "ch2 is stuck venting, or its tube is off: its pressure falls" in str(error)
            return
    pytest.fail("not seen")


def test_who_has_been_off_beyond_its_own_time_for_longest_is_named():
    """One that strays is over its time before one that was off sooner, and may be late."""
    bench = Bench(time=20 * STEP, unasked=2 * STEP)
    bench.watch.send((START, START + DEVIATION, START, START))
    bench.pass_by(2, ch2=60e3)
    with pytest.raises(SafetyError, match=r"\[ch4: .* for 0\.00195 s\]"):
        bench.pass_by(3, ch2=60e3, ch4=60e3)


def quick_answer(setpoints, bandwidth, damping):
    """Return what a regulator makes of setpoints, Pa, one a step, from rest at the first."""
    plant = [bandwidth**2], [1.0, 2.0 * damping * bandwidth, bandwidth**2]
    way = np.asarray(setpoints) - setpoints[0]
    _, answer, _ = signal.lsim(plant, way, STEP * np.arange(len(way)), interp=False)
    return setpoints[0] + answer


@pytest.mark.parametrize("seed", range(12))
def test_regulators_up_to_twice_as_quick_do_not_stray(seed):
    """A setpoint that was there for a moment only takes them farther than those of the profile."""
    rng = np.random.default_rng((51, seed))
    model = RegulatorModel(bandwidth=rng.uniform(30.0, 60.0), dead_time=8 * STEP)
    bench = Bench(model, deviation=NEVER, stray=33e3, unasked=2 * STEP)
    wanted = np.repeat(rng.uniform(60e3, 260e3, 60), rng.integers(4, 40, 60))
    wanted[:20] = START
    quick = quick_answer(wanted, rng.uniform(1.0, 2.0) * model.bandwidth, model.damping)
    late = np.concatenate((np.full(8, START), quick))[: len(wanted)]
    for setpoint, pressure in zip(wanted, late, strict=True):
        bench.watch.send((setpoint, START, START, START))
        bench.pass_by(1, ch1=pressure - START)
    with pytest.raises(SafetyError, match=r"\[ch1: "):
        bench.pass_by(3, ch1=300e3)
