"""A CiA 402 drive whose answers are written down, and the driver on it."""

import struct
from dataclasses import fields

from scripted_bus import Bench, ScriptedNode, common_objects, u8, u16, u32

from drivers.canopen.bus import CanopenBus
from drivers.cia402.device import Cia402Servos
from drivers.cia402.settings import Cia402Settings, DriveSettings

PERIOD = 0.005
# 1000 counts for a radian of the joint
DRIVE = {
    "node": 3,
    "counts_per_turn": 2 * 3.141592653589793 * 100.0,
    "gear": 10.0,
    "limits": (-1.0, 2.0),
    "max_speed": 1.0,
    "deceleration": 4.0,
    "following_window": 0.05,
    "following_time": 0.02,
}
OBJECTS = {
    (0x603F, 0): u16(0),
    (0x6040, 0): u16(0),
    (0x6041, 0): u16(0x0240),
    **{(index, 0): u16(0) for index in (0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007, 0x6066)},
    (0x6060, 0): u8(0),
    (0x6065, 0): u32(0),
    (0x6076, 0): u32(2000),
    (0x607D, 1): u32(0),
    (0x607D, 2): u32(0),
    (0x6080, 0): u32(0),
    (0x6084, 0): u32(0),
    (0x6085, 0): u32(0),
    (0x60C2, 1): u8(1),
    (0x60C2, 2): u8(0xFD),
    (0x6502, 0): u32(0x180),
}


def joint(**changes):
    return DriveSettings(**(DRIVE | changes))


def status(word, position=0, mode=8):
    return f"183#{struct.pack('<Hib', word, position, mode).hex()}"


def feedback(velocity=0, torque=0, error=0):
    return f"283#{struct.pack('<ihH', velocity, torque, error).hex()}"


class DriveNode(ScriptedNode):
    """Sends all the PDOs of a sample at a SYNC."""

    at_sync = ()

    def receive(self, can_id, data):
        super().receive(can_id, data)
        if can_id == 0x80:
            self.bus.put(*self.at_sync)
            self.at_sync = ()


class Drive(Bench):
    """The driver with one joint, and the loop's order of calls."""

    def __init__(self, device_type=0x00020192, **settings):
        super().__init__()
        self.bus = CanopenBus("can0", self.settings, lambda: self.interface, self.clock, PERIOD)
        self.bus.open()
        self.node = DriveNode(self.interface, 3, common_objects(device_type) | OBJECTS)
        names = [field.name for field in fields(DriveSettings)]
        own = {key: settings.pop(key) for key in list(settings) if key in names}
        joints = {"elbow": joint(**own)}
        self.driver = Cia402Servos("arm", Cia402Settings(joints=joints, **settings), self.bus)

    def connect(self):
        self.driver.connect()
        return self.sent()

    def start(self, position=0):
        """Arm, and answer each control word as a drive does."""
        self.connect()
        self.arm(position)
        for word in (0x0240, 0x0221, 0x0223, 0x1227):
            self.run(word, position)
        assert self.driver.is_enabled
        self.sent()

    def arm(self, position=0, mode=8):
        self.node.at_sync = (status(0x0240, position, mode), feedback())
        self.driver.arm()
        return self.sent()

    def run(self, word=0x1227, position=0, mode=8, command=None, extra=(), **fed):
        """One cycle in which the drive answers with a status word; return what was sent."""
        self.interface.put(status(word, position, mode), feedback(**fed), "703#05", *extra)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)
        return [frame for frame in self.sent() if not frame.startswith("77F")]
