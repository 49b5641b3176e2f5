"""A cycle of the joint, the arm and the legs beside the same with their stock packages.

A run is recorded, and both sides are fed with it (`fed_rig`): ours is the loop of a real run with
its drivers, checks and log, the other one of `stock_buses`. The law is left out of both: what it
takes in our cycle is measured and taken off, and the other is given the setpoints of the recorded
run. Both must do the same work: ours logs the very rows of the recorded run, and the other sends
its very setpoints. The floor is what the kernel takes to hand over the same frames, take the same
frames and take the row.
"""

import contextlib
import dataclasses
import os
import struct
import time
from statistics import median

import can
import numpy as np
import pytest
from fed_rig import CYCLES, SerialEnd, feed, our_cycles, record_run
from intervals import ratio_of
from stock_buses import StockCanopen, StockDynamixel, StockOdrive, StockRows, Watch
from test_cycle_cost import _pair, clock_cost

from drivers.can.socketcan import SocketCanBus
from rig.experiment.plan import load_plan

ROUNDS = 7
WANTED = 0.1
OVER_FLOOR = 3.0
BEFORE = 20
"""Cycles that the other side has to settle in before its costs count."""
PLANS = {
    "cylinder": ("cylinder-step", "cylinder", ()),
    "joint": ("joint-ideal-circle", "joint", ("reference.tones=[{frequency: 0.5 Hz, laps: 2}]",)),
    "arm": ("arm-shoulder-circle", "arm", ()),
    "arm on ODrives": ("arm-shoulder-circle", "arm-odrive", ()),
    "legs": ("legs-squat", "legs", ()),
}
_CODES = {"i8": "b", "u8": "B", "i16": "h", "u16": "H", "i32": "i", "u32": "I"}

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("name", list(PLANS)[1:])  # `test_cycle_cost` has the cylinder
def test_cycle_cost_of(tmp_path, table, monkeypatch, name):
    recorded = record_run(monkeypatch, plan_of(name), tmp_path / "recorded.mcap")
    peer = {"arm on ODrives": OnOdrives, "legs": OnDynamixel}.get(name, OnCanopen)(
        plan_of(name), recorded
    )
    peer.learn(tmp_path / "learning.mcap", monkeypatch)
    ours, laws, theirs, floors = [], [], [], []
    for number in range(ROUNDS + 1):
        cost = our_cycles(monkeypatch, plan_of(name), tmp_path / f"ours-{number}.mcap", recorded)
        other = peer.cost(tmp_path / f"stock-{number}.mcap", monkeypatch)
        floor = peer.floor(tmp_path / f"floor-{number}")
        if number:  # the first fills caches
            ours.append(cost.cycle - cost.law)
            laws.append(cost.law)
            theirs.append(other)
            floors.append(floor)
    ratio, low, high = ratio_of(ours, theirs)
    over, over_low, over_high = ratio_of(ours, floors)
    table(
        what=f"{name}: ours without its law", over_stock=ratio, low=low, high=high, wanted=WANTED,
        reached=high <= WANTED, us=1e6 * min(ours), stock_us=1e6 * min(theirs),
        law_us=1e6 * min(laws),
    )  # fmt: skip
    table(
        what="system calls alone", us=1e6 * min(floors), share=1.0 / over, ours_over_it=over,
        low=over_low, high=over_high, wanted=OVER_FLOOR, reached=over_high <= OVER_FLOOR,
    )  # fmt: skip
    assert high < 1.0


def plan_of(name):
    """Return a plan without what hangs on no bus: the joint's camera, which has no stock stack."""
    experiment, rig, options = PLANS[name]
    without = ("joint.camera=null",) if rig == "joint" else ()
    plan = load_plan(experiment, (*options, *without, "metrics={}"), rig=rig)
    on_buses = {name: entry for name, entry in plan.profile.devices.items() if entry.bus}
    return plan._replace(profile=dataclasses.replace(plan.profile, devices=on_buses))


class Collected:
    """Watches nothing and keeps what it is shown."""

    def __init__(self):
        self.rows = []

    def check(self, values):
        self.rows.append(values)


