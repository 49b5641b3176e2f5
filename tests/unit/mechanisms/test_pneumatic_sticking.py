"""A rod that stands and slips is told from one that swings, and may swing further."""

import dataclasses
import math
import re

import numpy as np
import pytest

from rig.hal import SafetyError
from rig.hal.hindsight import STICKS, STRAYED
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm
from rig.mechanisms.pneumatic.alarms.tracking import TrackingWatch

PERIOD = 1e-3
ALARM = OscillationAlarm(amplitude=1.5e-3, swings=6, slowest=1.0, lost=0.3)
EXACT = OscillationAlarm(amplitude=2.0**-9, sticking=2.0, swings=6, slowest=1.0, lost=60.0)
"""Of numbers that have no rounding, m."""


def watch(following=3e-3, alarm=ALARM):
    return TrackingWatch(("the pair",), following, alarm)


def run(error, duration, watched, rest=0.0):
    """Let a function of time pass; return when it raised and what (None: not at all)."""
    for k in range(round(duration / PERIOD)):
        t = k * PERIOD
        try:
            watched.check((rest,), (rest + error(t),), t)
        except SafetyError as fault:
            return t, fault
    return None


def jumps(halves):
    """Return the error (m) of a rod that stands on one side, then on the other.

    Parameters
    ----------
    halves : sequence of tuple
        How long it stands, s, and how far off, m.
    """
    ends = np.cumsum([length for length, _ in halves])

    def error(t):
        place = min(int(np.searchsorted(ends, t, side="right")), len(halves) - 1)
        return halves[place][1]

    return error


def stairs(drawn, frequency, size, slips):
    """Return the error (m) of a rod that stands, and slips in a share of each half period."""
    noise = drawn.normal(0.0, 2e-6, 20_000)

    def error(t):
        halves, part = divmod(2.0 * frequency * t, 1.0)
        gone = 0.5 * (1.0 - math.cos(math.pi * min(part / slips, 1.0)))
        return (-1.0) ** halves * size * (gone - 0.5) + float(noise[int(t / PERIOD)])

    return error


@pytest.mark.parametrize("seed", range(6))
def test_a_rod_that_stands_and_jumps_is_said_to_stick(seed):
    drawn = np.random.default_rng(200 + seed)
    frequency = float(drawn.uniform(0.6, 6.0))
    size, rest = float(drawn.uniform(3.2e-3, 5e-3)), float(drawn.uniform(-5e-3, 5e-3))
    slips = float(drawn.uniform(0.1, 0.35))
    found = run(stairs(drawn, frequency, size, slips), 15.0, watch(), rest)
    assert found is not None
    said = re.search(
        r"the pair sticks and slips at ([\d.]+) Hz, .* stands for (\d+) % of the time: its fric",
        str(found[1]),
    )
    assert said is not None, str(found[1])
    assert float(said[1]) == pytest.approx(frequency, rel=0.1, abs=0.06)
    # A cosine goes 30 um at its ends in a small part of its way.
    assert float(said[2]) == pytest.approx(100.0 * (1.0 - slips), abs=15.0)
    assert "regulators are slower" in str(found[1])
    assert "`rig calibrate RIG friction response` measures both" in str(found[1])


@pytest.mark.parametrize("seed", range(6))
def test_what_sticks_by_less_than_a_share_of_its_own_goes_on_and_is_told_once(seed):
    drawn = np.random.default_rng(300 + seed)
    sticking = float(drawn.uniform(1.0, 3.0))
    most = sticking * ALARM.amplitude
    watched = watch(following=1.0, alarm=dataclasses.replace(ALARM, sticking=sticking))
    frequency, slips = float(drawn.uniform(0.6, 6.0)), float(drawn.uniform(0.1, 0.35))
    size = most - 20e-6
    if size > ALARM.amplitude:
        error = stairs(drawn, frequency, size, slips)
        assert run(error, 15.0, watched) is None
        watched.restart()  # what is released has stuck all the same
        (note,) = watched.remarks()
        assert note.kind == STICKS
        said = re.search(r"the pair sticks and slips at [\d.]+ Hz, ([\d.]+) mm", note.message)
        assert said is not None
        assert float(said[1]) == pytest.approx(size * 1e3, rel=0.06)
    wider = stairs(drawn, frequency, most + 20e-6, slips)
    watched = watch(following=1.0, alarm=dataclasses.replace(ALARM, sticking=sticking))
    found = run(wider, 15.0, watched)
    assert found is not None
    assert "the pair sticks and slips" in str(found[1])
    assert watch().remarks() == ()


