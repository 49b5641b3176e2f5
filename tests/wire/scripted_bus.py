"""A CAN bus whose other side is written down: what is sent stays, what comes is put in."""

from drivers.canopen.bus import CanopenBus
from drivers.canopen.settings import CanBusSettings
from rig.hal import FastCanBus

SIZES = {0x2F: 1, 0x2B: 2, 0x23: 4}


class TestClock:
    """Time that passes when somebody sleeps."""

    __test__ = False

    def __init__(self):
        self.time = 100.0

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = max(self.time, t)


class ScriptedBus(FastCanBus):
    """The interface: `waiting` comes in, `sent` went out, as ``"601#40…"``."""

    def __init__(self):
        self.waiting = []
        self.sent = []
        self.devices = {}
        self.refusing = None
        self.failing = None
        self.is_open = True

    def send_data(self, can_id, data):
        if self.refusing is not None:
            raise self.refusing
        self.sent.append(f"{can_id:03X}#{bytes(data).hex().upper()}")
        for device in self.devices.values():
            device.receive(can_id, bytes(data))

    def drain(self, limit):
        if self.failing is not None:
            raise self.failing
        frames, self.waiting[:] = self.waiting[:limit], self.waiting[limit:]
        return frames

    def put(self, *frames, flags=0):
        for frame in frames:
            can_id, data = frame.split("#")
            self.waiting.append((int(can_id, 16) | flags, bytes.fromhex(data)))

    def shutdown(self):
        self.is_open = False


class ScriptedNode:
    """A node that answers SDOs from a dictionary and NMT with heartbeats.

    `objects` maps (index, sub) to bytes. `sync_answers` are sent one per SYNC.
    `aborts` maps (index, sub) to an abort code, and `stubborn` holds objects that take a
    value and keep another.
    """

    def __init__(self, bus, node, objects):
        self.bus = bus
        self.node = node
        self.objects = dict(objects)
        self.aborts = {}
        self.stubborn = set()
        self.silent = False
        self.answers_start = True
        self.sync_answers = []
        bus.devices[node] = self

    def receive(self, can_id, data):
        if self.silent:
            return
        if can_id == 0 and data[1] in (0, self.node):
            state = {0x01: "05", 0x81: "00"}.get(data[0])
            if state and (state != "05" or self.answers_start):
                self.bus.put(f"{0x700 + self.node:03X}#{state}")
        elif can_id == 0x80 and self.sync_answers:
            self.bus.put(self.sync_answers.pop(0))
        elif can_id == 0x600 + self.node:
            self.bus.put(f"{0x580 + self.node:03X}#{self._answer(data).hex()}")

    def _answer(self, data):
        command, thing = data[0], data[1:4]
        key = (int.from_bytes(data[1:3], "little"), data[3])
        code = self.aborts.get(key) or (0 if key in self.objects else 0x06020000)
        if code:
            return b"\x80" + thing + code.to_bytes(4, "little")
        if command == 0x40:
            value = self.objects[key]
            return bytes((0x43 | (4 - len(value)) << 2,)) + thing + value.ljust(4, b"\0")
        if key not in self.stubborn:
            self.objects[key] = data[4 : 4 + SIZES[command]]
        return b"\x60" + thing + bytes(4)


def u8(value):
    return value.to_bytes(1, "little")


def u16(value):
    return value.to_bytes(2, "little")


def u32(value):
    return value.to_bytes(4, "little")


def common_objects(device_type):
    """Return what every node has, four PDOs each way as a device ships them."""
    objects = {
        (0x1000, 0): u32(device_type),
        (0x1001, 0): u8(0),
        (0x1016, 1): u32(0),
        (0x1017, 0): u16(0),
        (0x1018, 1): u32(0x2A),
        (0x1018, 2): u32(401),
        (0x1018, 4): u32(7),
        (0x1029, 1): u8(1),
    }
    for base in (0x1400, 0x1800):
        for n in range(4):
            objects[base + n, 1] = u32(0xC0000000)
            objects[base + n, 2] = u8(255)
            objects |= {(base + 0x200 + n, sub): u32(0) for sub in range(1, 9)}
            objects[base + 0x200 + n, 0] = u8(0)
    return objects


class Bench:
    """A `CanopenBus` on a scripted interface."""

    def __init__(self, **settings):
        self.interface = ScriptedBus()
        self.clock = TestClock()
        self.settings = CanBusSettings("scripted", "can0", **settings)
        self.bus = CanopenBus("can0", self.settings, lambda: self.interface, self.clock)
        self.bus.open()

    def sent(self):
        frames, self.interface.sent[:] = list(self.interface.sent), []
        return frames
