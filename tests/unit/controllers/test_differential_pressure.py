import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.motion import InfeasibleMotion

PERIOD = 1e-3


class Regulator:
    """A second-order regulator, integrated finely."""

    def __init__(self, bandwidth=40.0, damping=1.0):
        self.bandwidth, self.damping = bandwidth, damping
        self.pressure = self.rate = 0.0

    def hold(self, setpoint, period=PERIOD, steps=200):
        dt = period / steps
        w = self.bandwidth
        for _ in range(steps):
            pull = w * w * (setpoint - self.pressure) - 2.0 * self.damping * w * self.rate
            self.rate += dt * pull
            self.pressure += dt * self.rate
        return self.pressure


def test_split_keeps_the_mean_and_the_floor(model):
    pressures = DifferentialRange(model, floor=20e3)
    assert pressures.limit == 200e3
    agonist, antagonist = pressures.share(pressures.clip(1e9))
    assert agonist + antagonist == 2 * model.base_pressure
    assert (agonist, antagonist) == (220e3, 20e3)
    assert pressures.share(pressures.clip(-1e9)) == (20e3, 220e3)


def test_the_upper_end_of_the_range_binds_too(model):
    narrow = replace(model, pressure_max=0.15e6)
    assert DifferentialRange(narrow, floor=20e3).limit == pytest.approx(60e3)


def test_a_floor_above_the_base_pressure_is_refused(model):
    with pytest.raises(InfeasibleMotion, match="leaves no differential"):
        DifferentialRange(model, floor=model.base_pressure)


def test_lead_is_bumpless_at_rest(model):
    lead = RegulatorLead(model, 600.0, 200e3, PERIOD)
    lead.reset(31e3)
    assert [lead.update(31e3) for _ in range(5)] == pytest.approx([31e3] * 5)
    assert lead.saturation == 0


def test_lead_makes_the_regulator_follow_its_low_pass(model):
    lead, regulator = RegulatorLead(model, 300.0, 1e9, PERIOD), Regulator()
    lead.reset(0.0)
    worst = 0.0
    for k in range(1000):
        wish = 20e3 * math.sin(2 * math.pi * 3.0 * k * PERIOD)
        output = regulator.hold(lead.update(wish))
        worst = max(worst, abs(output - lead.pressure))
    assert worst < 0.01 * 20e3


def test_lead_lets_the_regulator_arrive_far_sooner_than_alone(model):
    lead, led, alone = RegulatorLead(model, 300.0, 1e9, PERIOD), Regulator(), Regulator()
    lead.reset(0.0)
    for _ in range(20):
        led.hold(lead.update(1e3))
        alone.hold(1e3)
    assert led.pressure > 950.0
    assert alone.pressure < 300.0


@given(st.lists(st.floats(-400e3, 400e3), min_size=1, max_size=20))
def test_lead_stays_within_the_range_and_knows_what_the_regulator_does(model_for_lead, wishes):
    lead, regulator = RegulatorLead(model_for_lead, 300.0, 200e3, PERIOD), Regulator()
    lead.reset(0.0)
    for wish in wishes:
        for _ in range(20):
            setpoint = lead.update(wish)
            assert abs(setpoint) <= 200e3
            if lead.saturation:
                assert setpoint == lead.saturation * 200e3
            regulator.hold(setpoint, steps=50)
            # Nothing winds up: the low-pass is where the regulator is, saturated or not.
            assert abs(regulator.pressure - lead.pressure) < 8e3


@pytest.fixture(scope="module")
def model_for_lead():
    from controllers.cylinder.types import PairModel

    return PairModel(1.8e-4, 0.138, 0.12e6, 0.0, 0.5e6, 40.0, 1.0, 6.5, 6.7, 3e-3, 30.0)
