"""The inner loop of a valve: its flow map against the norm's formula, and what it does to air."""

import math

import numpy as np
import pytest

from controllers.compiled import KernelMemory
from controllers.cylinder.pressure_loop import ChamberModel, PressureLoop, PressureLoopSettings
from controllers.cylinder.valve_flow import SupplyModel, ValveFlow, ValveModel

ATMOSPHERE, RT = 101_325.0, 287.05 * 293.15
PERIOD = 1e-3
CHAMBER = ChamberModel(area=181.5e-6, volume=12e-6, bandwidth=250.0, damping=1.0)


def iso_flow(conductance, ratio, upstream, downstream):
    """ISO 6358-1, equations (1) and (2), as a person would type them."""
    if downstream / upstream <= ratio:
        return conductance * 1.185 * upstream
    share = (downstream / upstream - ratio) / (1.0 - ratio)
    return conductance * 1.185 * upstream * math.sqrt(1.0 - share**2)


def drawn_valve(rng):
    return ValveModel(
        feeds_from=rng.uniform(0.0, 0.04), exhausts_from=-rng.uniform(0.001, 0.04),
        conductance_in=rng.uniform(1e-9, 8e-9), conductance_out=rng.uniform(1e-9, 8e-9),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(8))
def test_the_opening_for_a_flow_passes_that_flow(seed):
    rng = np.random.default_rng(seed)
    valve, supply = drawn_valve(rng), SupplyModel(rng.uniform(5e5, 8e5), rng.uniform(0.2, 0.5))
    flow = ValveFlow(valve, supply)
    checked = 0
    for _ in range(50):
        pressure = ATMOSPHERE + rng.uniform(30e3, 400e3)
        wanted = rng.choice([-1.0, 1.0]) * rng.uniform(5e-6, 3e-4)
        opening = flow.opening(wanted, pressure)
        if wanted > 0.0:
            share = (opening - valve.feeds_from) / (1.0 - valve.feeds_from)
            source, sink, port = supply.pressure + ATMOSPHERE, pressure, valve.conductance_in
        else:
            share = (opening - valve.exhausts_from) / (-1.0 - valve.exhausts_from)
            source, sink, port = pressure, ATMOSPHERE, valve.conductance_out
        # Less than 0.2 % of a port runs straight through the dead zone.
        if share >= 2e-3 and abs(opening) < 1.0:
            checked += 1
            passed = iso_flow(share * port, supply.critical_ratio, source, sink)
            assert passed == pytest.approx(abs(wanted), rel=1e-9)
    assert checked > 15


def test_the_opening_rises_with_the_flow_without_a_step():
    flow = ValveFlow(ValveModel(0.02, -0.01, 4e-9, 3e-9), SupplyModel())
    openings = [flow.opening(m, 220e3) for m in np.linspace(-5e-5, 5e-5, 4001)]
    steps = np.diff(openings)
    assert np.all(steps > 0.0)
    assert steps.max() < 3e-4  # the dead zone of 0.03 is not passed in one go
    assert flow.opening(0.0, 220e3) == pytest.approx(0.005, abs=1e-4)


@pytest.mark.parametrize("pressure", [1e3, ATMOSPHERE, 801_325.0, 2e6])
@pytest.mark.parametrize("wanted", [-1.0, -1e-9, 0.0, 1e-9, 1.0])
def test_no_pressure_makes_an_opening_that_no_spool_has(pressure, wanted):
    opening = ValveFlow(ValveModel(), SupplyModel()).opening(wanted, pressure)
    assert -1.0 <= opening <= 1.0


def test_a_valve_that_feeds_and_exhausts_at_once_is_refused():
    with pytest.raises(ValueError, match=r"exhausts_from \(0.01\) is not below feeds_from"):
        ValveModel(feeds_from=0.01, exhausts_from=0.01)


class Air:
    """A chamber of constant exponent behind an ideal valve; integrated finely, by itself."""

    def __init__(self, valve, supply, pressure):
        self.valve, self.supply, self.pressure = valve, supply, pressure

    def flow(self, opening):
        p = self.pressure + ATMOSPHERE
        if opening > self.valve.feeds_from:
            share = (opening - self.valve.feeds_from) / (1.0 - self.valve.feeds_from)
            source = self.supply.pressure + ATMOSPHERE
            return iso_flow(share * self.valve.conductance_in, 0.3, source, p)
        if opening < self.valve.exhausts_from:
            share = (self.valve.exhausts_from - opening) / (1.0 + self.valve.exhausts_from)
            return -iso_flow(share * self.valve.conductance_out, 0.3, p, ATMOSPHERE)
        return 0.0

    def step(self, opening, extension, speed):
        for _ in range(20):
            volume = CHAMBER.volume - CHAMBER.area * extension
            squeeze = (self.pressure + ATMOSPHERE) * CHAMBER.area * speed
            rate = 1.2 * (RT * self.flow(opening) + squeeze) / volume
            self.pressure += rate * PERIOD / 20
            extension += speed * PERIOD / 20


def model_response(t, start, end, w=250.0):
    return end + (start - end) * (1.0 + w * t) * np.exp(-w * t)


