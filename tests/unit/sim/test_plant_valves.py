"""The pair on proportional valves: spools, ports and chambers against formulas, and what breaks."""

import math

import numpy as np
import pytest

from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.settings import TubedActuatorSettings
from drivers.sim.plants.spool import port_area
from drivers.sim.plants.valve_pair import ValvePairPlant
from drivers.sim.plants.valve_settings import SpoolSettings, ValvePairSettings

EVEN = {
    "bandwidth_spread": 0.0, "dead_time_spread": 0.0, "overlap_spread": 0.0, "zero": 0.0,
    "conductance_spread": 0.0, "progression_spread": 0.0, "critical_ratio_spread": 0.0,
    "monitor_noise": 0.0, "monitor_error": 0.0, "supply_volume": 0.0,
}  # fmt: skip
RT = 287.05 * 293.15


def plant_of(seed=0, **valve):
    settings = ValvePairSettings(
        encoder_noise=0.0,
        valve=SpoolSettings(**{**EVEN, **valve}),
        cylinder=TubedActuatorSettings(mass=1e4),  # a piston that stays, whatever the pressure
    )
    return ValvePairPlant(settings, seed)


def fed(plant, opening, duration=0.5, at=(0, 1)):
    """Open valves for a while from now on, with the supply there at once."""
    plant.set_supply(True)
    plant.pair["supply"] = plant.pair["supply_target"]
    for channel in at:
        plant.set_opening(channel, opening)
    plant.advance(plant.time + duration)


def volume(plant, channel):
    p, state = plant.parameters[channel], plant.channels[channel]
    return p["dead_volume"] + p["area"] * (p["stroke"] - state["extension"])


def test_a_step_of_the_signal_is_that_of_a_second_order_after_the_dead_time():
    plant = plant_of(dead_time=2e-3, hysteresis=0.0, slew=1e6)
    plant.channels["opening"] = plant.channels["play"] = plant.channels["setpoint"] = 0.0
    plant.queues[:] = 0.0
    plant.set_opening(0, 0.25)
    w, z = 628.0, 0.7
    turn = w * math.sqrt(1.0 - z * z)
    for k in range(1, 160):
        plant.advance(k * 50e-6)
        t = max(plant.time - 2e-3, 0.0)
        told = 1.0 - math.exp(-z * w * t) * (math.cos(turn * t) + z * w / turn * math.sin(turn * t))
        assert plant.channels[0]["opening"] == pytest.approx(0.25 * told, abs=0.006)


def test_an_open_port_fills_an_empty_chamber_as_choked_flow_does():
    """Adiabatic filling of a constant volume: 1.4 R T / V times the choked mass flow."""
    plant = plant_of(dead_time=0.0, leakage=0.0, progression=0.0, overlap=0.0)
    plant.channels["opening"] = plant.channels["play"] = 0.5
    fed(plant, 0.5, 0.3e-3, at=(0,))
    before, t = float(plant.channels[0]["pressure"]), plant.time
    plant.advance(t + 1e-3)
    rise = (float(plant.channels[0]["pressure"]) - before) / (plant.time - t)
    opening = float(plant.channels[0]["opening"])
    flow = opening * 4.0e-9 * 1.185 * 801_325.0
    assert rise == pytest.approx(1.4 * RT / volume(plant, 0) * flow, rel=0.01)


def test_exhausting_is_isothermal_and_goes_with_the_pressure():
    plant = plant_of(dead_time=0.0, leakage=0.0, progression=0.0, overlap=0.0, hysteresis=0.0)
    plant.channels["pressure"] = 500e3
    plant.channels["opening"] = plant.channels["play"] = plant.channels["setpoint"] = -0.01
    plant.queues[:] = -0.01
    before = float(plant.channels[0]["pressure"])
    plant.advance(5e-3)
    rate = 0.01 * 3.6e-9 * 1.185 * RT / volume(plant, 0)
    left = float(plant.channels[0]["pressure"]) / before
    assert math.log(left) == pytest.approx(-rate * 5e-3, rel=0.03)


def test_within_its_overlap_a_spool_leaks_and_beyond_it_opens():
    assert port_area(0.015, 0.015, 0.25, 0.003) == pytest.approx(0.003)
    assert 0.0 < port_area(-0.015, 0.015, 0.25, 0.003) < 0.003
    assert port_area(1.0, 0.015, 0.25, 0.003) == pytest.approx(1.003)
    areas = [port_area(x, 0.015, 0.25, 0.003) for x in np.linspace(-1.0, 1.0, 401)]
    assert np.all(np.diff(areas) >= 0.0)


