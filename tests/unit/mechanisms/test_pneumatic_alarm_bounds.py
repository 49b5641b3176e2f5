"""Bounds that follow from a profile: what healthy regulators do keeps them, slow ones do not."""

import math
from dataclasses import replace

import numpy as np
import pytest
from joint_fakes import CHANNELS, joint_settings

from rig.hal import SafetyError
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.pneumatic.alarms.bounds import (
    derive_bounds,
    expect_bounds,
    greatest_difference,
)
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.alarms.settings import PressureAlarm
from rig.mechanisms.pneumatic.settings import RegulatorModel
from rig.mechanisms.pneumatic.unknowns import UNKNOWNS

STEP = 1e-3
REST = 1.0
"""At base pressure before a motion, s: until then what a monitor is off is not usual."""
FINE = 4
"""Steps of the regulators in a cycle."""


class Regulators:
    """Four of second order with a dead time, hysteresis, an offset and noise."""

    def __init__(self, rng, rates, damping, dead, settings, start):
        low, high = settings.limits.pressure
        self.rng, self.rates, self.damping = rng, rates, damping
        self.late = [round(time / STEP) for time in dead]
        self.play = rng.uniform(0.0, 0.5 * 0.005 * (high - low), 4)
        self.off = rng.uniform(-1.0, 1.0, 4) * 0.005 * (high - low)
        self.noise = 0.0005 * (high - low)
        self.sent = [[start] * (late + 1) for late in self.late]
        self.followed, self.pressures, self.speeds = [np.full(4, v) for v in (start, start, 0.0)]

    def go_on(self, setpoints):
        """Return the monitored pressures of the next cycle."""
        for k, setpoint in enumerate(setpoints):
            self.sent[k].append(setpoint)
            here, play = self.sent[k].pop(0), self.play[k]
            self.followed[k] = min(max(self.followed[k], here - play), here + play)
        for _ in range(FINE):
            pull = self.rates**2 * (self.followed - self.pressures)
            drag = 1.0 + STEP / FINE * 2.0 * self.damping * self.rates
            self.speeds = (self.speeds + STEP / FINE * pull) / drag
            self.pressures = self.pressures + STEP / FINE * self.speeds
        return self.pressures + self.off + self.rng.normal(0.0, self.noise, 4)


def drawn(seed):
    """Return settings with a drawn response, and the generator."""
    rng = np.random.default_rng(seed)
    response = RegulatorModel(
        rng.uniform(25.0, 80.0),
        rng.uniform(0.8, 1.3),
        rng.uniform(2e-3, 8e-3),
        rng.uniform(0.05, 0.2),
    )
    low, high = 0.0, rng.uniform(0.4e6, 0.9e6)
    settings = joint_settings(
        regulator_response=response, base_pressure=rng.uniform(0.3, 0.5) * high
    )
    limits = replace(settings.limits, pressure=(low, high), tension=(5.0, 1.0 * high * 180e-6))
    return replace(settings, limits=limits), rng


def motion(settings, rng, kind, duration):
    """Yield setpoints that a drawn motion asks for, cycle by cycle."""
    response, base = settings.regulator_response, settings.base_pressure
    high = settings.greatest_pressure
    reach = min(high - base, base)
    frequency = rng.uniform(0.05, 0.25) * response.bandwidth / (2.0 * math.pi)
    phase = rng.uniform(0.0, 6.0)
    signs = np.array([1.0, 1.0, -1.0, -1.0])
    for _ in range(round(REST / STEP)):
        yield np.full(4, base)
    for cycle in range(round(duration / STEP)):
        if kind == "steps":  # from base to the ends and back, long enough to settle
            where = (0.0, 1.0, 0.0, -1.0)[int(cycle * STEP * response.bandwidth / 15.0) % 4]
        else:
            where = 0.6 * math.sin(2.0 * math.pi * frequency * cycle * STEP + phase)
        yield base + reach * where * signs


def watch(settings, rng, rates, dead, kind, duration=8.0):
    """Return when something was said, s, and what; None if nothing was."""
    response = settings.regulator_response
    judge = PressureWatch(derive_bounds(PressureAlarm(), settings), response, CHANNELS, "valves")
    plant = Regulators(rng, rates, response.damping, dead, settings, settings.base_pressure)
    for cycle, setpoints in enumerate(motion(settings, rng, kind, duration)):
        judge.send(tuple(setpoints))
        try:
            judge.check(tuple(plant.go_on(setpoints)), (cycle + 1) * STEP)
        except SafetyError as error:
            return cycle * STEP, str(error)
    return None


@pytest.mark.parametrize("kind", ["sine", "steps"])
@pytest.mark.parametrize("seed", range(6))
def test_regulators_within_the_spread_keep_their_bounds(seed, kind):
    settings, rng = drawn([1, seed])
    response = settings.regulator_response
    rates = response.bandwidth * (1.0 + response.spread * rng.uniform(-1.0, 1.0, 4))
    dead = response.dead_time * rng.uniform(0.2, 0.9, 4)
    assert watch(settings, rng, rates, dead, kind) is None