def test_a_rod_that_sticks_beyond_following_on_both_sides_is_a_fault_whatever_may_stick():
    alarm = OscillationAlarm(amplitude=1.5e-3, sticking=100.0)
    error = stairs(np.random.default_rng(5), 3.0, 4.2e-3, 0.2)
    assert run(error, 9.0, watch(2.2e-3, alarm)) is None
    found = run(error, 9.0, watch(2e-3, alarm))
    assert found is not None
    assert "sticks and slips" in str(found[1])


def test_what_swings_by_just_what_may_stick_goes_on():
    halves = [(0.25, (-1.0) ** k * 2.0**-9) for k in range(20)]
    assert run(jumps(halves), 5.0, watch(1.0, EXACT)) is None


def test_the_remark_is_of_the_first_of_the_widest_swings():
    wide, small = 0.9 * 2.0**-9, 0.6 * 2.0**-9
    halves = [(0.25, wide), (0.25, -wide)] * 5 + [(0.125, wide), (0.125, -wide)] * 9
    halves += [(0.2, small), (0.2, -small)] * 9
    watched = watch(1.0, EXACT)
    assert run(jumps(halves), sum(length for length, _ in halves), watched) is None
    (note,) = watched.remarks()
    assert f"at 2.0 Hz, {2e3 * wide:.2g} mm peak to peak" in note.message


def test_the_frequency_is_that_of_the_last_swings():
    """However long it has stuck before."""
    small, wide = 0.9 * 2.0**-9, 1.1 * 2.0**-9
    halves = [(0.5, small), (0.5, -small)] * 5 + [(0.1, small), (0.1, -small)] * 2
    found = run(jumps([*halves, (0.1, wide), (0.1, -wide), (0.1, wide)]), 6.2, watch(1.0, EXACT))
    assert found is not None
    assert "at 5.0 Hz" in str(found[1])


@pytest.mark.parametrize("seed", range(6))
def test_a_rod_that_was_far_off_for_a_moment_is_told_with_how_far(seed):
    drawn = np.random.default_rng(400 + seed)
    far, sign = float(drawn.uniform(4.52e-3, 5.9e-3)), float(drawn.choice([-1.0, 1.0]))
    watched = watch(alarm=dataclasses.replace(ALARM, swings=100))
    moment = float(drawn.uniform(0.05, 0.25))
    assert run(jumps([(2.0, 0.0), (moment, sign * far), (1.0, 0.0)]), 3.0, watched) is None
    watched.restart()
    (note,) = watched.remarks()
    assert note.kind == STRAYED
    said = re.search(r"the pair was up to ([\d.]+) mm off its reference, beyond", note.message)
    assert said is not None
    assert float(said[1]) == pytest.approx(1e3 * far, abs=0.06)


def test_what_ends_in_a_fault_or_follows_a_step_is_no_moment():
    watched = watch(alarm=dataclasses.replace(ALARM, swings=100))
    assert run(jumps([(2.0, 0.0), (0.2, 4.48e-3), (1.0, 0.0)]), 3.0, watched) is None
    assert watched.remarks() == (), "half as much again is not worth a word"
    watched = watch()
    assert run(jumps([(2.0, 0.0), (9.0, 4e-3)]), 3.0, watched) is not None
    assert watched.remarks() == ()
    watched = watch()
    for k in range(3000):
        at, t = (0.0 if k < 2000 else 5e-3), k * PERIOD
        watched.check((at,), (0.0 if k < 2200 else at,), t)
    assert watched.remarks() == ()
