"""Joints that follow with a lag, and the rigs around them on which servo drivers are tested."""

import math
from dataclasses import fields
from types import SimpleNamespace

from drivers.canopen.bus import CanopenBus
from drivers.canopen.settings import CanBusSettings
from drivers.cia402.device import Cia402Servos
from drivers.cia402.settings import Cia402Settings, DriveSettings
from drivers.odrive.bus import OdriveBus
from drivers.odrive.device import OdriveServos
from drivers.odrive.settings import OdriveAxisSettings, OdriveBusSettings, OdriveSettings
from drivers.sim.clock import SimClock
from drivers.sim.emulated_bus import EmulatedBus
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.nodes.cia402_wiring import emulate_cia402, simulate_cia402
from drivers.sim.nodes.odrive_wiring import emulate_odrive
from drivers.sim.wiring import Installed
from rig.hal import FastCanBus

PERIOD = 0.005
_AXIS_FIELDS = [field.name for field in fields(OdriveAxisSettings)]
_DRIVE_FIELDS = [field.name for field in fields(DriveSettings)]


class LaggedJoints:
    """A plant: each joint follows its reference with a time constant, and falls without torque."""

    def __init__(self, count, *, lag=0.01, fall=0.0, start=0.0):
        self.time = 0.0
        self.lag = lag
        self.fall = fall
        self.angles = [start] * count
        self.speeds = [0.0] * count
        self.references = [[start, 0.0] for _ in range(count)]
        self.powered = [False] * count
        self.blocked = set()
        self.commands = [0] * count
        self.peak_decelerations = [0.0] * count
        self.caps = [(math.inf, math.inf)] * count
        self.channel_names = tuple(f"q{k + 1}" for k in range(count))

    def advance(self, t):
        dt = t - self.time
        assert dt >= 0.0, f"time ran backwards from {self.time} to {t}"
        if dt < 1e-6:  # too short for a speed; the next call makes up for it
            return
        self.time = t
        share = 1.0 - math.exp(-dt / self.lag)
        for k, reference in enumerate(self.references):
            before = self.angles[k]
            if k in self.blocked:
                pass
            elif self.powered[k]:
                # the servo loop is much faster than the calls: its reference moves on
                reference[0] += reference[1] * dt
                self.angles[k] += reference[1] * dt
                self.angles[k] += (reference[0] - self.angles[k]) * share
                reach = self.caps[k][0] * dt
                self.angles[k] = min(max(self.angles[k], before - reach), before + reach)
            else:
                self.angles[k] -= self.fall * dt
            self.speeds[k] = (self.angles[k] - before) / dt

    def command_joint(self, channel, position, velocity, torque_on):
        assert math.isfinite(position) and math.isfinite(velocity)
        self.commands[channel] += 1
        self.references[channel] = [position, velocity]
        self.powered[channel] = torque_on

    def limit_joint(self, channel, speed, torque):
        self.caps[channel] = (speed, torque)

    def joint_position(self, channel):
        return self.angles[channel]

    def joint_velocity(self, channel):
        return self.speeds[channel]

    def joint_torque(self, channel):
        return 0.5 if self.powered[channel] else 0.0


class End(FastCanBus):
    """One end of a wire."""

    def __init__(self, incoming, outgoing):
        self.incoming, self.outgoing = incoming, outgoing

    def send_data(self, can_id, data):
        self.outgoing.append((can_id, bytes(data)))

    def drain(self, limit):
        frames, self.incoming[:] = self.incoming[:limit], self.incoming[limit:]
        return frames

    def shutdown(self):
        pass


class Wire(End):
    """Both ends of a bus, as lists: what the master sends waits for the nodes, and back."""

    def __init__(self):
        self.to_nodes = []
        self.to_master = []
        self.log = []
        super().__init__(self.to_master, self.to_nodes)
        self.nodes_end = End(self.to_nodes, self.to_master)