@pytest.mark.parametrize("seed", range(6))
def test_regulators_as_slow_as_the_profile_says_keep_their_bounds(seed):
    settings, rng = drawn([2, seed])
    response = settings.regulator_response
    slower = replace(
        settings, regulator_response=replace(response, bandwidth=response.bandwidth / 1.5)
    )
    rates = np.full(4, response.bandwidth / 1.5)
    assert watch(slower, rng, rates, [response.dead_time] * 4, "sine") is None


@pytest.mark.parametrize("seed", range(8))
def test_a_regulator_that_is_half_as_slow_again_is_named(seed):
    """Within a second and a half of a motion that asks something of it."""
    settings, rng = drawn([3, seed])
    response, k = settings.regulator_response, int(rng.integers(4))
    rates = np.full(4, response.bandwidth)
    rates[k] /= 1.5
    dead = [0.8 * response.dead_time] * 4
    seen, said = watch(settings, rng, rates, dead, "sine")
    assert f"regulator of {CHANNELS[k]} is slow" in said
    assert seen < REST + 1.5


@pytest.mark.parametrize("seed", range(4))
def test_a_healthy_regulator_is_off_by_no_more_than_the_worst_step(seed):
    """Against the step responses in closed form."""
    response = drawn([4, seed])[0].regulator_response

    def answer(t, rate):
        s, z = np.maximum(t, 0.0), response.damping
        root = rate * np.sqrt(complex(z * z - 1.0))
        turned = np.cosh(root * s) + z * rate * np.sinh(root * s) / root
        return 1.0 - (np.exp(-z * rate * s) * turned).real

    t = np.linspace(0.0, 12.0 / response.bandwidth, 4000)
    late = answer(t - response.dead_time, response.bandwidth * (1.0 - response.spread))
    worst = (answer(t, response.bandwidth) - late).max()
    assert greatest_difference(response) == pytest.approx(worst, rel=0.02)


def test_bounds_follow_as_they_are_documented():
    settings, _ = drawn(5)
    settings = replace(settings, regulator_response=RegulatorModel(40.0, 1.0, 1e-3, 0.05))
    bounds = derive_bounds(PressureAlarm(), settings)
    low, high = settings.limits.pressure
    base = settings.base_pressure
    step = max(settings.greatest_pressure - base, base - low)
    assert bounds.deviation == pytest.approx(
        0.022 * (high - low) + step * (0.54 * 0.05 + 0.37 * 40.0 * 1e-3), rel=0.04
    )
    slow = 0.05 / 0.95 + 0.02
    assert bounds[1:] == pytest.approx(
        (0.05, min(0.066 * high, bounds.deviation), 0.005, 0.022 * high, slow, 0.005 * high)
    )


def test_what_is_asked_soon_may_be_pushed_further():
    """3 times what rest permits, more where it is asked within 5 ms, and never more than a step."""
    settings, _ = drawn(5)
    high = settings.limits.pressure[1]
    for time, deviation, stray in (
        (0.05, high, 0.066 * high), (0.5, high, 0.066 * high), (0.02, high, 2.5 * 0.066 * high),
        (0.02, 9.0, 9.0),
    ):  # fmt: skip
        said = PressureAlarm(deviation=deviation, time=time)
        assert derive_bounds(said, settings).stray == pytest.approx(stray)


def test_a_step_down_counts_if_it_is_the_greater_one():
    settings, _ = drawn(6)
    high = settings.limits.pressure[1]
    raised, lowered = (
        derive_bounds(PressureAlarm(), replace(settings, base_pressure=share * high)).deviation
        for share in (0.9, 0.7)
    )
    assert raised > lowered


def test_a_profile_may_say_otherwise():
    settings, _ = drawn(7)
    said = derive_bounds(PressureAlarm(1e3, 2.0, 3e3, 4.0), settings)
    assert said[:6] == (1e3, 2.0, 1e3, 0.2, 3e3, 4.0)
    assert [item.value for item in expect_bounds(said)] == list(said)


def test_half_of_the_pressure_leaves_a_regulator_its_hysteresis():
    """Its errors are shares of its own range, whatever the limits are."""
    settings, rng = drawn(8)
    whole = derive_bounds(PressureAlarm(), settings)
    halved = SphericalJoint.derated(settings, rng.uniform(0.4, 0.9), 0.25)
    assert halved.limits.pressure[1] < settings.limits.pressure[1]
    half = derive_bounds(PressureAlarm(), halved)
    assert half.loop == pytest.approx(whole.loop)
    assert half.offset == pytest.approx(whole.offset)


def test_half_of_the_pressure_leaves_as_much_room_above_the_base_as_below():
    settings, rng = drawn(10)
    effort = rng.uniform(0.1, 0.9)
    low, high = settings.limits.pressure
    halved = SphericalJoint.derated(settings, effort, 0.25)
    assert halved.limits.pressure == (low, effort * high)
    assert halved.base_pressure == min(settings.base_pressure, 0.5 * (low + effort * high))


def test_a_regulator_that_nobody_measured_may_be_as_slow_as_its_gains_are_tried_with():
    settings, _ = drawn(9)
    spread = SphericalJoint.derated(settings, 0.5, 0.25).regulator_response.spread
    guessed = next(u.guessed for u in UNKNOWNS if u.name == "bandwidth")
    assert spread == pytest.approx(1.0 - min(guessed))
