"""The pair as a mechanism: energy, friction, wires, convergence, determinism."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.sim.hazards import pair_hazards
from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.regulator_settings import RegulatorSettings
from drivers.sim.plants.settings import (
    ActuatorSettings,
    CarriageSettings,
    PlantSettings,
    WireSettings,
)

HAZARDS = pair_hazards(
    SimpleNamespace(
        home=30e-3,
        stroke=60e-3,
        limits=SimpleNamespace(position=(-0.02, 0.02), speed=0.5, pressure=(0.0, 500e3)),
    )
)
SEALED = RegulatorSettings(conductance_in=0.0, conductance_out=0.0)


def mechanical_and_gas_energy(plant):
    """Return everything that could still do work, J (plus a constant).

    The gas behind ``p V^1.2 = const`` stores ``p V / 0.2``; displaced air, ``p_atm V``.
    """
    pair, settings = plant.pair[0], plant.settings
    energy = 0.5 * settings.carriage.mass * pair["speed"] ** 2
    energy += 0.5 * settings.carriage.seat_stiffness * pair["bristle"] ** 2
    beyond = max(abs(pair["position"]) - plant.pair_parameters[0]["stop"], 0.0)
    energy += 0.5 * settings.carriage.stop_stiffness * beyond**2
    for state, p, side in zip(plant.channels, plant.parameters, (-1.0, 1.0), strict=True):
        volume = p["dead_volume"] + p["area"] * (p["stroke"] - state["extension"])
        stretch = max(settings.home - state["extension"] + side * pair["position"], 0.0)
        pushed_in = max(-state["extension"], state["extension"] - p["stroke"], 0.0)
        energy += state["pressure"] * volume / 0.2 + ATMOSPHERE * volume
        energy += 0.5 * p["mass"] * state["speed"] ** 2
        energy += 0.5 * p["bristle_stiffness"] * state["bristle"] ** 2
        energy += 0.5 * p["wire_stiffness"] * stretch**2
        energy += 0.5 * p["stop_stiffness"] * pushed_in**2
    return float(energy)


def energy_of_a_free_motion(settings, pressures=(3.5e5, 1.5e5), duration=0.5):
    plant = AntagonisticPairPlant(settings, 0)
    plant.channels["pressure"] = pressures
    energies, speeds = [mechanical_and_gas_energy(plant)], [0.0]
    while plant.time < duration:
        plant.advance(plant.time + settings.substep)
        energies.append(mechanical_and_gas_energy(plant))
        speeds.append(abs(float(plant.pair[0]["speed"])))
    return np.array(energies), max(speeds)


@pytest.mark.parametrize("seals", ["standard", "low-speed"])
def test_friction_and_sealed_air_never_give_energy(seals):
    energies, speed = energy_of_a_free_motion(PlantSettings(seals=seals, regulator=SEALED))
    assert speed > 0.3
    assert np.diff(energies).max() < 1e-6
    assert energies[0] - energies[-1] > 0.1


def test_without_friction_and_damping_energy_is_kept():
    settings = PlantSettings(
        friction_scale=0.0,
        regulator=SEALED,
        wire=WireSettings(damping=0.0),
        cylinder=ActuatorSettings(stop_damping=0.0),
        carriage=CarriageSettings(restitution=1.0),
    )
    energies, speed = energy_of_a_free_motion(settings)
    kinetic = 0.5 * 0.138 * speed**2
    assert kinetic > 0.3
    assert np.abs(energies - energies[0]).max() < 0.05 * kinetic


def test_the_pair_moves_the_mass_that_it_should():
    """A known force difference accelerates 0.138 kg, once the wires are taut."""
    chambers = ActuatorSettings(dead_volume=1e-3)  # so large that motion changes no pressure
    settings = PlantSettings(friction_scale=0.0, regulator=SEALED, cylinder=chambers)
    plant = AntagonisticPairPlant(settings, 0)
    plant.channels["pressure"] = 2.2e5
    plant.advance(0.3)
    assert abs(plant.truth()[1]) < 1e-9
    plant.channels["pressure"] += np.array([1e4, -1e4])
    plant.advance(plant.time + 5e-3)
    before = plant.truth()[1]
    plant.advance(plant.time + 10e-3)
    acceleration = (plant.truth()[1] - before) / 10e-3
    area = math.pi / 4 * (0.016**2 - 0.005**2)
    assert acceleration == pytest.approx(2e4 * area / 0.138, rel=0.03)


def breakaway_pressure(settings):
    """Raise the pressure slowly behind a free piston until it runs."""
    plant = AntagonisticPairPlant(settings, 0)
    plant.inject("wire_cut", 0)
    plant.set_supply(True)
    while plant.speed(0) > -2e-3:
        plant.set_pressure_setpoint(0, 10e3 * plant.time)
        plant.advance(plant.time + 2e-3)
        assert plant.time < 10.0
    return float(plant.channels[0]["pressure"]) - ATMOSPHERE


def test_breakaway_pressure_as_in_the_catalogue():
    assert breakaway_pressure(PlantSettings(friction_spread=0.0)) == pytest.approx(25e3, rel=0.06)


def test_breakaway_scales_with_friction_and_seals():
    scaled = breakaway_pressure(PlantSettings(friction_spread=0.0, friction_scale=1.6))
    assert scaled == pytest.approx(1.6 * 25e3, rel=0.06)
    low_speed = breakaway_pressure(PlantSettings(friction_spread=0.0, seals="low-speed"))
    assert low_speed == pytest.approx(2.0 / 181.5e-6, rel=0.10)


def ramp(speed, seals="standard"):
    """Drive the pair along a ramp with a PI loop and return its speeds while on the way, m/s."""
    plant = AntagonisticPairPlant(PlantSettings(seals=seals), 0)
    plant.set_supply(True)
    speeds, integral, travel = [], 0.0, 12e-3
    while plant.time < 1.0 + travel / speed:
        reference = max(plant.time - 1.0, 0.0) * speed
        error = reference - (plant.position(1) - plant.position(0)) / 2.0
        integral += error * 2e-3 if plant.time > 1.0 else 0.0
        difference = 20e6 * error + 60e6 * integral
        plant.set_pressure_setpoint(0, 0.12e6 + difference)
        plant.set_pressure_setpoint(1, 0.12e6 - difference)
        plant.advance(plant.time + 2e-3)
        if reference > travel / 3:
            speeds.append((plant.speed(1) - plant.speed(0)) / 2.0)
    return np.array(speeds)


def test_standard_seals_stick_and_slip_at_low_speed():
    speeds = ramp(2e-3)
    assert np.mean(np.abs(speeds) < 0.1 * 2e-3) > 0.5
    assert speeds.max() > 5 * 2e-3


def test_low_speed_seals_slip_less():
    assert ramp(2e-3, "low-speed").max() < 0.5 * ramp(2e-3).max()


def slide(substep):
    """Push the pair 15 mm with one pulse of pressure and return where it went, m."""
    plant = AntagonisticPairPlant(PlantSettings(substep=substep), 3)
    plant.set_supply(True)
    positions = []
    for k in range(1, 801):
        t = 2e-3 * k
        pulse = 45e3 if 0.5 <= t < 0.75 else -20e3 if 0.75 <= t < 1.2 else 0.0
        plant.set_pressure_setpoint(0, 0.12e6 + pulse)
        plant.set_pressure_setpoint(1, 0.12e6 - pulse)
        plant.advance(t)
        positions.append(plant.truth()[0])
    return np.array(positions)


def test_a_fast_motion_does_not_stick():
    positions = slide(50e-6)
    on_the_way = (positions[:-1] > 1e-3) & (positions[:-1] < 10e-3)
    assert on_the_way.sum() > 20
    assert np.diff(positions)[on_the_way].min() > 20e-3 * 2e-3  # faster than 20 mm/s throughout


def test_the_step_is_small_enough():
    fine, usual, coarse = slide(12.5e-6), slide(50e-6), slide(100e-6)
    assert 0.010 < fine.max() < 0.020
    error = np.abs(usual - fine).max()
    assert error < 12e-6
    assert np.abs(coarse - fine).max() > 1.5 * error  # it converges


def test_a_wire_pulls_and_never_pushes():
    plant = AntagonisticPairPlant(PlantSettings(), 1)
    plant.channels["extension"] += 5e-3  # both wires hang 5 mm slack
    plant.set_supply(True)
    for channel in (0, 1):
        plant.set_pressure_setpoint(channel, 0.12e6)
    slack = taut = 0
    for k in range(1, 3000):
        if k == 1000:
            plant.set_pressure_setpoint(0, 0.0)  # a free piston is all that the other must pull
        plant.advance(0.25e-3 * k)
        truth = plant.truth()
        position, extensions, tensions = truth[0], truth[2:4], truth[6:8]
        for side, extension, tension in zip((-1, 1), extensions, tensions, strict=True):
            stretch = 0.030 - extension + side * position
            assert tension >= 0.0
            if stretch < -5e-6:
                assert tension == 0.0
                slack += 1
            taut += tension > 0.0
        if k == 100:
            assert position == 0.0
    assert slack > 200
    assert taut > 1000


def test_rods_stop_at_their_ends():
    plant = AntagonisticPairPlant(PlantSettings(), 0)
    plant.set_supply(True)
    plant.set_pressure_setpoint(0, 0.5e6)
    lowest, highest = 1.0, 0.0
    while plant.time < 1.0:
        plant.advance(plant.time + 1e-3)
        lowest = min(lowest, plant.position(0), plant.position(1))
        highest = max(highest, plant.position(0), plant.position(1))
    assert -1e-3 < lowest < 1e-3
    assert 0.059 < highest < 0.061


def test_a_cut_wire_lets_the_carriage_go():
    plant = AntagonisticPairPlant(PlantSettings(), 0)
    plant.set_supply(True)
    for channel in (0, 1):
        plant.set_pressure_setpoint(channel, 0.12e6)
    plant.advance(1.0)
    plant.inject("wire_cut", 0)
    plant.advance(2.0)
    assert plant.position(0) == pytest.approx(0.0, abs=1e-3)
    assert plant.position(1) == pytest.approx(0.0, abs=1e-3)
    assert plant.truth()[6] == 0.0


@pytest.mark.parametrize("case", range(6))
def test_carriage_comes_back_from_its_stops_with_the_share_of_its_speed_that_is_set(case):
    drawn = np.random.default_rng([17, case])
    restitution, mass = drawn.uniform(0.2, 0.95), drawn.uniform(0.03, 0.3)
    carriage = CarriageSettings(mass=mass, restitution=restitution)
    plant = AntagonisticPairPlant(PlantSettings(carriage=carriage), case)
    for k in (0, 1):
        plant.inject("wire_cut", k)
    pair, speed = plant.pair[0], drawn.uniform(0.3, 2.0) * drawn.choice([-1.0, 1.0])
    pair["position"], pair["speed"] = 0.0, speed
    furthest = 0.0
    while pair["speed"] * speed > 0.0 or abs(pair["position"]) > plant.settings.home:
        plant.advance(plant.time + 1e-4)
        furthest = max(furthest, abs(pair["position"]))
    assert -pair["speed"] / speed == pytest.approx(restitution, abs=0.04)
    assert 30e-3 < furthest < 30e-3 + abs(speed) * math.sqrt(mass / carriage.stop_stiffness) + 1e-4


@pytest.mark.parametrize("channel", [0, 1])
def test_carriage_of_a_cut_wire_hits_its_end_stop_and_stays_there(channel):
    drawn = np.random.default_rng([18, channel])
    plant = AntagonisticPairPlant(PlantSettings(), int(drawn.integers(1000)))
    plant.set_supply(True)
    for k in (0, 1):
        plant.set_pressure_setpoint(k, drawn.uniform(0.12e6, 0.2e6))
    plant.advance(1.0)
    plant.inject("wire_cut", channel)
    positions = []
    while plant.time < 2.0:
        plant.advance(plant.time + 1e-3)
        positions.append(plant.truth()[0])
    assert 30e-3 < np.abs(positions).max() < 33e-3
    (stop,) = [one for one in HAZARDS if one.name == "end stop hit"]
    assert not stop.low <= positions[int(np.argmax(np.abs(positions)))] <= stop.high


def history(seed, period=2e-3):
    plant = AntagonisticPairPlant(PlantSettings(), seed)
    plant.set_supply(True)
    rows = []
    for k in range(1, 301):
        t = 2e-3 * k
        plant.set_pressure_setpoint(0, 0.12e6 + 40e3 * math.sin(5 * t))
        plant.set_pressure_setpoint(1, 0.12e6 - 40e3 * math.sin(5 * t))
        while plant.time < t - 1e-9:
            plant.advance(min(plant.time + period, t))
        rows.append((*plant.truth(), plant.pressure(0), plant.pressure(1)))
    return rows


def test_a_seed_gives_one_run_and_another_seed_another():
    assert history(7) == history(7)
    assert history(7) != history(8)


def test_the_physics_does_not_depend_on_how_time_is_sliced():
    whole, sliced = history(7), history(7, 0.35e-3)
    assert [row[:-2] for row in whole] == [row[:-2] for row in sliced]


def test_time_does_not_run_backwards():
    plant = AntagonisticPairPlant(PlantSettings(), 0)
    plant.advance(0.01)
    before = plant.truth()
    plant.advance(0.005)
    assert plant.time == pytest.approx(0.01)
    assert plant.truth() == before


def test_units_spread_within_their_bounds():
    factors = []
    for seed in range(50):
        plant = AntagonisticPairPlant(PlantSettings(), seed)
        factors += list(plant.parameters["coulomb"] / 3.0)
        assert np.abs(plant.parameters["bow"]).max() <= 0.01
    assert 0.85 <= min(factors) < 0.88
    assert 1.12 < max(factors) <= 1.15


def test_settings_that_do_not_fit_together_are_refused():
    with pytest.raises(ValueError, match="home"):
        PlantSettings(home=0.07)
    with pytest.raises(ValueError, match="rod"):
        ActuatorSettings(rod=0.016)
