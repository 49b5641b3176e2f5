"""Flow and chamber pressure, against figures that are not in the code."""

import itertools
import math

import pytest

from drivers.sim.plants.pneumatics import (
    ATMOSPHERE,
    REFERENCE_DENSITY,
    flow_function,
    mass_flow,
    step_pressure,
)
from drivers.sim.plants.regulator_settings import RegulatorSettings

BAR = 1e5


def test_flow_is_choked_below_the_critical_ratio_and_none_at_equal_pressures():
    assert flow_function(0.0, 0.3) == 1.0
    assert flow_function(0.3, 0.3) == 1.0
    assert flow_function(1.0, 0.3) == 0.0
    # ISO 6358 in the subsonic range is an ellipse: at half way down, sqrt(3)/2.
    assert flow_function(0.65, 0.3) == pytest.approx(math.sqrt(0.75))


def test_flow_falls_without_a_jump_as_the_ratio_rises():
    ratios = [k / 10_000 for k in range(10_001)]
    flows = [flow_function(ratio, 0.3) for ratio in ratios]
    drops = [before - after for before, after in itertools.pairwise(flows)]
    assert min(drops) >= 0.0
    assert max(drops) < 0.005


def test_nothing_flows_against_the_pressure():
    assert mass_flow(3e-9, 0.3, 2 * BAR, 3 * BAR) == 0.0


def test_catalogue_flow_of_the_regulator():
    """200 L/min (ANR) at a supply of 1.0 MPa gauge, the catalogue's conditions."""
    regulator = RegulatorSettings()
    flow = mass_flow(
        regulator.conductance_in, regulator.critical_ratio, 1.0e6 + ATMOSPHERE, ATMOSPHERE
    )
    litres_per_minute = flow / REFERENCE_DENSITY * 60_000
    assert litres_per_minute == pytest.approx(200, rel=0.03)


def test_a_closed_chamber_keeps_p_v_to_the_n_whatever_the_step():
    pressure, volume = 3 * BAR, 12e-6
    start = pressure * volume**1.2
    for k in range(1000):
        new_volume = 12e-6 + 4e-6 * math.sin(k)
        pressure = step_pressure(pressure, volume, new_volume, 0.0, 0.0, 50e-6)
        volume = new_volume
    assert pressure * volume**1.2 == pytest.approx(start, rel=1e-9)


def test_filling_heats_and_exhausting_does_not():
    """Adiabatic filling raises the pressure 1.4 times as fast as isothermal exhausting lowers."""
    flow, volume, dt = 1e-4, 12e-6, 50e-6
    filled = step_pressure(3 * BAR, volume, volume, flow, 0.0, dt) - 3 * BAR
    exhausted = 3 * BAR - step_pressure(3 * BAR, volume, volume, 0.0, flow, dt)
    assert exhausted == pytest.approx(flow * dt * 287.05 * 293.15 / volume)
    assert filled == pytest.approx(1.4 * exhausted)
