"""What swings is told beside what seems to be stuck: drawn loops of setpoints and pressures."""

import math
import re

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.swinging import PressureSwings

NAMES = ("near", "far")
PERIOD = 1e-3


def noted(sent, came, seconds=1.5, part="regulator"):
    """Return what has seen setpoints and pressures (Pa) of the second chamber; the first rests."""
    swings = PressureSwings(NAMES, part)
    for k in range(round(seconds / PERIOD)):
        t = k * PERIOD
        swings.note(t, (100e3, sent(t)), (100e3, came(t)))
    return swings


def wave(frequency, size, phase=0.0):
    """Return a function of time that swings by a size from one end to the next."""
    return lambda t: 200e3 + 0.5 * size * math.sin(math.tau * frequency * t + phase)


@pytest.mark.parametrize("seed", range(8))
def test_a_setpoint_that_turns_round_too_often_is_told_with_how_often_and_how_far(seed):
    drawn = np.random.default_rng([4219, seed])
    frequency, size = drawn.uniform(20.0, 60.0), drawn.uniform(30e3, 300e3)
    said = noted(wave(frequency, size), wave(frequency, 0.1 * size, 2.0)).explain()
    found = re.search(
        r"the setpoint of far has turned round (\d+) times a second, by (\d+) kPa", said
    )
    assert found is not None, said
    assert float(found[1]) == pytest.approx(2.0 * frequency, rel=0.12)
    assert float(found[2]) == pytest.approx(1e-3 * size, rel=0.12, abs=1.0)


@pytest.mark.parametrize("seed", range(8))
def test_a_pressure_that_swings_about_a_setpoint_at_rest_is_told(seed):
    drawn = np.random.default_rng([4220, seed])
    frequency, size = drawn.uniform(6.0, 20.0), drawn.uniform(30e3, 100e3)
    said = noted(lambda t: 200e3 + 5e3 * t, wave(frequency, size), part="valve").explain()
    found = re.search(
        r"the valves are slower or later .* of far has swung about its setpoint at ([\d.]+) Hz, "
        r"(\d+) kPa", said,
    )  # fmt: skip
    assert found is not None, said
    assert float(found[1]) == pytest.approx(frequency, rel=0.35)  # of a few whole swings
    assert float(found[2]) == pytest.approx(1e-3 * size, rel=0.12, abs=1.0)


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_told_of_what_goes_to_its_setpoint_or_stays_off(seed):
    drawn = np.random.default_rng([4221, seed])
    slow, size = drawn.uniform(0.1, 3.0), drawn.uniform(30e3, 200e3)
    noise = drawn.normal(0.0, 1e3, 2000)

    def came(t):
        return wave(slow, size)(t - 0.02) + noise[round(t / PERIOD)] - 60e3

    assert noted(wave(slow, size), came).explain() == ""
    assert PressureSwings(NAMES, "valve").explain() == ""


def test_what_swung_long_ago_or_before_a_new_beginning_is_forgotten():
    restless = wave(30.0, 100e3)
    assert noted(lambda t: restless(t) if t < 0.9 else 200e3, lambda t: 200e3).explain() == ""
    swings = noted(restless, lambda t: 200e3)
    swings.clear()
    swings.note(2.0, (100e3, 200e3), (100e3, 200e3))
    assert swings.explain() == ""


def test_a_setpoint_that_has_jumped_may_explain_an_answer_that_comes_late():
    swings = noted(lambda t: 250e3 if t < 1.4 else 60e3, lambda t: 160e3)
    assert "has gone to and fro by 190 kPa, later or farther" in swings.explain_jump(1, 100e3)
    assert swings.explain_jump(1, 191e3) == swings.explain_jump(0, 1e3) == ""
