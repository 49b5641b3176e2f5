"""An ODrive whose answers are written down, and the driver on it."""

import struct

from scripted_bus import ScriptedBus, TestClock

from drivers.odrive.bus import OdriveBus
from drivers.odrive.device import OdriveServos
from drivers.odrive.settings import OdriveAxisSettings, OdriveBusSettings, OdriveSettings

PERIOD = 0.005
TAU = 6.283185307179586
REMOTE = 0x4000_0000
AXIS = {"axis": 3, "gear": TAU, "limits": (-1.0, 2.0), "max_speed": 1.0, "deceleration": 4.0}


class ScriptedOdrive:
    """An axis that answers remote frames, states and parameters, and sends estimates."""

    def __init__(self, bus):
        self.bus = bus
        self.state = 1
        self.errors = 0
        self.turns = 0.0
        self.version = (2, 4, 4, 58, 0, 6, 10, 0)
        self.serials = [0xABCDEF]
        self.endpoints = {7: struct.pack("<?", False), 8: bytes(4)}
        self.value_size = 4  # of a TxSdo, at least
        self.confirms = None  # what a TxSdo bears that confirms a write
        self.obeys = True
        self.beats = self.estimates = True
        bus.devices[3] = self

    def receive(self, can_id, data):
        command = can_id & 0x1F
        if can_id & REMOTE:
            if command == 0x06:
                for serial in self.serials:
                    self.bus.put(f"066#03{serial.to_bytes(6, 'little').hex()}00")
            elif command == 0x00 and self.version:
                self.bus.put(f"060#{bytes(self.version).hex()}")
            elif command == 0x03:
                self.bus.put(f"063#{struct.pack('<II', self.errors, self.errors).hex()}")
        elif command == 0x07 and self.obeys:
            self.state = data[0]
        elif command == 0x18 and self.obeys:
            self.errors = 0
        elif command == 0x04:
            number = int.from_bytes(data[1:3], "little")
            if data[0] == 1:
                size = len(self.endpoints[number])
                self.endpoints[number] = data[4 : 4 + size]
                if self.confirms is not None:
                    self.bus.put(f"065#01{data[1:3].hex()}00{self.confirms.hex()}")
            else:
                value = self.endpoints[number].ljust(self.value_size, b"\0")
                self.bus.put(f"065#00{data[1:3].hex()}00{value.hex()}")

    def talk(self, speed=0.0):
        if self.beats:
            self.bus.put(f"061#{struct.pack('<IBBBB', self.errors, self.state, 0, 1, 0).hex()}")
        if self.estimates:
            self.bus.put(f"069#{struct.pack('<ff', self.turns, speed).hex()}")


class TalkingClock(TestClock):
    """Has the axis talk every 5 ms."""

    def __init__(self):
        super().__init__()
        self.axis = None
        self._next = self.time

    def sleep_until(self, t):
        while self.axis is not None and self._next <= t:
            self.axis.talk()
            self._next += PERIOD
        super().sleep_until(t)


def joint(**changes):
    return OdriveAxisSettings(**(AXIS | changes))


class Bench:
    """The driver with one joint, and the loop's order of calls."""

    def __init__(self, axis=(), **settings):
        self.interface = ScriptedBus()
        self.clock = TalkingClock()
        self.axis = self.clock.axis = ScriptedOdrive(self.interface)
        can = OdriveBusSettings("scripted", "can0")
        self.bus = OdriveBus("can0", can, lambda: self.interface, self.clock, PERIOD)
        self.bus.open()
        joints = {"elbow": joint(**dict(axis))}
        self.driver = OdriveServos("arm", OdriveSettings(joints=joints, **settings), self.bus)

    def sent(self):
        frames, self.interface.sent[:] = list(self.interface.sent), []
        return frames

    def connect(self):
        self.driver.connect()
        return self.sent()

    def cycle(self, command=None):
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)
        return self.sent()

    def start(self):
        self.connect()
        self.driver.arm()
        frames = []
        for _ in range(60):
            frames += self.cycle()
            if self.driver.is_enabled:
                return frames
        raise AssertionError("never enabled")
