"""A small emulated rig for tests: a plant of numbers and a bus of lists, no threads."""

from dataclasses import dataclass, field
from types import SimpleNamespace

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, EXTENDED_MASK, REMOTE_FLAG
from drivers.sim.emulated_bus import EmulatedBus
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.cia401 import EmulatedCia401, RegulatorWiring
from drivers.sim.nodes.cia406 import EmulatedCia406
from rig.hal import FastCanBus

SETPOINT = AnalogueScale(raw=(0, 0x7FFF), electrical=(0.0, 10.0), pressure=(0.0, 900e3))
MONITOR = AnalogueScale(raw=(0, 0x7FFF), electrical=(1.0, 5.0), pressure=(0.0, 900e3))
REGULATORS, AGONIST, ANTAGONIST = 0x10, 0x20, 0x21


@dataclass
class FakePlant:
    """Regulators that follow at once, rods that stand where a test puts them."""

    setpoints: list = field(default_factory=lambda: [None, None])
    positions: list = field(default_factory=lambda: [0.010, 0.020])
    supply: bool | None = None
    time: float = 0.0

    def advance(self, t):
        assert t >= self.time, f"time ran backwards from {self.time} to {t}"
        self.time = t

    def set_pressure_setpoint(self, channel, pressure):
        self.setpoints[channel] = pressure

    def pressure(self, channel):
        return self.setpoints[channel]

    def position(self, channel):
        return self.positions[channel]

    def set_supply(self, open):
        self.supply = open


class FakeBus(FastCanBus):
    """The simulated end of a bus: what the master sends is put in, what nodes send stays."""

    def __init__(self):
        self.waiting = []
        self.sent = []

    def drain(self, limit):
        frames, self.waiting[:] = self.waiting[:limit], self.waiting[limit:]
        return frames

    def send_data(self, can_id, data):
        self.sent.append((can_id, bytes(data)))

    def shutdown(self):
        pass


class Bench:
    """The rig with a master that speaks in frames written as ``"601#40…"``."""

    def __init__(self, latency=0.0002, loss=0.0, faults=(), seed=1):
        self.plant = FakePlant()
        self.bus = FakeBus()
        wiring = [RegulatorWiring(n, n, SETPOINT, MONITOR) for n in (1, 2)]
        self.regulators = EmulatedCia401("regulators", REGULATORS, self.plant, wiring)
        self.agonist = EmulatedCia406("agonist", AGONIST, self.plant, 0)
        self.antagonist = EmulatedCia406("antagonist", ANTAGONIST, self.plant, 1)
        nodes = (self.regulators, self.agonist, self.antagonist)
        self.side = EmulatedBus("can0", self.bus, nodes)
        settings = SimpleNamespace(seed=seed, bus_latency=latency, frame_loss=loss, faults=faults)
        self.rig = EmulatedRig(self.plant, [self.side], settings)

    def put(self, frame, extended=False, remote=False, error=False):
        can_id, data = frame.split("#")
        flags = EXTENDED_FLAG * extended | REMOTE_FLAG * remote | ERROR_FLAG * error
        self.bus.waiting.append((int(can_id, 16) | flags, bytes.fromhex(data)))

    def run(self, seconds=0.001):
        """Let time pass and return the frames that came meanwhile."""
        self.rig.advance(self.rig.time + seconds)
        frames = [f"{i & EXTENDED_MASK:03X}#{d.hex().upper()}" for i, d in self.bus.sent]
        self.bus.sent.clear()
        return frames

    def ask(self, *frames):
        """Put frames, let a millisecond pass and return the answers."""
        for frame in frames:
            self.put(frame)
        return self.run()

    def write(self, node, index, sub, value, size):
        """Write an object by SDO; return 0 or the abort code."""
        command = 0x23 | (4 - size) << 2
        request = bytes((command, index & 0xFF, index >> 8, sub))
        request += (value % (1 << 8 * size)).to_bytes(4, "little")
        return self._sdo(node, request, 0x60)[0]

    def read(self, node, index, sub=0):
        """Read an object of at most four bytes by SDO; return its value, or the abort code."""
        request = bytes((0x40, index & 0xFF, index >> 8, sub)) + bytes(4)
        abort, answer = self._sdo(node, request, 0x40)
        if abort:
            return abort
        size = 4 - (answer[0] >> 2 & 3)
        return int.from_bytes(answer[4 : 4 + size], "little")

    def _sdo(self, node, request, expected):
        answers = self.ask(f"{0x600 + node:03X}#{request.hex()}")
        mine = [a for a in answers if a.startswith(f"{0x580 + node:03X}#")]
        assert len(mine) == 1, f"{request.hex()} was answered by {answers}"
        answer = bytes.fromhex(mine[0][4:])
        assert answer[1:4] == request[1:4]
        if answer[0] == 0x80:
            return int.from_bytes(answer[4:], "little"), answer
        assert answer[0] & 0xE0 == expected
        return 0, answer

    def start(self):
        """Power on and bring all nodes to OPERATIONAL."""
        self.run()
        return self.ask("000#0100")