class ServoRig:
    """One bus with emulated drives, its production driver, and a loop of 200 Hz."""

    def __init__(self, plant, make_bus, make_driver, nodes, *, faults=(), latency=3e-4, loss=0.0):
        self.plant = plant
        self.wire = Wire()
        self.side = EmulatedBus("can0", self.wire.nodes_end, nodes)
        self.frames = []
        self.side.monitor = lambda t, can_id, data: self.frames.append((t, can_id, data))
        settings = SimpleNamespace(seed=1, bus_latency=latency, frame_loss=loss, faults=faults)
        self.rig = EmulatedRig(plant, [self.side], settings)
        self.clock = SimClock(self.rig)
        self.bus = make_bus(lambda: self.wire, self.clock)
        self.driver = make_driver(self.bus)
        self.command = None

    def open(self):
        self.bus.open()
        self.driver.connect()

    def start(self, cycles=60):
        """Connect, arm, and cycle until the joints follow."""
        self.open()
        self.driver.arm()
        for _ in range(cycles):
            self.cycle()
            if self.driver.is_enabled:
                return
        raise AssertionError("the joints were never enabled")

    def cycle(self, command=None):
        """Run one cycle of the loop; `command` is called where a mechanism would write."""
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)

    def run(self, cycles, command=None):
        for k in range(cycles):
            self.cycle(None if command is None else lambda k=k: command(k))

    def safe_cycles(self, cycles):
        """What the loop does after a fault: safe setpoints, and no checks."""
        for _ in range(cycles):
            self.driver.make_safe()
            now = self.clock.now()
            self.bus.receive(now)
            self.bus.transmit(now)
            self.clock.sleep_until(now + PERIOD)

    def inject(self, device, fault, value=None):
        self.rig.inject(device, fault, value)

    def sent(self, can_id):
        """Return the data of the frames with an identifier so far."""
        return [data for _, found, data in self.frames if found == can_id]


def cia402_settings(joints=2, **changes):
    """Joints that differ in sign, offset and gear."""
    drive = {key: changes.pop(key) for key in list(changes) if key in _DRIVE_FIELDS}
    return Cia402Settings(
        joints={
            f"q{k + 1}": DriveSettings(
                **{
                    "node": k + 1,
                    "counts_per_turn": 2.0**17,
                    "gear": 100.0 + k,
                    "reversed": bool(k % 2),
                    "offset": 0.1 * k,
                    "limits": (-2.0, 2.0),
                    "deceleration": 8.0,
                    **drive,
                }
            )
            for k in range(joints)
        },
        **changes,
    )


def cia402_rig(joints=2, *, plant=None, bus_settings=None, faults=(), loss=0.0, **changes):
    """Return a rig of emulated CiA 402 drives under the production driver."""
    settings = cia402_settings(joints, **changes)
    plant = plant or LaggedJoints(joints)
    nodes = emulate_cia402(Installed("arm", settings, plant, tuple(range(joints))))
    can = CanBusSettings("virtual", "can0", **(bus_settings or {}))
    return ServoRig(
        plant,
        lambda open_bus, clock: CanopenBus("can0", can, open_bus, clock, PERIOD),
        lambda bus: Cia402Servos("arm", settings, bus),
        nodes,
        faults=faults,
        loss=loss,
    )


def odrive_settings(joints=2, **changes):
    """Axes that differ in sign, offset and gear."""
    own = {key: changes.pop(key) for key in list(changes) if key in _AXIS_FIELDS}
    return OdriveSettings(
        joints={
            f"q{k + 1}": OdriveAxisSettings(
                **{
                    "axis": k + 1,
                    "gear": 8.0 + k,
                    "reversed": bool(k % 2),
                    "offset": 0.1 * k,
                    "limits": (-2.0, 2.0),
                    "deceleration": 8.0,
                    **own,
                }
            )
            for k in range(joints)
        },
        **changes,
    )


def odrive_rig(joints=2, *, plant=None, bus_settings=None, faults=(), loss=0.0, **changes):
    """Return a rig of emulated ODrives under the production driver."""
    settings = odrive_settings(joints, **changes)
    plant = plant or LaggedJoints(joints, lag=0.05)  # the maker's gain: 20 (turn/s)/turn
    nodes = emulate_odrive(Installed("arm", settings, plant, tuple(range(joints)), serial=0x1234))
    can = OdriveBusSettings("virtual", "can0", **(bus_settings or {}))
    return ServoRig(
        plant,
        lambda open_bus, clock: OdriveBus("can0", can, open_bus, clock, PERIOD),
        lambda bus: OdriveServos("arm", settings, bus),
        nodes,
        faults=faults,
        loss=loss,
    )


class SimRig(ServoRig):
    """Joints straight on the plant, with the calls of the other rigs."""

    def __init__(self, plant, settings):
        self.plant = plant
        self.clock = SimClock(plant)
        self.bus = NoBus()
        self.driver = simulate_cia402(
            Installed("arm", settings, plant, tuple(range(len(plant.angles)))), self.clock
        )

    def inject(self, device, fault, value=None):
        assert device == self.driver.name
        self.driver.inject(fault, value)


class NoBus:
    """What is left of a bus where there is none."""

    def open(self):
        pass

    receive = transmit = check = lambda self, now: None
    make_safe = close = open


def sim_rig(joints=2, *, plant=None, **changes):
    """Return a rig of simulated servos on the settings of CiA 402 drives."""
    return SimRig(plant or LaggedJoints(joints), cia402_settings(joints, **changes))
