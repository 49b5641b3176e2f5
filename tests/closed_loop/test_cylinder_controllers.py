"""The controllers of a pair on its plant, in virtual time, with the figures as numbers.

The loop is as over the bus: readings are quantised and one period old when they are used (but for
the bus's latency), a setpoint acts a latency after it was computed. Errors are what the
experiments report: reference less encoder reading.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pytest

from controllers.cylinder.cascade import Cascade
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.feedforward import FeedforwardSettings
from controllers.cylinder.pid import Pid, PidSettings
from controllers.cylinder.pid_friction import PidFriction, PidFrictionSettings
from controllers.cylinder.super_twisting import SuperTwisting, SuperTwistingSettings
from controllers.cylinder.types import PairModel, PairReference, PairState
from controllers.minimum_jerk import minimum_jerk
from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.settings import PlantSettings
from rig.mechanisms.cylinder.references import Sine, SineTone, Staircase, Step

RATE = 1000
LATENCY = 0.3e-3
ENCODER = 1e-6
MONITOR = 0.5e6 / 0x7FFF
APPROACH = 1.0

MODEL = {
    "standard": PairModel(
        area=math.pi / 4 * (16e-3**2 - 5e-3**2),
        mass=0.138,
        base_pressure=0.12e6,
        pressure_min=0.0,
        pressure_max=0.5e6,
        regulator_bandwidth=40.0,
        regulator_damping=1.0,
        coulomb=10.4,
        breakaway=13.4,
        stribeck_velocity=8e-3,
        viscous=50.0,
    )
}
MODEL["low-speed"] = replace(
    MODEL["standard"], coulomb=6.5, breakaway=6.7, stribeck_velocity=3e-3, viscous=30.0
)


# The defaults are the gains for standard seals.
GAINS = {
    "standard": {
        "pid": PidSettings(),
        "pid-friction": PidFrictionSettings(),
        "cascade": CascadeSettings(),
        "super-twisting": SuperTwistingSettings(),
    },
    "low-speed": {
        "pid": PidSettings(
            proportional=7.0e7, integral=1.6e9, derivative=4.3e6, derivative_time=5.3e-4
        ),
        "pid-friction": PidFrictionSettings(
            proportional=4.6e7,
            integral=4.2e8,
            derivative=3.4e5,
            lead_bandwidth=240.0,
            dither_amplitude=1200.0,
            dither_frequency=18.0,
            acceleration_step=0.7,
            feedforward=FeedforwardSettings(gain=1.0, distance=9e-6, learning_rate=0.0),
        ),
        "cascade": CascadeSettings(
            position_rate=80.0,
            velocity_rate=300.0,
            integral=8e4,
            hold_integral=1e6,
            observer_bandwidth=775.0,
            force_trust=0.1,
            lead_bandwidth=400.0,
            disturbance_gain=0.06,
            disturbance_bandwidth=50.0,
            trim_rate=2.0,
            feedforward=FeedforwardSettings(
                gain=1.1, distance=8e-6, learning_rate=2.0, error_rate=2.0
            ),
        ),
        "super-twisting": SuperTwistingSettings(
            surface_rate=30.0,
            disturbance_rate=135.0,
            proportional_factor=0.97,
            integral_factor=0.98,
            boundary=5.8e-3,
            lead_bandwidth=400.0,
            force_noise=1.0,
            observed_rate=17.0,
        ),
    },
}

REACHED = {
    "standard": {"pid": 0.250e-3, "pid-friction": 0.155e-3, "super-twisting": 0.175e-3},
    "low-speed": {"pid": 0.173e-3, "pid-friction": 0.043e-3, "super-twisting": 0.058e-3},
}
"""What the others reach at 0.2 Hz, m."""


class Run(NamedTuple):
    """A run's columns: m, m, Pa (n, 2), N (n, 2), m/s, m/s; and what is judged."""

    reference: np.ndarray
    reading: np.ndarray
    command: np.ndarray
    tension: np.ndarray
    velocity: np.ndarray
    estimate: np.ndarray
    judged: np.ndarray

    @property
    def rms(self):
        error = (self.reference - self.reading)[self.judged]
        return float(np.sqrt(np.mean(error**2)))


def read(plant):
    extensions = [round(plant.position(k) / ENCODER) * ENCODER for k in range(2)]
    pressures = [round(plant.pressure(k) / MONITOR) * MONITOR for k in range(2)]
    return 0.5 * (extensions[1] - extensions[0]), *pressures


def run(controller, plant, reference, rate=RATE):
    period = 1.0 / rate
    plant.set_supply(True)
    for channel in range(2):
        plant.set_pressure_setpoint(channel, 0.12e6)
    start = rate // 2
    plant.advance(start * period + LATENCY)
    reading = read(plant)
    rest, begin = reading[0], reference.at(0.0).position
    controller.reset(PairState(start * period, *reading))
    rows = []
    for k in range(round((APPROACH + reference.duration) * rate)):
        t, elapsed = (start + 1 + k) * period, k * period - APPROACH
        desired = (
            PairReference(*minimum_jerk(rest, begin, APPROACH, elapsed + APPROACH))
            if elapsed < 0.0
            else reference.at(elapsed)
        )
        plant.advance(t)
        _, velocity, *_, tension_a, tension_b, _ = plant.truth()
        command = controller.update(PairState(t, *reading), desired)
        rows.append(
            (desired.position, reading[0], *command, tension_a, tension_b, velocity,
             controller.estimate.velocity)
        )  # fmt: skip
        plant.advance(t + LATENCY)
        for channel in range(2):
            plant.set_pressure_setpoint(channel, command[channel])
        reading = read(plant)
    table = np.array(rows)
    elapsed = np.arange(len(rows)) * period - APPROACH
    judged = np.zeros(len(rows), bool)
    for segment in reference.segments:
        judged |= (elapsed >= segment.start) & (elapsed < segment.end)
    return Run(
        table[:, 0], table[:, 1], table[:, 2:4], table[:, 4:6], table[:, 6], table[:, 7],
        judged,
    )  # fmt: skip


