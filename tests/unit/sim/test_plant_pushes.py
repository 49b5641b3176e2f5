"""Pushes at what the wires of a pneumatic plant move, and regulators that give another pressure."""

import math

import numpy as np
import pytest
from joint_bench import joint

from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.push import LASTS
from drivers.sim.plants.settings import PlantSettings

BASE = 120e3
OFF = 6e3
"""Pa, by which a regulator is off anyway: hysteresis, bow, overlap."""


def pair(seed):
    return AntagonisticPairPlant(PlantSettings(), seed)


def settled(make, seed):
    plant = make(seed)
    plant.set_supply(True)
    for channel in range(len(plant.channel_names)):
        plant.set_pressure_setpoint(channel, BASE)
    plant.advance(1.0)
    return plant


def way_of(plant, place):
    """Return how far a push moved the plant that way, m."""
    shown = dict(zip((name for name, _ in plant.truth_columns), plant.truth(), strict=True))
    return shown["position"] if place == "along.carriage_push" else _lean(plant, place)


def _lean(plant, place):
    marker = plant.marker_position()
    return marker[0] if place == "forward.ring_push" else marker[1]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("make", "place"),
    [(pair, "along.carriage_push"), (joint, "forward.ring_push"), (joint, "left.ring_push")],
)
def test_a_push_moves_it_that_way_for_as_long_as_it_acts(make, place, sign):
    size = sign * np.random.default_rng([len(place), int(sign > 0)]).uniform(2.0, 3.0)
    pushed, still = settled(make, 3), settled(make, 3)
    assert place in pushed.known_faults
    pushed.inject(place, size)
    for plant in (pushed, still):
        plant.advance(1.0 + LASTS)
    way = way_of(pushed, place) - way_of(still, place)
    assert sign * way > 1e-3
    # When it is over nothing pushes on: what is in motion comes to rest.
    for plant in (pushed, still):
        plant.advance(2.0)
    there = way_of(pushed, place)
    pushed.advance(2.5)
    assert way_of(pushed, place) == pytest.approx(there, abs=1e-4)


def test_a_push_gives_its_impulse_however_time_is_cut():
    """Without wires, seats and stops the carriage takes all of it."""
    speeds = []
    for cuts in ((0.2,), (0.0303, 0.0999, 0.1, 0.1001, 0.2)):
        plant = pair(1)
        plant.parameters["wire_stiffness"] = plant.parameters["wire_damping"] = 0.0
        plant.pair_parameters["seat"] = plant.pair_parameters["seat_damping"] = 0.0
        plant.pair_parameters["seat_stiffness"] = plant.pair_parameters["stop_stiffness"] = 0.0
        plant.pair_parameters["stop_damping"] = 0.0
        plant.inject("along.carriage_push", 0.01)
        for t in cuts:
            plant.advance(t)
        speeds.append(dict(zip((n for n, _ in plant.truth_columns), plant.truth(), strict=True)))
    mass = PlantSettings().carriage.mass
    for truth in speeds:
        assert truth["velocity"] == pytest.approx(0.01 / mass, rel=2e-3)


@pytest.mark.parametrize("begins", range(8))
def test_a_push_ends_though_a_substep_ended_with_it(begins):
    """Time that is a hair short of its end counts for the substep that ends there."""
    plant = pair(1)
    plant.advance(begins * 1e-3)
    plant.inject("along.carriage_push", 1.0)
    ends = plant._push.ends
    plant.advance(ends - 1e-12)
    plant.advance(ends + 5e-3)
    assert math.isinf(plant._push.ends)
    assert not plant.pair["push"].any()


def test_a_push_is_a_finite_number():
    for plant, place in ((pair(1), "along.carriage_push"), (joint(1), "left.ring_push")):
        with pytest.raises(ValueError, match="finite impulse"):
            plant.inject(place, math.inf)


@pytest.mark.parametrize("seed", range(4))
def test_a_regulator_that_is_off_gives_so_much_more_until_it_is_repaired(seed):
    rng = np.random.default_rng(seed)
    plant, channel = settled(pair, seed), int(rng.integers(2))
    before = [plant.pressure(k) for k in range(2)]
    off = rng.choice([-1.0, 1.0]) * rng.uniform(20e3, 60e3)
    for _ in range(2):
        plant.inject(f"{plant.channel_names[channel]}.regulator_offset", off)
        for k in range(2):
            plant.set_pressure_setpoint(k, BASE)
        plant.advance(plant.time + 0.5)
        found = [plant.pressure(k) - before[k] for k in range(2)]
        assert found[channel] == pytest.approx(off, abs=OFF)
        assert found[1 - channel] == pytest.approx(0.0, abs=OFF)
    plant.inject("repair")
    plant.set_pressure_setpoint(channel, BASE)
    plant.advance(plant.time + 0.5)
    assert plant.pressure(channel) == pytest.approx(before[channel], abs=OFF)
