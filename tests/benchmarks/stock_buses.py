"""Cycles of the joint, the arm and the legs as they are usually written, without their laws.

python-can with canopen's PDO variables; python-can with cantools and the DBC that ODrive's users
have; dynamixel_sdk's group reads and writes. Each takes what the nodes sent, turns it into numbers,
looks whether they are well (alive, in their state, within their limits, no faster than they may
be), limits the setpoints that it is given, sends them, and logs with mcap a row as wide as ours.
All look-ups are done before the first cycle.
"""

import struct
import time

import numpy as np
from stock_stack import _dictionary

SLACK = 1.0
"""How far beyond a reading's own range it may be, in shares of that range."""


class StockRows:
    """A log with as many columns as ours, written with mcap.

    Parameters
    ----------
    file : binary file
        Of the log.
    width : int
        Numbers in a row.
    """

    def __init__(self, file, width):
        from mcap.writer import Writer

        self._pack = struct.Struct(f"<4siIQd{width}d").pack
        self._width = width
        self._file = file
        self._writer = Writer(file, use_chunking=False)
        self._writer.start("ros2", "benchmark")
        schema = self._writer.register_schema("rig_msgs/msg/Cycle", "ros2msg", b"")
        self._channel = self._writer.register_channel("/rig/cycle", "cdr", schema)
        self._count = 0

    def write(self, t, values):
        """Write the numbers that there are, and zeros for the others."""
        stamp = int(t * 1e9)
        seconds, nanoseconds = divmod(stamp, 1_000_000_000)
        row = np.zeros(self._width)
        row[: len(values)] = values[: self._width]
        data = self._pack(b"\0\1\0\0", seconds, nanoseconds, self._count, t, *row)
        self._writer.add_message(self._channel, stamp, data, stamp, self._count)
        self._file.flush()
        self._count += 1

    def close(self):
        self._writer.finish()


class Watch:
    """Whether readings are numbers within their range and change no faster than they may.

    Parameters
    ----------
    low, high : ndarray
        As recorded, each widened by `SLACK`.
    step : ndarray
        Greatest change in a cycle.
    """

    def __init__(self, low, high, step):
        wide = SLACK * (high - low) + 1e-9
        self._low, self._high, self._step = low - wide, high + wide, step + wide
        self._before = None

    def check(self, values):
        """Raise if one of them is not as it must be."""
        if not np.all(np.isfinite(values)):
            raise RuntimeError("a broken reading")
        if np.any(values < self._low) or np.any(values > self._high):
            raise RuntimeError("outside its range")
        if self._before is not None and np.any(np.abs(values - self._before) > self._step):
            raise RuntimeError("too fast")
        self._before = values