class Peer:
    """The stock stack of a rig on its own ends of the buses."""

    def __init__(self, plan, recorded):
        self.plan, self.recorded = plan, recorded
        self.profile = plan.profile
        self.width = len(recorded.log.columns)
        first = recorded.first
        last = min(first + CYCLES, len(recorded.came))
        self.cycles = range(first - BEFORE, last)
        self.setpoints = {k: self.decode(recorded.went[k]) for k in self.cycles}
        every = np.array(list(self.setpoints.values()))
        self.lowest, self.highest = every.min(axis=0), every.max(axis=0)
        self.watch = None

    def learn(self, path, monkeypatch):
        """See what the readings are, so that the other side can look after them."""
        self.watch = seen = Collected()
        self.cost(path, monkeypatch)
        rows = np.array(seen.rows[1:])
        steps = np.abs(np.diff(rows, axis=0)).max(axis=0)
        self.watch = Watch(rows.min(axis=0), rows.max(axis=0), steps)

    def cost(self, path, monkeypatch):
        """Return the processor time of a cycle, s."""
        costs = []
        period = self.profile.loop.period
        with self.opened(path, monkeypatch) as (cycle, ends):
            cycle.watch, cycle.lowest, cycle.highest = self.watch, self.lowest, self.highest
            if isinstance(self.watch, Watch):
                self.watch._before = None
            for k in self.cycles:
                for name, end in ends.items():
                    feed(end, self.recorded.came[k - 1][name])
                began = time.process_time()
                cycle.step(k * period, self.setpoints[k])
                costs.append(time.process_time() - began)
                sent = {name: self.heard(end) for name, end in ends.items()}
                assert self.same(sent, self.recorded.went[k]), (sent, self.recorded.went[k])
        return median(costs[BEFORE:]) - clock_cost()

    def floor(self, path):
        """Return the processor time of a cycle's system calls, s."""
        row, costs = bytes(8 * self.width + 60), []
        with self.raw_ends() as (nears, ends), path.open("wb", buffering=0) as log:
            file = log.fileno()
            for k in self.cycles:
                for name, end in ends.items():
                    feed(end, self.recorded.came[k - 1][name])
                going = self.packed(self.recorded.went[k])
                began = time.process_time()
                for name, near in nears.items():
                    for _ in range(self.reads(k, name)):
                        os.read(near, 4096)
                for name, near in nears.items():
                    for content in going[name]:
                        os.write(near, content)
                os.write(file, row)
                costs.append(time.process_time() - began)
                for end in ends.values():
                    end.drain()
        return median(costs) - clock_cost()


class OnCan(Peer):
    """On CAN buses, each a pair of sockets."""

    def heard(self, end):
        return end.drain()

    @contextlib.contextmanager
    def raw_ends(self):
        pairs = {name: _pair() for name in self.profile.buses}
        ends = {name: SocketCanBus(far, "far") for name, (_, far) in pairs.items()}
        yield {name: near.fileno() for name, (near, _) in pairs.items()}, ends
        for name, (near, _) in pairs.items():
            near.close()
            ends[name].shutdown()

    @contextlib.contextmanager
    def opened(self, path, monkeypatch):
        ends, buses = {}, {}
        with monkeypatch.context() as patch, path.open("wb") as file:
            module = "can.interfaces.socketcan.socketcan"
            patch.setattr(f"{module}.bind_socket", lambda *_: None)
            patch.setattr(f"{module}.log.disabled", True)  # of options that only CAN sockets have
            for name in self.profile.buses:
                near, far = _pair()
                patch.setattr(f"{module}.create_socket", lambda near=near: near)
                ends[name] = SocketCanBus(far, "far")
                buses[name] = can.Bus(interface="socketcan", channel=name, ignore_config=True)
            cycle = self.make(buses, StockRows(file, self.width))
            yield cycle, ends
            cycle.close()
            for name, bus in buses.items():
                bus.shutdown()
                ends[name].shutdown()

    def reads(self, k, name):
        return len(self.recorded.came[k - 1][name])

    def packed(self, went):
        return {
            name: [struct.pack("<IB3x8s", can_id, len(data), data) for can_id, data in frames]
            for name, frames in went.items()
        }

    def same(self, sent, went):
        """Return whether the same setpoints were sent, in any order; a count may be rounded."""
        for name, frames in went.items():
            ours = dict(frames)
            theirs = dict(sent[name])
            for can_id in self.compared(name):
                if not self.near(name, can_id, ours[can_id], theirs[can_id]):
                    return False
        return True


