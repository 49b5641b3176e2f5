"""What every pressure regulator and every linear encoder does, whatever is behind it.

The suites are those of `rig.testing`, over the production driver on an emulated node and over the
device that stands straight on the plant, with what these devices do besides.
"""

import math
from functools import partial
from types import SimpleNamespace

import pytest
from servo_bench import NoBus, Wire

from drivers.canopen.bus import CanopenBus
from drivers.canopen.settings import CanBusSettings
from drivers.cia401.channel_settings import MonitorSignal, RegulatorChannel, SetpointSignal
from drivers.cia401.device import Cia401Regulators
from drivers.cia401.settings import Cia401Settings, FollowingSettings
from drivers.cia406.device import Cia406Encoder
from drivers.cia406.settings import Cia406Settings
from drivers.sim.clock import SimClock
from drivers.sim.emulated_bus import EmulatedBus
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.nodes.cia401_wiring import emulate_cia401, simulate_cia401
from drivers.sim.nodes.cia406_wiring import emulate_cia406, simulate_cia406
from drivers.sim.wiring import Installed
from rig.hal import DeviceFault, LimitExceeded
from rig.testing.devices import EmergencyStopSuite, LinearEncoderSuite, PressureRegulatorSuite

PERIOD = 0.002


class Bench:
    """Two chambers that follow with a lag while the supply is open, and two rods."""

    def __init__(self):
        self.time = 0.0
        self.setpoints = [0.0, 0.0]
        self.pressures = [0.0, 0.0]
        self.extensions = [0.010, 0.020]
        self.speeds = [0.0, 0.0]
        self.supply = None
        self.channel_names = ("agonist", "antagonist")

    def advance(self, t):
        dt = t - self.time
        assert dt >= 0.0
        self.time = t
        share = 1.0 - math.exp(-dt / 0.01)
        for k, setpoint in enumerate(self.setpoints):
            wanted = setpoint if self.supply else 0.0
            self.pressures[k] += (wanted - self.pressures[k]) * share
            self.extensions[k] += self.speeds[k] * dt

    def set_pressure_setpoint(self, channel, pressure):
        self.setpoints[channel] = pressure

    def pressure(self, channel):
        return self.pressures[channel]

    def set_supply(self, open):
        self.supply = open

    def position(self, channel):
        return self.extensions[channel]

    def speed(self, channel):
        return self.speeds[channel]


class Rig:
    """One device in a loop, with or without a bus: the bench of its suite."""

    period = PERIOD

    def __init__(self, plant, make_driver=None, node=None, simulate=None):
        self.plant = plant
        if simulate is None:
            self.wire = Wire()
            self.target = node
            side = EmulatedBus("can0", self.wire.nodes_end, [node])
            settings = SimpleNamespace(seed=1, bus_latency=3e-4, frame_loss=0.0, faults=())
            world = EmulatedRig(plant, [side], settings)
            self.clock = SimClock(world)
            can = CanBusSettings("virtual", "can0")
            self.bus = CanopenBus("can0", can, lambda: self.wire, self.clock, PERIOD)
            self.device = make_driver(self.bus)
            self.inject = lambda fault, value=None: world.inject(node.name, fault, value)
        else:
            self.clock = SimClock(plant)
            self.bus = NoBus()
            self.device = simulate(self.clock)
            self.inject = self.device.inject

    def open(self):
        self.bus.open()
        self.device.connect()

    def start(self):
        self.open()
        self.device.arm()
        self.run(3)

    def run(self, cycles, command=None):
        for _ in range(cycles):
            now = self.clock.now()
            self.bus.receive(now)
            self.device.check(now)
            self.bus.check(now)
            if command is not None:
                command()
            self.bus.transmit(now)
            self.clock.sleep_until(now + PERIOD)

    def safe_cycles(self, cycles):
        for _ in range(cycles):
            self.device.make_safe()
            now = self.clock.now()
            self.bus.receive(now)
            self.bus.transmit(now)
            self.clock.sleep_until(now + PERIOD)

    def restart(self):
        self.device.close()
        self.device.connect()
        self.device.arm()

    def close(self):
        self.device.make_safe()
        self.bus.close()


# Pressure regulators ---------------------------------------------------------------------


def channel(sub):
    return RegulatorChannel(
        SetpointSignal(sub=sub, voltage=(0.0, 10.0), pressure=(0.0, 500e3)),
        MonitorSignal(sub=sub, raw=(3277.0, 16384.0), voltage=(1.0, 5.0), pressure=(0.0, 500e3)),
    )


REGULATORS = Cia401Settings(
    node=0x10,
    channels={"agonist": channel(1), "antagonist": channel(2)},
    supply_bit=0,
    stop_bit=0,
    following=FollowingSettings(deviation=60e3, time=0.1, response=0.02),
)


def emulated_regulators():
    plant = Bench()
    (node,) = emulate_cia401(Installed("valves", REGULATORS, plant, (0, 1)))
    return Rig(plant, lambda bus: Cia401Regulators("valves", REGULATORS, bus), node)