SINE = {f: Sine(8.727e-3, (SineTone(f, 2),)) for f in (0.1, 0.2, 0.5)}
STAIRCASE = Staircase((0.0, 4e-3, 8e-3, 5e-3, -2e-3), rise=1.0, dwell=2.0)

KINDS = {
    "pid": Pid,
    "pid-friction": PidFriction,
    "cascade": Cascade,
    "super-twisting": SuperTwisting,
}


@lru_cache(maxsize=64)
def measured(name, seals, reference, seed=0, friction_scale=1.0):
    """Return a run of a controller with the gains of these seals; each is made once."""
    controller = KINDS[name](GAINS[seals][name], MODEL[seals], 1.0 / RATE)
    plant = AntagonisticPairPlant(PlantSettings(seals=seals, friction_scale=friction_scale), seed)
    return run(controller, plant, reference)


both_seals = pytest.mark.parametrize("seals", ["standard", "low-speed"])
# Units 1 and 2 are those of the shipped experiments, by which the default tests judge them too.
SHIPPED = [pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2)]
three_units = pytest.mark.parametrize("seed", [0, *SHIPPED])

# Bounds in m, of the cascade. Those at 0.2 Hz and of the hold are the figures that the rig is
# accepted by; 0.109 and 0.046 mm at 0.2 Hz, 0.029 and 0.0048 mm are known to be possible.
TRACKING = {"standard": 0.15e-3, "low-speed": 0.06e-3}
HOLD = {"standard": 0.03e-3, "low-speed": 0.005e-3}


@both_seals
@three_units
def test_cascade_tracks_at_02_hz(seals, seed):
    assert measured("cascade", seals, SINE[0.2], seed).rms < TRACKING[seals]


@both_seals
@pytest.mark.parametrize("seed", [0, *SHIPPED, 3, 5, 7])
def test_cascade_holds(seals, seed):
    assert measured("cascade", seals, STAIRCASE, seed).rms < HOLD[seals]


@both_seals
@three_units
def test_sixty_percent_more_friction_at_most_doubles_the_error(seals, seed):
    nominal = measured("cascade", seals, SINE[0.2], seed).rms
    stiff = measured("cascade", seals, SINE[0.2], seed, 1.6).rms
    assert stiff < 2.0 * nominal


@both_seals
@three_units
def test_sixty_percent_more_friction_at_most_doubles_the_permitted_hold(seals, seed):
    assert measured("cascade", seals, STAIRCASE, seed, 1.6).rms < 2.0 * HOLD[seals]


@both_seals
@pytest.mark.parametrize("frequency", [0.1, 0.5])
def test_cascade_tracks_slower_and_faster(seals, frequency):
    bound = {"standard": {0.1: 0.16e-3, 0.5: 0.27e-3}, "low-speed": {0.1: 0.03e-3, 0.5: 0.06e-3}}
    assert measured("cascade", seals, SINE[frequency], 1).rms < bound[seals][frequency]


@both_seals
def test_pid_is_beaten_by_two_or_more(seals):
    assert measured("pid", seals, SINE[0.2]).rms > 2.0 * measured("cascade", seals, SINE[0.2]).rms


@both_seals
@pytest.mark.parametrize("name", ["pid", "pid-friction", "super-twisting"])
def test_the_others_are_honestly_tuned(name, seals):
    """No straw men; stick-slip makes the figure wander by some percent from unit to unit."""
    assert measured(name, seals, SINE[0.2]).rms < 1.2 * REACHED[seals][name]


@both_seals
@pytest.mark.parametrize("name", KINDS)
def test_wires_stay_taut_and_setpoints_above_the_floor(name, seals):
    for reference in (SINE[0.2], STAIRCASE):
        trace = measured(name, seals, reference)
        assert trace.tension.min() > 5.0
        assert trace.command.min() >= GAINS[seals][name].pressure_floor - 1e-6


def test_cascade_slides_smoothly_on_low_speed_seals():
    """On these seals the velocity loop outweighs the falling friction: no stick-slip."""
    trace = measured("cascade", "low-speed", SINE[0.2])
    velocity, estimate = trace.velocity[trace.judged], trace.estimate[trace.judged]
    desired = np.gradient(trace.reference, 1.0 / RATE)[trace.judged]
    assert np.sqrt(np.mean((velocity - desired) ** 2)) < 0.2 * np.sqrt(np.mean(desired**2))
    assert np.sqrt(np.mean((velocity - estimate) ** 2)) < 1e-3


def test_a_step_is_met_without_windup():
    """5 mm at once: the overshoot stays small although the pressures saturate."""
    trace = measured("cascade", "low-speed", Step(5e-3, dwell=1.5))
    assert np.ptp(trace.command[:, 0]) > 0.15e6
    assert trace.reading[trace.judged].max() < 5.0e-3 + 0.5e-3


def test_the_same_seed_gives_the_same_commands():
    first, second = (
        run(
            Cascade(GAINS["low-speed"]["cascade"], MODEL["low-speed"], 1.0 / RATE),
            AntagonisticPairPlant(PlantSettings(seals="low-speed"), 3),
            Step(2e-3, dwell=0.5),
        )
        for _ in range(2)
    )
    assert np.array_equal(first.command, second.command)
