"""One channel on its own: what a whole plant's figures would hardly show."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.channel import STATE, seal_friction
from drivers.sim.plants.friction import bristle_damping
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.regulator import step_opening
from drivers.sim.plants.regulator_settings import RegulatorSettings
from drivers.sim.plants.settings import PlantSettings

DT = 50e-6


@pytest.mark.parametrize("time_constant", [1.5e-3, 3e-3])
def test_the_main_valve_opens_with_its_time_constant(time_constant):
    """The pilot stands 300 kPa above the chamber, far beyond the proportional band."""
    regulator = RegulatorSettings(valve_time=time_constant)
    plant = AntagonisticPairPlant(PlantSettings(regulator=regulator), 0)
    plant.set_supply(True)
    plant.advance(0.2)
    plant.inject("regulator_stuck", 0)
    plant.channels[0]["pilot"] = 0.3e6
    for share in (0.5, 1.0, 2.0):
        plant.advance(0.2 + share * time_constant)
        opening = float(plant.channels[0]["opening"])
        assert opening == pytest.approx(1.0 - math.exp(-share), abs=0.01)


@pytest.mark.parametrize(
    ("error", "opening"),
    [(0.0, 0.0), (400.0, 0.0), (-400.0, 0.0), (10.5e3, 0.5), (-5.5e3, -0.25), (1e5, 1.0)],
)
def test_the_main_valve_is_proportional_beyond_its_overlap(error, opening):
    value = 0.3
    for _ in range(2000):
        value = step_opening(value, error, 500.0, 20e3, 3e-3, DT)
    assert value == pytest.approx(opening, abs=1e-9)


def friction_of_a_start(speed):
    """Set seals in motion from rest and return the friction of the first step, N."""
    plant = AntagonisticPairPlant(PlantSettings(friction_spread=0.0), 0)
    state = np.zeros(1, STATE)
    state["pressure"], state["speed"] = ATMOSPHERE, speed
    return seal_friction(state[0], plant.parameters[0], DT), float(state["bristle"][0])


def test_bristles_damp_slow_motion():
    force, bristle = friction_of_a_start(1e-3)
    damping = 150.0 * math.exp(-((1.0 / 8.0) ** 2))
    assert force == pytest.approx(1.5e5 * bristle + damping * bristle / DT + 25e-3, rel=1e-9)
    assert damping * bristle / DT > 0.5 * force


def test_damping_of_the_bristles_fades_with_speed():
    """With all of it, 0.1 m/s would start against 15 N more, and the model could give energy."""
    force, bristle = friction_of_a_start(0.1)
    assert force == pytest.approx(1.5e5 * bristle + 25.0 * 0.1, rel=1e-9)
    assert bristle_damping(8e-3, 150.0, 8e-3) == pytest.approx(150.0 / math.e)
    assert bristle_damping(-8e-3, 150.0, 8e-3) == bristle_damping(8e-3, 150.0, 8e-3)


def stop_after_a_push(substep):
    """Push a pair at 100 mm/s for some millimetres and return its track, m."""
    settings = replace(PlantSettings(), substep=substep)
    plant = AntagonisticPairPlant(settings, 3)
    plant.set_supply(True)
    track = []
    for k in range(1, 401):
        t = 2e-3 * k
        push = 60e3 if 0.4 <= t < 0.5 else 0.0
        plant.set_pressure_setpoint(0, 0.12e6 + push)
        plant.set_pressure_setpoint(1, 0.12e6 - push)
        plant.advance(t)
        track.append(plant.truth()[0])
    return np.array(track)


def test_the_error_of_the_step_is_a_delay_that_shrinks_with_it():
    fine, half, usual = (stop_after_a_push(step) for step in (12.5e-6, 25e-6, 50e-6))
    speed = np.abs(np.diff(fine)).max() / 2e-3
    assert speed > 0.05
    error = np.abs(usual - fine).max()
    assert error < 0.25e-3 * speed
    # First order: the errors against a quarter of the step are as 3 to 1.
    assert error / np.abs(half - fine).max() == pytest.approx(3.0, rel=0.15)
