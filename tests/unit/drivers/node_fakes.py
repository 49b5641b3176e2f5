"""A bus that does what a test says, and a node's objects behind it, for the master's side."""

import struct
from types import SimpleNamespace

from canopen import SdoAbortedError

from drivers.canopen.node import CanopenNode


class FakeObjects:
    """The objects of a node: `log` has each access as ``("r" or "w", index, sub, bytes)``."""

    def __init__(self, objects):
        self.objects = dict(objects)
        self.log = []
        self.errors = {}
        self.stubborn = {}

    def _fail(self, key):
        error = self.errors.get(key)
        if isinstance(error, int):
            raise SdoAbortedError(error)
        if error is not None:
            raise error
        if key not in self.objects:
            raise SdoAbortedError(0x06020000)

    def upload(self, index, sub):
        self._fail((index, sub))
        self.log.append(("r", index, sub, self.objects[index, sub]))
        return self.objects[index, sub]

    def download(self, index, sub, data):
        self._fail((index, sub))
        self.log.append(("w", index, sub, bytes(data)))
        self.objects[index, sub] = self.stubborn.get((index, sub), bytes(data))

    @property
    def written(self):
        return [(index, sub, data) for kind, index, sub, data in self.log if kind == "w"]


class FakeNodeBus:
    """As much of a `CanopenBus` as a node needs; `reply` is called for each frame that is sent."""

    def __init__(self, objects, **settings):
        usual = {
            "heartbeat": 0.01, "heartbeat_timeout": 0.03, "boot_timeout": 0.9, "master_id": 0x7E,
        }  # fmt: skip
        self.settings = SimpleNamespace(**(usual | settings))
        self.objects = FakeObjects(objects)
        self.network = self
        self.handlers = {}
        self.sent = []
        self.waits = []
        self.answers = []
        self.added = []
        self.extra = 0
        self.refusing = None
        self.reply = lambda can_id, data: None

    def subscribe(self, can_id, handler):
        self.handlers[can_id] = handler

    def put(self, can_id, data, now=0.0):
        self.handlers[can_id](bytes(data), now)

    def send(self, can_id, data):
        if self.refusing is not None:
            raise self.refusing
        self.sent.append((can_id, bytes(data)))
        self.reply(can_id, bytes(data))

    def wait_until(self, condition, timeout):
        self.waits.append(timeout)
        return condition()

    def add(self, node):
        self.added.append(node)
        return self.objects

    def surplus(self, node):
        assert node in self.added
        return self.extra

    def take_answer(self, can_id, data, now):
        self.answers.append((can_id, data, now))


class NodeBench:
    """A node with its fake bus: a device of kind 401 with all four PDOs each way, switched off."""

    def __init__(self, number, device_type=0x000F0191, **settings):
        objects = {
            (0x1000, 0): struct.pack("<I", device_type),
            (0x1001, 0): b"\x00",
            (0x1016, 1): bytes(4),
            (0x1017, 0): bytes(2),
            (0x1018, 1): struct.pack("<I", 0x2A),
            (0x1018, 2): struct.pack("<I", 0x0401),
            (0x1018, 4): struct.pack("<I", 0x0007_0009),
        }
        self.number = number
        self.bus = FakeNodeBus(objects, **settings)
        self.objects = self.bus.objects
        self.node = CanopenNode("valves", number, self.bus)
        self.states = {0x81: b"\x00", 0x01: b"\x05"}
        self.bus.reply = self.beat

    def beat(self, can_id, data):
        """Answer a command by the heartbeat of the state that it leads to."""
        if can_id == 0 and (state := self.states.get(data[0])) is not None:
            self.bus.put(0x700 + self.number, state)

    def connected(self, **options):
        self.node.connect(profile=401, **options)
        self.objects.log.clear()
        self.bus.sent.clear()
        self.bus.waits.clear()
        return self

    def armed(self):
        self.connected()
        self.node.arm()
        return self
