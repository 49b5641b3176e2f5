"""The cylinder rig's cycle as it is usually written: python-can, canopen, filterpy, numpy, mcap.

It does what ours does: the same frames both ways with the heartbeat, the same checks, one filter
and the same cascade (`stock_control`), the same limits, and a log with as many columns; the
benchmark compares its setpoints with ours. It is written to be quick for what it is: PDO variables
are looked up once, filter and constant arrays are made before the first cycle, no value is computed
twice.
"""

import struct
import time
from collections import deque

import numpy as np
from stock_control import StockCascade

from drivers.canopen.mapping import pack
from rig.mechanisms.cylinder.mechanism import AntagonisticPair

PERIOD = 2e-3
ENERGISE, APPROACH = 1.0, 2.0
SPAN = 500e3
ECHO_WITHIN = 5  # cycles
ECHO_SLACK = 0.5  # counts
_TYPES = {"i8": 2, "i16": 3, "i32": 4, "u8": 5, "u16": 6, "u32": 7}  # CiA 301, table 44
_SIZES = {2: 8, 3: 16, 4: 32, 5: 8, 6: 16, 7: 32}


class StockCycle:
    """One cycle of the pair: frames in, decode, estimate, control, limit, encode, out, record.

    Parameters
    ----------
    profile : Profile
        For node numbers and what their PDOs hold.
    bus : can.BusABC
        python-can's.
    width : int
        How many numbers a row of the log has.
    file : binary file
        The log.
    sine : tuple
        Amplitude (m) and frequency (Hz) of the reference.
    threaded : bool
        Receive in canopen's own thread (`Network.connect`, as its documentation says) rather than
        drain the bus in the cycle.
    """

    def __init__(self, profile, bus, width, file, sine, *, threaded):
        from canopen import Network
        from mcap.writer import Writer

        self.bus = bus
        self.network = Network()
        self.network.bus = bus
        self.threaded = threaded
        self.nodes = nodes = {
            name: self._node(entry.settings.node, entry.settings)
            for name, entry in profile.devices.items()
        }
        regulators = nodes["regulators"]
        inputs = [variable for pdo in regulators.tpdo.values() for variable in pdo.map]
        self.monitors, self.echoes, self.stop = inputs[:2], inputs[2:-1], inputs[-1]
        for monitor in self.monitors:
            monitor.od.factor = SPAN / (16384 - 3277)
        self.receive_pdos = [pdo for pdo in regulators.rpdo.values() if pdo.map]
        outputs = [variable for pdo in self.receive_pdos for variable in pdo.map]
        self.setpoints, self.supply = outputs[:2], outputs[2]
        for setpoint in self.setpoints:
            setpoint.od.factor = SPAN / 32767
        self.encoders = []
        for name in ("encoder-agonist", "encoder-antagonist"):
            position, speed, alarms = nodes[name].tpdo[1].map
            position.od.factor = 1e-6
            self.encoders.append((position, speed, alarms))
        pair = profile.mechanism_settings
        model = AntagonisticPair.model_of(pair)
        self.cascade = StockCascade(profile.controllers["cascade"], model, PERIOD)
        self.limits, self.middle = pair.limits, pair.home
        self.largest_change = pair.limits.pressure_rate * PERIOD
        self.most_apart = pair.limits.pair_force / pair.area
        self.base = np.full(2, pair.base_pressure)
        self.amplitude, self.frequency = sine
        bus_settings = next(iter(profile.buses.values())).settings
        self.master, self.heartbeat = bus_settings.master_id, bus_settings.heartbeat
        self.patience = 60.0  # the frames are fed faster or slower than the rig's own time
        self.next_heartbeat = 0.0
        self.samples = {
            node.id: [pdo for pdo in node.tpdo.values() if pdo.map] for node in nodes.values()
        }
        self.missed = dict.fromkeys(self.samples, 0)
        self.most_missed = 1000 if threaded else 2  # the thread may lag behind the feeding
        self.monitor_zero = 3277 * SPAN / 13107
        self.broken_below = 0.5 / 4.0 * SPAN - SPAN / 4.0
        self.extension = self.at_rest = self.home = None
        self.controlling = False
        self.previous = (0.0, 0.0)
        self.followed, self.followed_at = np.zeros(2), np.zeros(2)
        self.applied = np.zeros(2)
        self.told = tuple(deque([0], maxlen=ECHO_WITHIN) for _ in self.setpoints)
        self.frames = self.lost = 0
        self.count = 0
        self.unused = [0.0] * (width - 19)
        self.pack = struct.Struct(f"<4siIQd{width}d").pack
        self.file = file
        self.writer = Writer(file, use_chunking=False)
        self.writer.start("ros2", "benchmark")
        schema = self.writer.register_schema("rig_msgs/msg/Cycle", "ros2msg", b"")
        self.channel = self.writer.register_channel("/rig/cycle", "cdr", schema)
        for node in nodes.values():  # as if it had configured and started them
            node.nmt.on_heartbeat(0x700 + node.id, b"\x05", time.time())
        if threaded:
            self.network.connect()

    def step(self, t):
        """Do the cycle at rig time `t`, s."""
        began = time.perf_counter()
        if not self.threaded:
            while (message := self.bus.recv(0.0)) is not None:
                self.network.notify(message.arbitration_id, message.data, message.timestamp)
                self.frames += 1
        received = time.perf_counter()

        extension = np.array([position.phys for position, _, _ in self.encoders])
        pressure = np.array([monitor.phys for monitor in self.monitors]) - self.monitor_zero
        self.check(t, extension, pressure)
        position = 0.5 * (extension[1] - extension[0])
        read = time.perf_counter()

        desired, command = self.control(t, position, pressure)
        difference = np.clip(command[0] - command[1], -self.most_apart, self.most_apart)
        command = 0.5 * (command[0] + command[1]) + difference * np.array([0.5, -0.5])
        change = np.clip(command - self.applied, -self.largest_change, self.largest_change)
        self.applied = np.clip(self.applied + change, *self.limits.pressure)
        for setpoint, value in zip(self.setpoints, self.applied, strict=True):
            setpoint.phys = float(value)
        self.supply.raw = 1
        for setpoint, told in zip(self.setpoints, self.told, strict=True):
            told.append(setpoint.raw)
        controlled = time.perf_counter()

        for pdo in self.receive_pdos:
            pdo.transmit()
        self.network.sync.transmit()
        if t >= self.next_heartbeat:
            self.network.send_message(0x700 + self.master, b"\x05")
            self.next_heartbeat += self.heartbeat
        sent = time.perf_counter()

        timing = [received - began, read - received, controlled - read, sent - controlled]
        row = np.concatenate(
            [[t, position], extension, pressure, desired, self.cascade.estimate, command,
             self.applied, timing, self.unused]
        )  # fmt: skip
        stamp = int(t * 1e9)
        seconds, nanoseconds = divmod(stamp, 1_000_000_000)
        data = self.pack(b"\0\1\0\0", seconds, nanoseconds, self.count, t, *row)
        self.writer.add_message(self.channel, stamp, data, stamp, self.count)
        self.file.flush()
        self.count += 1

    def control(self, t, position, pressure):
        """Return the reference and the setpoints of this cycle, Pa, as the rig's run has them."""
        if t < ENERGISE:
            if self.at_rest is None:
                self.at_rest, self.applied = pressure, pressure
            self.home = position
            share = t / ENERGISE
            return np.array([position, 0.0, 0.0]), self.base * share + self.at_rest * (1.0 - share)
        if not self.controlling:
            self.controlling = True
            self.home = position
            self.cascade.reset(position, pressure)
        desired = self.reference(t - ENERGISE - APPROACH)
        return desired, self.cascade.update(position, pressure, desired)

    def reference(self, t):
        """Return position, velocity and acceleration, as an array."""
        if t < 0.0:
            s = 1.0 + t / APPROACH
            basis = np.array([s**3, s**2 / APPROACH, s / APPROACH**2])
            shape = np.array(
                [10 - 15 * s + 6 * s**2, 30 * (1 - s) ** 2, 60 * (1 - 3 * s + 2 * s**2)]
            )
            return np.array([self.home, 0.0, 0.0]) + (self.amplitude - self.home) * basis * shape
        w = 2.0 * np.pi * self.frequency
        return self.amplitude * np.array(
            [np.cos(w * t), -w * np.sin(w * t), -w * w * np.cos(w * t)]
        )

    def check(self, t, extension, pressure):
        """Raise if something is not as it must be: what the drivers and the loop look at."""
        limits = self.limits
        for node in self.nodes.values():
            if node.emcy.active or node.nmt.state != "OPERATIONAL":
                raise RuntimeError("a node is not well")
            if node.nmt.timestamp is None or time.time() - node.nmt.timestamp > self.patience:
                raise RuntimeError("a node is silent")
            for pdo in self.samples[node.id]:
                self.missed[node.id] = 0 if pdo.is_received else self.missed[node.id] + 1
                pdo.is_received = False
                if self.missed[node.id] > self.most_missed:
                    raise RuntimeError("a node does not answer SYNC any more")
        if any(alarm.raw for *_, alarm in self.encoders) or self.stop.raw & 1 != 1:
            raise RuntimeError("an alarm or the emergency stop")
        for echo, told in zip(self.echoes, self.told, strict=True):
            # Counted only: what is fed echoes the setpoints of the recorded run, not these.
            self.lost += all(abs(echo.raw - setpoint) > ECHO_SLACK for setpoint in told)
        if np.any(pressure < self.broken_below):
            raise RuntimeError("a monitor's wire is broken")
        if not np.all(np.isfinite(extension)):
            raise RuntimeError("a broken reading")
        if np.any(extension < -0.002) or np.any(extension > 0.062):
            raise RuntimeError("outside the stroke")
        if self.extension is not None and np.any(np.abs(extension - self.extension) > 2.002e-3):
            raise RuntimeError("an encoder jumped")
        self.extension = extension
        if abs(np.mean(extension) - self.middle) > limits.mismatch:
            raise RuntimeError("the rods do not agree")
        position = 0.5 * (extension[1] - extension[0])
        if not limits.position[0] <= position <= limits.position[1]:
            raise RuntimeError("the pair is outside its range")
        if t - self.previous[0] >= 0.01:
            if abs(position - self.previous[1]) > limits.speed * (t - self.previous[0]):
                raise RuntimeError("too fast")
            self.previous = (t, position)
        self.followed += (self.applied - self.followed) * (PERIOD / (0.1 + PERIOD))
        good = np.abs(self.followed - pressure) <= 80e3
        self.followed_at = np.where(good, t, self.followed_at)
        if np.any(t - self.followed_at > 0.5):
            raise RuntimeError("a regulator does not follow")

    def close(self):
        self.writer.finish()
        self.network.disconnect()

    def _node(self, number, settings):
        """Return a canopen node whose PDOs hold what the driver maps."""
        from canopen import RemoteNode

        sent = pack(settings.transmit_entries)
        taken = pack(getattr(settings, "receive_entries", ()))
        node = RemoteNode(number, _dictionary(sent, taken))
        self.network.add_node(node)
        for pdos, layouts, base in ((node.tpdo, sent, 0x180), (node.rpdo, taken, 0x200)):
            for index, layout in enumerate(layouts):
                pdo = pdos[index + 1]
                pdo.cob_id, pdo.enabled = base + 0x100 * index + number, True
                for entry in layout:
                    pdo.add_variable(entry.object, entry.sub)
        node.tpdo.subscribe()
        return node


def _dictionary(sent, taken):
    from canopen.objectdictionary import ObjectDictionary, ODArray, ODRecord, ODVariable

    objects = ObjectDictionary()
    for communication, layouts in ((0x1800, sent), (0x1400, taken)):
        for index in range(len(layouts)):
            objects.add_object(ODRecord(f"PDO {communication + index:X}", communication + index))
            mapping = communication + 0x200 + index
            objects.add_object(ODArray(f"mapping {mapping:X}", mapping))
    for entry in (entry for layout in (*sent, *taken) for entry in layout):
        name = f"object {entry.object:X} {entry.sub}"
        variable = ODVariable(name, entry.object, entry.sub)
        variable.data_type = _TYPES[entry.type]
        if not entry.sub:
            objects.add_object(variable)
            continue
        if entry.object not in objects:
            objects.add_object(ODRecord(f"record {entry.object:X}", entry.object))
        objects[entry.object].add_member(variable)
    return objects