class OnCanopen(OnCan):
    """By python-can and canopen."""

    def __init__(self, plan, recorded):
        self._layouts = {}
        for device, entry in plan.profile.devices.items():
            for node in entry.settings.describe_nodes(device):
                for index, layout in enumerate(node.receive):
                    if layout:
                        code = "<" + "".join(_CODES[item.type] for item in layout)
                        cob_id = 0x200 + 0x100 * index + node.node
                        gains = [
                            (node.quantities[item].gain if item in node.quantities else None) or 1.0
                            for item in layout
                        ]
                        self._layouts[entry.bus, cob_id] = struct.Struct(code), gains
        super().__init__(plan, recorded)

    def decode(self, went):
        """Return the setpoints that a cycle sent, in SI, in the order of the nodes' PDOs."""
        frames = {(name, can_id): data for name in went for can_id, data in went[name]}
        found = []
        for bus in self.profile.buses:
            for key, (layout, gains) in self._layouts.items():
                if key[0] == bus:
                    counts = layout.unpack(frames[key])
                    found += [count * gain for count, gain in zip(counts, gains, strict=True)]
        return np.array(found)

    def make(self, buses, rows):
        return StockCanopen(self.profile, buses, rows)

    def compared(self, name):
        return [can_id for bus, can_id in self._layouts if bus == name]

    def near(self, name, can_id, one, other):
        layout, _ = self._layouts[name, can_id]
        pairs = zip(layout.unpack(one), layout.unpack(other), strict=True)
        return all(abs(a - b) <= 1 for a, b in pairs)


class OnOdrives(OnCan):
    """By python-can and cantools."""

    def __init__(self, plan, recorded):
        (self._drives,) = plan.profile.devices.values()
        self._ids = [joint.axis << 5 | 0x0C for joint in self._drives.settings.joints.values()]
        super().__init__(plan, recorded)

    def decode(self, went):
        """Return positions (turn) and then velocities (turn/s) that a cycle sent."""
        (frames,) = went.values()
        sent = dict(frames)
        told = [struct.unpack("<fhh", sent[can_id]) for can_id in self._ids]
        return np.array([row[0] for row in told] + [1e-3 * row[1] for row in told])

    def make(self, buses, rows):
        (bus,) = buses.values()
        return StockOdrive(self._drives.settings.joints, bus, rows)

    def compared(self, name):
        return self._ids

    def near(self, name, can_id, one, other):
        (a, v, _), (b, w, _) = (struct.unpack("<fhh", data) for data in (one, other))
        return a == b and abs(v - w) <= 1


class OnDynamixel(Peer):
    """By dynamixel_sdk, on a pseudo-terminal."""

    def __init__(self, plan, recorded):
        (self._device,) = plan.profile.devices.values()
        settings = self._device.settings
        self._ids = [joint.id for joint in settings.joints.values()]
        self._goal = settings.goal
        self._sent = median(len(data) for went in recorded.went for data in went.values())
        super().__init__(plan, recorded)

    def decode(self, went):
        """Return the goals that a cycle wrote, in steps."""
        (data,) = went.values()
        return np.array(list(self._goals(data).values()), dtype=float)

    def heard(self, end):
        """Return both packets of a cycle; the kernel passes them on when it may."""
        data, until = b"", time.monotonic() + 1.0
        while len(data) < self._sent and time.monotonic() < until:
            data += end.drain()
        return data

    def _goals(self, data):
        """Return the goals by servo in the sync write of this register."""
        size = self._goal.size
        head = struct.pack("<BHH", 0x83, self._goal.address, size)
        start = data.index(head) + len(head)
        found = {}
        for k in range(len(self._ids)):
            at = start + k * (1 + size)
            found[data[at]] = int.from_bytes(data[at + 1 : at + 1 + size], "little", signed=True)
        assert list(found) == self._ids, "bytes were stuffed"
        return found

    @contextlib.contextmanager
    def opened(self, path, monkeypatch):
        settings = self._device.settings
        (bus,) = self.profile.buses
        end = SerialEnd(self.profile.buses[bus].settings.baudrate)
        end.port.close()  # it has one user
        fields, place = [], 0
        for register in settings.block:
            fields.append((place, register.size))
            place += register.size
        model = settings.model_of(next(iter(settings.joints.values())))
        address = model.indirect_data if settings.health else settings.block[0].address
        with path.open("wb") as file:
            cycle = StockDynamixel(
                self._ids, end.path, (address, settings.block_size), fields,
                (self._goal.address, self._goal.size), StockRows(file, self.width),
            )  # fmt: skip
            end.reader = cycle.port.ser
            cycle.ask()
            end.drain()
            yield cycle, {bus: end}
            cycle.close()
        end.shutdown()

    @contextlib.contextmanager
    def raw_ends(self):
        (bus,) = self.profile.buses
        end = SerialEnd(self.profile.buses[bus].settings.baudrate)
        yield {bus: end.port._file}, {bus: end}
        end.shutdown()

    def reads(self, k, name):
        return 1

    def packed(self, went):
        return {name: [data] for name, data in went.items()}

    def same(self, sent, went):
        (ours,), (theirs,) = went.values(), sent.values()
        return self._goals(ours) == self._goals(theirs)