class StockCanopen:
    """Nodes on CANopen buses by python-can and canopen.

    Parameters
    ----------
    profile : Profile
        Whose drivers describe their nodes.
    buses : mapping
        python-can's, by name.
    rows : StockRows
        The log.
    """

    def __init__(self, profile, buses, rows):
        from canopen import Network

        self._rows = rows
        self._period = profile.loop.period
        self._buses, self._nodes, self._inputs, self._outputs = [], [], [], []
        self.setpoint_ids = []
        self._samples = []
        for name, bus in buses.items():
            network = Network()
            network.bus = bus
            settings = profile.buses[name].settings
            pdos = []
            for device, entry in profile.devices.items():
                if entry.bus == name:
                    for described in entry.settings.describe_nodes(device):
                        pdos += self._add(network, name, described)
            self._buses.append([bus, network, pdos, settings.master_id, settings.heartbeat, 0.0])
        self._missed = [0] * len(self._samples)
        self.watch = None

    def _add(self, network, bus, described):
        from canopen import RemoteNode

        node = RemoteNode(described.node, _dictionary(described.transmit, described.receive))
        network.add_node(node)
        taken = []
        for pdos, layouts, base in (
            (node.tpdo, described.transmit, 0x180),
            (node.rpdo, described.receive, 0x200),
        ):
            for index, layout in enumerate(layouts):
                if not layout:
                    continue
                pdo = pdos[index + 1]
                pdo.cob_id, pdo.enabled = base + 0x100 * index + described.node, True
                for entry in layout:
                    variable = pdo.add_variable(entry.object, entry.sub)
                    quantity = described.quantities.get(entry)
                    variable.od.factor = (quantity and quantity.gain) or 1.0
                    (self._inputs if base == 0x180 else self._outputs).append(variable)
                if base == 0x180:
                    pdo.subscribe()
                    self._samples.append(pdo)
                else:
                    taken.append(pdo)
                    self.setpoint_ids.append((bus, pdo.cob_id, len(layout)))
        node.nmt.on_heartbeat(0x700 + described.node, b"\x05", time.time())
        self._nodes.append(node)
        return taken

    @property
    def factors(self):
        """SI for a count of each output."""
        return [variable.od.factor for variable in self._outputs]

    def step(self, t, setpoints):
        """Do the cycle at rig time `t` (s) with setpoints in SI."""
        began = time.perf_counter()
        for bus, network, *_ in self._buses:
            while (message := bus.recv(0.0)) is not None:
                network.notify(message.arbitration_id, message.data, message.timestamp)
        received = time.perf_counter()
        values = np.array([variable.phys for variable in self._inputs], dtype=float)
        self._check(values)
        read = time.perf_counter()
        applied = self.limit(setpoints)
        for variable, value in zip(self._outputs, applied.tolist(), strict=True):
            variable.phys = value
        controlled = time.perf_counter()
        for line in self._buses:
            _, network, pdos, master, heartbeat, due = line
            for pdo in pdos:
                pdo.transmit()
            network.sync.transmit()
            if t >= due:
                network.send_message(0x700 + master, b"\x05")
                line[-1] = due + heartbeat
        sent = time.perf_counter()
        stages = (received - began, read - received, controlled - read, sent - controlled)
        self._rows.write(t, np.concatenate([[t], values, setpoints, applied, stages]))

    def _check(self, values):
        now = time.time()
        for node in self._nodes:
            if node.emcy.active or node.nmt.state != "OPERATIONAL":
                raise RuntimeError("a node is not well")
            if node.nmt.timestamp is None or now - node.nmt.timestamp > 60.0:
                raise RuntimeError("a node is silent")
        for k, pdo in enumerate(self._samples):
            self._missed[k] = 0 if pdo.is_received else self._missed[k] + 1
            pdo.is_received = False
            if self._missed[k] > 4:
                raise RuntimeError("a node does not answer SYNC any more")
        self.watch.check(values)

    def limit(self, setpoints):
        """Return setpoints within their range."""
        return np.clip(setpoints, self.lowest, self.highest)

    def close(self):
        for _, network, *_ in self._buses:
            network.bus = None
        self._rows.close()


class StockOdrive:
    """Axes on CANSimple by python-can and cantools.

    Parameters
    ----------
    joints : mapping
        Axis numbers and gears, by name: the driver's settings.
    bus : can.BusABC
        python-can's.
    rows : StockRows
        The log.
    """

    def __init__(self, joints, bus, rows):
        from pathlib import Path

        import cantools
        import odrive_can

        path = Path(odrive_can.__path__[0], "dbc", "odrive-cansimple-0.6.10.dbc")
        database = cantools.database.load_file(path)
        # One file describes axis 0; a frame's lower five bits say which message it is.
        self._messages = {message.frame_id & 0x1F: message for message in database.messages}
        self._set_position = self._messages[0x0C]
        self._axes = [joint.axis for joint in joints.values()]
        gears = np.array([joint.gear for joint in joints.values()])
        self._turns = gears / (2.0 * np.pi)  # of the motor, for a radian of the joint
        self._place = {axis: k for k, axis in enumerate(self._axes)}
        self._estimates = np.zeros((len(self._axes), 2))
        self._states = [8] * len(self._axes)
        self._missed = [0] * len(self._axes)
        self._bus, self._rows = bus, rows
        self.watch = None

    def step(self, t, setpoints):
        """Do the cycle at rig time `t` (s); setpoints: angles, turn, then velocities, turn/s."""
        from can import Message

        began = time.perf_counter()
        heard = set()
        while (frame := self._bus.recv(0.0)) is not None:
            axis, command = divmod(frame.arbitration_id, 32)
            k = self._place.get(axis)
            if k is None or command not in (0x01, 0x09):
                continue
            told = self._messages[command].decode(frame.data, decode_choices=False)
            if command == 0x09:
                self._estimates[k] = told["Pos_Estimate"], told["Vel_Estimate"]
                heard.add(k)
            else:
                self._states[k] = told["Axis_State"] if not told["Axis_Error"] else 0
        received = time.perf_counter()
        values = (self._estimates / self._turns[:, None]).ravel()
        for k in range(len(self._axes)):
            self._missed[k] = 0 if k in heard else self._missed[k] + 1
            if self._missed[k] > 4:
                raise RuntimeError("an axis is silent")
            if self._states[k] != 8:
                raise RuntimeError("an axis does not control")
        self.watch.check(values)
        read = time.perf_counter()
        applied = np.clip(setpoints, self.lowest, self.highest)
        controlled = time.perf_counter()
        count = len(self._axes)
        position, feedforward = applied[:count], applied[count:]
        for axis, angle, velocity in zip(
            self._axes, position.tolist(), feedforward.tolist(), strict=True
        ):
            data = self._set_position.encode(
                {"Input_Pos": angle, "Vel_FF": velocity, "Torque_FF": 0.0}
            )
            self._bus.send(
                Message(arbitration_id=axis << 5 | 0x0C, data=data, is_extended_id=False)
            )
        sent = time.perf_counter()
        stages = (received - began, read - received, controlled - read, sent - controlled)
        self._rows.write(t, np.concatenate([[t], values, setpoints, applied, stages]))

    def close(self):
        self._rows.close()


