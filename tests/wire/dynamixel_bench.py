"""A driver on an emulated chain in virtual time, for tests: joints that follow at once."""

import math
from dataclasses import dataclass, field
from types import SimpleNamespace

from drivers.dynamixel.bus import SerialBus
from drivers.dynamixel.device import DynamixelServos
from drivers.dynamixel.settings import DynamixelAxisSettings, DynamixelSettings, SerialBusSettings
from drivers.sim.clock import SimClock
from drivers.sim.dynamixel.line import EmulatedSerialBus
from drivers.sim.dynamixel.wiring import emulate_dynamixel
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.wiring import Installed

PERIOD = 5e-3
STEP = math.tau / 4096


@dataclass
class JointsThatFollow:
    """Joints that are where they are told to be, as long as they have torque."""

    angles: list = field(default_factory=lambda: [0.1 * k for k in range(12)])
    velocities: list = field(default_factory=lambda: [0.0] * 12)
    torque_on: list = field(default_factory=lambda: [False] * 12)
    blocked: set = field(default_factory=set)
    speeds: dict = field(default_factory=dict)
    time: float = 0.0

    def advance(self, t):
        assert t >= self.time, f"time ran backwards from {self.time} to {t}"
        for k, velocity in enumerate(self.velocities):
            self.angles[k] += velocity * (t - self.time)
        self.time = t

    def command_joint(self, channel, position, velocity, torque_on):
        self.torque_on[channel] = torque_on
        self.velocities[channel] = velocity if torque_on else 0.0
        if torque_on and channel not in self.blocked:
            self.angles[channel] = position

    def limit_joint(self, channel, speed, torque):
        self.speeds[channel] = speed

    def joint_position(self, channel):
        return self.angles[channel]

    def joint_velocity(self, channel):
        return self.velocities[channel]

    def joint_torque(self, channel):
        return 0.0


def joints(count, **more):
    return {
        f"joint_{k + 1}": DynamixelAxisSettings(**{"id": k + 1, "max_speed": 1e3, **more})
        for k in range(count)
    }


class Bench:
    """Bus, driver, emulated chain and clock, and the loop's order of calls."""

    def __init__(self, count=3, *, bus=None, faults=(), seed=0, frame_loss=0.0, **device):
        self.plant = JointsThatFollow()
        device.setdefault("joints", joints(count))
        self.settings = DynamixelSettings(**device)
        self.bus_settings = SerialBusSettings("emulated", **{"baudrate": 4_000_000, **(bus or {})})
        installed = Installed("legs", self.settings, self.plant, tuple(range(count)))
        (self.node,) = emulate_dynamixel(installed)
        self.line = EmulatedSerialBus("chain", self.bus_settings.baudrate, [self.node])
        world = SimpleNamespace(seed=seed, bus_latency=200e-6, frame_loss=frame_loss, faults=faults)
        self.world = EmulatedRig(self.plant, [self.line], world)
        self.clock = SimClock(self.world)
        self.bus = SerialBus("chain", self.bus_settings, lambda: self.line.port, self.clock, PERIOD)
        self.device = DynamixelServos("legs", self.settings, self.bus)
        self.cycles = 0

    def start(self):
        self.bus.open()
        self.device.connect()
        self.device.arm()
        return self

    def cycle(self, command=None, count=1):
        """Run cycles as the loop does; raises what `check` raises."""
        for _ in range(count):
            now = self.clock.now()
            self.bus.receive(now)
            self.device.check(now)
            self.bus.check(now)
            if command is not None:
                command(self.device)
            self.bus.transmit(now)
            self.cycles += 1
            self.clock.sleep_until(now + PERIOD)

    def cycles_until_fault(self, limit=20):
        """Return how many cycles pass until a fault is raised, and the fault."""
        for k in range(limit):
            try:
                self.cycle()
            except Exception as error:
                return k + 1, error
        raise AssertionError(f"no fault in {limit} cycles")

    def servo(self, k):
        return self.node.stations[k].servo
