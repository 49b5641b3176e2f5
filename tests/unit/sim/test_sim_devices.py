"""Capability-level devices on a plant that only remembers."""

import numpy as np
import pytest

from drivers.sim.clock import SimClock
from drivers.sim.direct.encoders import SimulatedEncoder
from drivers.sim.direct.regulators import SimulatedRegulators
from rig.hal import DeviceFault

PERIOD = 2e-3


class Board:
    """A plant that does as it is told at once."""

    def __init__(self):
        self.time = 0.0
        self.pressures = [0.0, 0.0]
        self.supply = None

    def advance(self, t):
        self.time = t

    def set_pressure_setpoint(self, channel, pressure):
        self.pressures[channel] = pressure

    def pressure(self, channel):
        return self.pressures[channel]

    def set_supply(self, open):
        self.supply = open

    def position(self, channel):
        return 0.03 + 0.01 * self.time

    def speed(self, channel):
        return 0.01


@pytest.fixture
def board():
    return Board()


@pytest.fixture
def clock(board):
    return SimClock(board)


@pytest.fixture
def regulators(board, clock):
    device = SimulatedRegulators(
        "regulators", ("agonist", "antagonist"), board, clock, deviation=20e3, deviation_time=0.1
    )
    device.connect()
    device.arm()
    return device


@pytest.fixture
def encoder(board, clock):
    device = SimulatedEncoder("encoder", 0, board, clock, max_speed=0.5)
    device.connect()
    device.arm()
    return device


def cycle(clock, *devices):
    clock.sleep_until(clock.now() + PERIOD)
    for device in devices:
        device.check(clock.now())


def test_regulators_are_vented_until_they_are_armed(board, clock):
    device = SimulatedRegulators("regulators", ("agonist", "antagonist"), board, clock)
    device.connect()
    device.set_pressure((1e5, 1e5))
    assert (board.pressures, board.supply) == ([0.0, 0.0], False)
    device.arm()
    device.set_pressure((1e5, 2e5))
    assert (board.pressures, board.supply) == ([1e5, 2e5], True)


def test_make_safe_vents_closes_the_supply_and_stays(board, regulators):
    regulators.set_pressure((1e5, 2e5))
    regulators.make_safe()
    regulators.set_pressure((1e5, 2e5))
    regulators.close()
    assert (board.pressures, board.supply) == ([0.0, 0.0], False)


def test_readings_are_quantised_and_one_cycle_old(board, clock, regulators, encoder):
    cycle(clock, regulators, encoder)
    sampled = clock.now()
    board.pressures = [123_456.0, 0.0]
    clock.sleep_until(sampled + PERIOD)
    assert regulators.pressure().t == sampled
    assert regulators.pressure().value == (0.0, 0.0)
    assert encoder.position().t == sampled
    assert encoder.position().value[0] == pytest.approx(0.03002, abs=1e-9)
    assert encoder.velocity().value == (0.01,)
    regulators.check(clock.now())
    value = regulators.pressure().value[0]
    assert value != 123_456.0
    assert value == pytest.approx(123_456.0, abs=0.5e6 / 0x7FFF / 2 * 1.001)


def test_a_broken_monitor_wire_names_its_channel(clock, regulators):
    regulators.inject("wire_break", 1)
    with pytest.raises(DeviceFault, match=r"regulators: .* antagonist has a broken wire"):
        cycle(clock, regulators)
    regulators.inject("repair")
    cycle(clock, regulators)


def test_a_stuck_output_is_found_by_its_deviation(board, clock, regulators):
    regulators.inject("output_stuck", 0)
    regulators.set_pressure((1e5, 1e5))
    assert board.pressures == [0.0, 1e5]
    for _ in range(45):
        cycle(clock, regulators)
    with pytest.raises(DeviceFault, match="agonist does not follow its setpoint"):
        for _ in range(10):
            cycle(clock, regulators)


def test_emergency_stop_is_read_like_any_input(clock, regulators):
    cycle(clock, regulators)
    assert regulators.emergency_stop().value is False
    regulators.inject("emergency_stop")
    cycle(clock, regulators)
    assert regulators.emergency_stop().value is True
    regulators.inject("emergency_stop", 0)
    cycle(clock, regulators)
    assert regulators.emergency_stop().value is False


@pytest.mark.parametrize("which", ["regulators", "encoder"])
def test_a_silent_device_is_known_by_the_age_of_its_reading(which, clock, request):
    device = request.getfixturevalue(which)
    read = device.pressure if which == "regulators" else device.position
    device.inject("silent", 0.01)
    for _ in range(4):
        cycle(clock, device)
    assert read().age(clock.now()) == pytest.approx(0.008)
    for _ in range(3):
        cycle(clock, device)
    assert read().age(clock.now()) < PERIOD


def test_a_frozen_encoder_stays_fresh_and_stands_still(clock, encoder):
    encoder.inject("frozen")
    before = encoder.position().value
    for _ in range(5):
        cycle(clock, encoder)
    assert encoder.position().value == before
    assert encoder.position().t == clock.now()


@pytest.mark.parametrize("seed", range(3))
def test_an_encoder_that_measures_wrongly_says_what_its_fault_describes(clock, board, seed):
    """The rod goes 10 mm/s throughout; a fault begins where the encoder was, and adds to others."""
    encoder = SimulatedEncoder("encoder", 0, board, clock)
    encoder.connect()
    rng = np.random.default_rng(seed)
    drift, scale = rng.uniform(-5e-3, 5e-3), rng.uniform(0.5, 1.5)
    speeds = []
    for fault, value in (("drift", drift), ("mirrored", None), ("scale", scale)):
        encoder.inject(fault, value)
        (before,), began = encoder.position()
        for _ in range(100):
            cycle(clock, encoder)
        (after,), ended = encoder.position()
        speeds.append((after - before) / (ended - began))
    expected = [0.01 + drift, -0.01 + drift, -0.01 * scale + drift]
    assert speeds == pytest.approx(expected, abs=2e-5)
    encoder.inject("repair")
    encoder.inject("noisy", 1e-4)
    errors = []
    for _ in range(1000):
        cycle(clock, encoder)
        ((position,), t) = encoder.position()
        errors.append(position - 0.03 - 0.01 * t)
    assert np.std(errors) == pytest.approx(1e-4, rel=0.1)
    assert abs(np.mean(errors)) < 1e-5


@pytest.mark.parametrize(("fault", "message"), [("jump", "jumped"), ("alarm", "position error")])
def test_an_encoder_that_jumps_or_alarms_is_a_fault(clock, encoder, fault, message):
    cycle(clock, encoder)
    encoder.inject(fault)
    with pytest.raises(DeviceFault, match=message):
        for _ in range(2):
            cycle(clock, encoder)


@pytest.mark.parametrize(
    ("fault", "value"),
    [("burn", None), ("wire_break", 2), ("emergency_stop", 3), ("silent", -1.0)],
)
def test_a_fault_that_makes_no_sense_is_refused(regulators, fault, value):
    with pytest.raises(ValueError, match="regulators: "):
        regulators.inject(fault, value)