class StockDynamixel:
    """Servos on a serial chain by dynamixel_sdk: a group write and a group read.

    Parameters
    ----------
    ids : sequence of int
        Of the servos.
    path : str
        Of the port.
    read, write : tuple of int
        Address and size of the registers, bytes.
    fields : sequence of tuple
        Place and size of each number among those that are read, bytes.
    rows : StockRows
        The log.
    """

    def __init__(self, ids, path, read, fields, write, rows):
        from dynamixel_sdk import GroupSyncRead, GroupSyncWrite, PacketHandler, PortHandler

        self.port = PortHandler(path)
        assert self.port.openPort()
        packets = PacketHandler(2.0)
        self._write = GroupSyncWrite(self.port, packets, *write)
        self._read = GroupSyncRead(self.port, packets, *read)
        self._ids, self._registers = tuple(ids), read
        for servo in ids:
            assert self._read.addParam(servo)
            assert self._write.addParam(servo, bytes(write[1]))
        self.fields = fields
        self._rows = rows
        self._missed = 0
        self.watch = None

    def ask(self):
        """Ask for the first reading."""
        assert self._read.fastSyncReadTxPacket() == 0

    def step(self, t, setpoints):
        """Do the cycle at rig time `t` (s) with setpoints in steps of the servos."""
        began = time.perf_counter()
        result = self._read.fastSyncReadRxPacket()
        self._missed = 0 if result == 0 else self._missed + 1
        if self._missed > 2:
            raise RuntimeError(f"the servos do not answer: {result}")
        received = time.perf_counter()
        values = []
        for servo in self._ids:
            values += self.decode(servo)
        values = np.array(values, dtype=float)
        self.watch.check(values)
        read = time.perf_counter()
        applied = np.clip(setpoints, self.lowest, self.highest)
        for servo, goal in zip(self._ids, applied.tolist(), strict=True):
            self._write.changeParam(servo, struct.pack("<i", round(goal)))
        controlled = time.perf_counter()
        self._write.txPacket()
        self._read.fastSyncReadTxPacket()
        sent = time.perf_counter()
        stages = (received - began, read - received, controlled - read, sent - controlled)
        self._rows.write(t, np.concatenate([[t], values, setpoints, applied, stages]))

    def decode(self, servo):
        """Return what a servo said, number by number, signed."""
        address, _ = self._registers
        get = self._read.getData
        found = []
        for place, width in self.fields:
            if self._read.isAvailable(servo, address + place, width):
                raw = get(servo, address + place, width)
                top = 1 << (8 * width - 1)
                found.append(raw - 2 * top if raw >= top else raw)
        assert len(found) == len(self.fields), "nothing of a servo"
        return found

    def close(self):
        self.port.closePort()
        self._rows.close()