def simulated_regulators():
    plant = Bench()
    return Rig(
        plant, simulate=partial(simulate_cia401, Installed("valves", REGULATORS, plant, (0, 1)))
    )


class TestPressureRegulator(PressureRegulatorSuite, EmergencyStopSuite):
    settling, tolerance = 0.12, 100.0

    @pytest.fixture(params=[emulated_regulators, simulated_regulators])
    def make_bench(self, request):
        return request.param

    def pressures(self, bench):
        return tuple(bench.plant.pressures)

    def test_its_name_range_and_channels_are_the_settings(self, bench):
        assert bench.device.name == "valves"
        assert bench.device.channels == ("agonist", "antagonist")
        assert bench.device.pressure_range == (0.0, 500e3)

    def test_connecting_opens_no_supply(self, make_bench):
        rig = make_bench()
        rig.open()
        assert rig.plant.setpoints == pytest.approx([0.0, 0.0], abs=20.0)
        assert not rig.plant.supply

    def test_a_setpoint_acts_in_its_own_cycle(self, bench):
        bench.run(1, lambda: bench.device.set_pressure((250e3, 250e3)))
        assert bench.plant.setpoints == pytest.approx([250e3, 250e3], abs=20.0)

    def test_make_safe_shuts_the_supply(self, bench):
        bench.run(60, lambda: bench.device.set_pressure((300e3, 300e3)))
        bench.safe_cycles(5)
        assert not bench.plant.supply

    @pytest.mark.parametrize("number", [0, 1])
    def test_a_broken_monitor_names_its_channel(self, bench, number):
        bench.inject("wire_break", number)
        name = bench.device.channels[number]
        with pytest.raises(DeviceFault, match=f"valves.*monitor of {name}.*broken wire"):
            bench.run(10)

    def test_a_regulator_that_does_not_follow_is_named(self, bench):
        bench.inject("output_stuck", 1)
        with pytest.raises(DeviceFault, match=r"valves.*antagonist does not follow its setpoint"):
            bench.run(200, lambda: bench.device.set_pressure((300e3, 300e3)))


@pytest.mark.parametrize("bad", [(600e3, 0.0), (0.0, -50e3), (float("nan"), 0.0)])
def test_the_driver_refuses_setpoints_that_no_mechanism_should_send(bad):
    """The devices without a bus leave this to the mechanism, as nothing can be harmed."""
    rig = emulated_regulators()
    rig.start()
    with pytest.raises(LimitExceeded, match="valves: setpoint of"):
        rig.device.set_pressure(bad)


# Linear encoders -------------------------------------------------------------------------

ENCODER = Cia406Settings(node=0x20, stroke=0.060, step=1e-6, max_speed=1.0)
REVERSED = Cia406Settings(node=0x20, stroke=0.060, step=5e-6, reversed=True, offset=1e-3)


def emulated_encoder(settings=ENCODER):
    plant = Bench()
    (node,) = emulate_cia406(Installed("rod", settings, plant, (1,)))
    return Rig(plant, lambda bus: Cia406Encoder("rod", settings, bus), node)


def simulated_encoder(settings=ENCODER):
    plant = Bench()
    return Rig(plant, simulate=partial(simulate_cia406, Installed("rod", settings, plant, (1,))))


class TestLinearEncoder(LinearEncoderSuite):
    @pytest.fixture(params=[emulated_encoder, simulated_encoder])
    def make_bench(self, request):
        return request.param

    def test_its_name_and_stroke_are_the_settings(self, bench):
        assert bench.device.name == "rod"
        assert bench.device.channels == ("rod",)
        assert bench.device.stroke == 0.060

    @pytest.mark.parametrize("settings", [ENCODER, REVERSED])
    def test_it_measures_its_own_rod_in_its_steps(self, make_bench, settings):
        rig = make_bench(settings)
        rig.plant.extensions[1] = 0.0234567
        rig.start()
        (extension,) = rig.device.position().value
        assert extension == pytest.approx(0.0234567, abs=0.6 * settings.step)
        steps = (extension - settings.offset) / settings.step
        if settings is ENCODER:
            assert steps == pytest.approx(round(steps), abs=1e-6)

    @pytest.mark.parametrize("speed", [0.05, -0.05])
    def test_a_rod_that_moves(self, bench, speed):
        bench.plant.speeds[1] = speed
        bench.run(100)
        (extension,) = bench.device.position().value
        expected = 0.020 + speed * (bench.device.position().t - 3 * PERIOD)
        assert extension == pytest.approx(expected, abs=1.2e-3)
        assert bench.device.velocity().value[0] == pytest.approx(speed, abs=2e-3)

    def test_a_jump_is_a_fault_that_names_the_rod(self, bench):
        bench.run(5)
        bench.inject("jump", 0.01)
        with pytest.raises(DeviceFault, match=r"rod.*position jumped"):
            bench.run(5)

    def test_an_alarm_is_a_fault_that_names_the_rod(self, bench):
        bench.inject("alarm")
        with pytest.raises(DeviceFault, match=r"rod.*position error"):
            bench.run(5)