@pytest.mark.parametrize(("start", "end"), [(120e3, 180e3), (180e3, 90e3)])
def test_on_a_valve_as_it_is_told_the_pressure_is_that_of_the_model(start, end):
    valve, supply = ValveModel(0.02, -0.01, 4e-9, 3.6e-9), SupplyModel()
    loop = PressureLoop(
        PressureLoopSettings(gain=100.0, lag=PERIOD, preview=0.0),
        CHAMBER, valve, supply, PERIOD,
    )  # fmt: skip
    air = Air(valve, supply, start)
    loop.reset(start, 0.03)
    times, pressures = np.arange(1, 101) * PERIOD, []
    for _ in times:
        air.step(loop.step(end, air.pressure, 0.03), 0.03, 0.0)
        pressures.append(air.pressure)
    off = np.array(pressures) - model_response(times, start, end)
    assert np.abs(off).max() < 0.04 * abs(end - start)
    assert abs(off[-1]) < 1.2e3  # which would open the valve by what is rounded


@pytest.mark.parametrize("speed", [0.05, -0.05])
def test_the_flow_of_a_moving_piston_is_made_up_for(speed):
    """The pressure of a shut chamber would go off by 24 kPa in this time."""
    valve, supply = ValveModel(0.02, -0.01, 4e-9, 3.6e-9), SupplyModel()
    loop = PressureLoop(
        PressureLoopSettings(gain=100.0, lag=PERIOD, preview=0.0),
        CHAMBER, valve, supply, PERIOD,
    )  # fmt: skip
    air, extension = Air(valve, supply, 120e3), 0.03
    loop.reset(120e3, extension)
    worst = 0.0
    for k in range(100):
        opening = loop.step(120e3, air.pressure, extension)
        air.step(opening, extension, speed)
        extension += speed * PERIOD
        if k > 20:
            worst = max(worst, abs(air.pressure - 120e3))
    assert worst < 1.5e3


def follow(loop, air, seconds):
    """Return the greatest error, Pa, over ramps to and fro in a chamber that is nearly shut."""
    worst = 0.0
    loop.reset(air.pressure, 0.05)
    for k in range(round(seconds / PERIOD)):
        wanted = 150e3 + 50e3 * abs(4.0 * (k * PERIOD % 0.5) - 1.0)
        air.step(loop.step(wanted, air.pressure, 0.05), 0.05, 0.0)
        worst = max(worst, abs(air.pressure - loop.pressure))
    return worst


@pytest.mark.parametrize("off", [0.01, -0.008])
def test_where_the_ports_begin_is_learnt(off):
    supply, told = SupplyModel(), ValveModel(0.01, -0.01, 4e-9, 3.6e-9)
    true = ValveModel(0.01 + off, -0.01 + off, 4e-9, 3.6e-9)
    worst = {}
    for learning in (0.0, 1.4e-5):
        settings = PressureLoopSettings(gain=80.0, lag=PERIOD, preview=0.0, learning=learning)
        loop, air = PressureLoop(settings, CHAMBER, told, supply, PERIOD), Air(true, supply, 2e5)
        follow(loop, air, 2.0)
        worst[learning] = follow(loop, air, 1.0)
    assert worst[1.4e-5] < 0.4 * worst[0.0]


def test_what_is_learnt_stays_near_what_is_told():
    """A valve that is stuck, or a tube that is off, teaches no more than a valve may be off by."""
    told = ValveModel(0.01, -0.012, 4e-9, 3.6e-9)
    loop = PressureLoop(PressureLoopSettings(), CHAMBER, told, SupplyModel(), PERIOD)
    loop.reset(120e3, 0.03)
    flow = loop._flow
    for measured, feeds, exhausts in (
        (20e3, 0.03, -0.012),
        (450e3, 0.03, -0.032),
        (250e3, 0.03, -0.032),
    ):
        for _ in range(2000):
            loop.step(200e3, measured, 0.03)
        assert flow.feeds == pytest.approx(feeds)
        assert flow.exhausts == pytest.approx(exhausts)


def test_a_pressure_of_0_vents_whatever_is_measured():
    loop = PressureLoop(PressureLoopSettings(), CHAMBER, ValveModel(), SupplyModel(), PERIOD)
    loop.reset(120e3, 0.03)
    assert [loop.step(0.0, p, 0.03) for p in (120e3, 5e3, -500.0)] == [-1.0, -1.0, -1.0]
    assert loop.step(50e3, 0.0, 0.03) > 0.0


@pytest.mark.parametrize("damping", [0.6, 1.0, 1.6])
def test_the_reference_model_is_the_second_order_that_laws_are_told_of(damping):
    chamber = ChamberModel(CHAMBER.area, CHAMBER.volume, 200.0, damping)
    loop = PressureLoop(PressureLoopSettings(), chamber, ValveModel(), SupplyModel(), PERIOD)
    loop.reset(100e3, 0.03)
    fine, rate = 100e3, 0.0
    for _ in range(60):
        loop.step(140e3, 100e3, 0.03)
        for _ in range(2000):
            dt = PERIOD / 2000
            rate += dt * (200.0**2 * (140e3 - fine) - 2.0 * damping * 200.0 * rate)
            fine += dt * rate
        assert loop.pressure == pytest.approx(fine, abs=15.0)


def test_compiled_it_is_the_same():
    rng = np.random.default_rng(5)
    loop = PressureLoop(PressureLoopSettings(), CHAMBER, ValveModel(), SupplyModel(), PERIOD)
    loop.reset(120e3, 0.03)
    memory = KernelMemory(loop)
    step = memory.bind(PressureLoop.step)
    for _ in range(200):
        wanted, measured = rng.uniform(-10e3, 400e3), rng.uniform(0.0, 400e3)
        extension = rng.uniform(0.0, 0.06)
        assert step(wanted, measured, extension) == pytest.approx(
            loop.step(wanted, measured, extension), rel=1e-12, abs=1e-15
        )