def test_a_spool_in_the_middle_lets_a_chamber_drift_to_where_its_leaks_balance():
    plant = plant_of()
    fed(plant, 0.0, 20.0)
    settled = float(plant.channels[0]["pressure"])
    plant.advance(plant.time + 2.0)
    assert float(plant.channels[0]["pressure"]) == pytest.approx(settled, rel=0.02)
    assert ATMOSPHERE + 100e3 < settled < 801_325.0 - 20e3


def test_without_supply_and_at_the_exhaust_nothing_is_left():
    plant = plant_of()
    fed(plant, 0.2)
    assert plant.pressure(0) > 400e3
    plant.set_supply(False)
    for channel in (0, 1):
        plant.set_opening(channel, -1.0)
    plant.advance(plant.time + 0.3)
    assert all(plant.pressure(k) < 3e3 for k in (0, 1))


def test_each_unit_is_another_and_each_seed_is_the_same():
    drawn = [ValvePairPlant(ValvePairSettings(), seed).parameters for seed in (1, 1, 2)]
    assert np.array_equal(drawn[0], drawn[1])
    for name in ("zero", "overlap_in", "overlap_out", "conductance_in", "progression_out"):
        values = {float(p[name]) for parameters in drawn for p in parameters}
        assert len(values) == 4
    assert all(p["overlap_in"] != p["overlap_out"] for p in drawn[0])


def test_the_converter_has_so_many_steps_and_ends_at_the_stroke():
    plant = plant_of(dac_bits=8)
    for asked, put_out in ((0.0, 1.0 / 255.0), (2.0, 1.0), (-2.0, -1.0), (0.5, 0.4980392)):
        plant.set_opening(0, asked)
        assert plant.channels[0]["setpoint"] == pytest.approx(put_out, abs=1e-6)
    with pytest.raises(ValueError, match="cannot take the opening nan"):
        plant.set_opening(0, math.nan)


def opened(plant, signal, duration=0.1):
    plant.set_opening(0, signal)
    plant.advance(plant.time + duration)
    return float(plant.channels[0]["opening"])


@pytest.mark.parametrize(
    ("fault", "value", "stands"),
    [
        ("valve_stuck", 0, -1.0),
        ("valve_open", 0, 1.0),
        ("valve_closed", 0, 0.0),
        ("agonist.valve_stuck", 0.3, 0.3),
        ("agonist.valve_stuck", -0.2, -0.2),
        ("agonist.valve_stuck", -3.0, -1.0),
    ],
)
def test_a_broken_valve_stands_somewhere_until_it_is_repaired(fault, value, stands):
    plant = plant_of(hysteresis=0.0)
    plant.inject(fault, value)
    assert opened(plant, 0.1) == pytest.approx(stands, abs=1e-3)
    plant.inject("repair")
    assert opened(plant, 0.1) == pytest.approx(0.1, abs=1e-3)


def test_a_valve_that_leaks_fills_a_chamber_that_it_shuts():
    plants = plant_of(leakage=0.0), plant_of(leakage=0.0)
    plants[1].inject("agonist.valve_leak", 1e-10)
    for plant in plants:
        fed(plant, 0.0, 0.2)
    assert plants[1].pressure(0) > plants[0].pressure(0) + 50e3
    assert plants[1].pressure(1) == pytest.approx(plants[0].pressure(1), abs=1e3)
    plants[1].inject("repair")
    assert plants[1].parameters[0]["past"] == 0.0


def test_a_slow_spool_and_one_whose_middle_is_off():
    plant = plant_of()
    plant.inject("agonist.valve_slow", 4.0)
    plant.inject("antagonist.valve_offset", 0.1)
    assert plant.parameters[0]["bandwidth"] == pytest.approx(157.0)
    assert plant.parameters[1]["zero"] == pytest.approx(0.1)
    plant.inject("repair")
    assert plant.parameters[0]["bandwidth"] == pytest.approx(628.0)
    assert plant.parameters[1]["zero"] == 0.0


def test_it_goes_back_to_where_it_was():
    plant = plant_of()
    fed(plant, 0.05, 0.05)
    then = plant.snapshot()
    ends = []
    for _ in range(2):
        plant.restore(then)
        plant.advance(then.steps * 50e-6 + 0.1)
        ends.append(plant.truth())
    assert ends[0] == ends[1]
