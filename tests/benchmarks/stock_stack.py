"""The cylinder rig's cycle as it is usually written: python-can, canopen, filterpy, numpy, mcap.

It does what ours does: the same frames, checks, feedforward, cascade, lead and limits, and a log
with the same columns. It is written to be quick for what it is: PDO variables are looked up once,
the filters and arrays made before the first cycle.
"""

import struct
import time

import numpy as np

from drivers.canopen.mapping import pack

PERIOD = 2e-3
AREA = 1.814e-4
SPAN = 500e3
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
    threaded : bool
        Receive in canopen's own thread (`Network.connect`, as its documentation says) rather than
        drain the bus in the cycle.
    """

    def __init__(self, profile, bus, width, file, *, threaded):
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
        self.monitors, self.stop = inputs[:2], inputs[2]
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
            position.od.factor, speed.od.factor = 1e-6, 1e-5
            self.encoders.append((position, speed, alarms))
        self.filters = [_filter() for _ in range(2)]
        self.low, self.high = np.zeros(2), np.full(2, SPAN)
        self.largest_change = np.full(2, 50e6 * PERIOD)
        self.gains = np.array([30.0, 200.0 * 0.138, 2.0e4 * PERIOD])
        self.lead = np.zeros(2)
        self.lead_step, self.lead_input = _lead(600.0)
        self.lead_output = np.array([1.0, 2.0 / 40.0]), np.array([0.0, 1.0 / (40.0**2 * PERIOD)])
        self.previous = (0.0, 0.0)
        self.followed = np.zeros(2)
        self.applied = np.zeros(2)
        self.integral = 0.0
        self.frames = 0
        self.count = 0
        self.unused = [0.0] * (width - 20)
        self.pack = struct.Struct(f"<4siIQd{width}d").pack
        self.file = file
        self.writer = Writer(file, use_chunking=False)
        self.writer.start("ros2", "benchmark")
        schema = self.writer.register_schema("rig_msgs/msg/Cycle", "ros2msg", b"")
        self.channel = self.writer.register_channel("/rig/cycle", "cdr", schema)
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

        extension = np.array([position.phys for position, _, _ in self.encoders]) + 0.03
        speed = np.array([variable.phys for _, variable, _ in self.encoders])
        pressure = np.array([monitor.phys for monitor in self.monitors]) - 3277 * SPAN / 13107
        self.check(t, extension, pressure)
        read = time.perf_counter()

        for kalman, value in zip(self.filters, extension, strict=True):
            kalman.predict()
            kalman.update(value)
        states = np.array([(kalman.F @ kalman.x)[:, 0] for kalman in self.filters])
        position, velocity, _ = 0.5 * (states[1] - states[0])
        desired = self.reference(t)
        command = self.control(desired, position, velocity)
        change = np.clip(command - self.applied, -self.largest_change, self.largest_change)
        self.applied = np.clip(self.applied + change, self.low, self.high)
        for setpoint, value in zip(self.setpoints, self.applied, strict=True):
            setpoint.phys = float(value)
        self.supply.raw = 1
        controlled = time.perf_counter()

        for pdo in self.receive_pdos:
            pdo.transmit()
        self.network.sync.transmit()
        sent = time.perf_counter()

        timing = [received - began, read - received, controlled - read, sent - controlled]
        row = np.concatenate(
            [extension, speed, pressure, desired, [position, velocity], command, self.applied,
             [t], timing, self.unused]
        )  # fmt: skip
        stamp = int(t * 1e9)
        seconds, nanoseconds = divmod(stamp, 1_000_000_000)
        data = self.pack(b"\0\1\0\0", seconds, nanoseconds, self.count, t, *row)
        self.writer.add_message(self.channel, stamp, data, stamp, self.count)
        self.file.flush()
        self.count += 1

    def check(self, t, extension, pressure):
        """Raise if something is not as it must be; the values are far from their bounds."""
        alarms = any(alarm.raw for *_, alarm in self.encoders)
        if alarms or self.stop.raw & 1 != 1 or not np.all(np.isfinite(extension)):
            raise RuntimeError("an alarm, the emergency stop or a broken reading")
        for node in self.nodes.values():
            if node.emcy.active or node.nmt.state == "STOPPED":
                raise RuntimeError("a node is not well")
            if node.tpdo[1].timestamp is None or node.tpdo[1].timestamp < 0.0:
                raise RuntimeError("a node is silent")
        if np.any(extension < -0.01) or np.any(extension > 0.1):
            raise RuntimeError("outside the stroke")
        if abs(np.mean(extension) - 0.03) > 1.0:
            raise RuntimeError("the rods do not agree")
        position = 0.5 * (extension[1] - extension[0])
        if t - self.previous[0] >= 0.01:
            if abs(position - self.previous[1]) > 5.0 * (t - self.previous[0]):
                raise RuntimeError("too fast")
            self.previous = (t, position)
        self.followed += (self.applied - self.followed) * (PERIOD / 0.1)
        if np.any(np.abs(self.followed - pressure) > 2.0 * SPAN):
            raise RuntimeError("a regulator does not follow")

    def reference(self, t):
        """Return position, velocity and acceleration, as an array."""
        w = 2.0 * np.pi * 0.2
        return 2e-3 * np.array([np.cos(w * t), -w * np.sin(w * t), -w * w * np.cos(w * t)])

    def control(self, desired, position, velocity):
        """Return the setpoints of the cascade: feedforward, two loops, integral, lead."""
        error = desired[:2] - np.array([position, velocity])
        friction = 7.0 + 3.0 * np.exp(-((desired[1] / 8e-3) ** 2))
        force = (
            self.gains[1] * (error[1] + self.gains[0] * error[0])
            + 0.138 * desired[2]
            + friction * np.tanh(desired[1] / 1e-3)
            + self.integral
        )
        after = self.lead_step @ self.lead + self.lead_input * force / AREA
        level, change = self.lead_output
        wish = level @ (0.5 * (self.lead + after)) + change @ (after - self.lead)
        difference = np.clip(wish, -200e3, 200e3)
        self.lead = after
        if difference == wish:
            self.integral += self.gains[2] * error[0]
        return 120e3 + 0.5 * difference * np.array([1.0, -1.0])

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


def _lead(bandwidth):
    """Return the exact step of a critically damped low-pass over a period."""
    x, decay = bandwidth * PERIOD, np.exp(-bandwidth * PERIOD)
    step = decay * np.array([[1.0 + x, PERIOD], [-bandwidth * x, 1.0 - x]])
    return step, np.array([1.0, 0.0]) - step[:, 0]


def _filter():
    from filterpy.common import Q_discrete_white_noise
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.F = np.array([[1.0, PERIOD, 0.5 * PERIOD**2], [0.0, 1.0, PERIOD], [0.0, 0.0, 1.0]])
    kalman.H = np.array([[1.0, 0.0, 0.0]])
    kalman.R *= 1e-12 / 12.0
    kalman.Q = Q_discrete_white_noise(3, PERIOD, var=1.0)
    return kalman
