"""The CiA 402 driver against a drive whose CANopen stack and state table are others': durand's
and the `canopen` package's."""

import struct

import pytest

durand = pytest.importorskip("durand")
p402 = pytest.importorskip("canopen.profiles.p402")

from durand.scheduler import get_scheduler, set_scheduler  # noqa: E402
from test_durand_devices import (  # noqa: E402
    DT,
    PERIOD,
    NodeNetwork,
    World,
    cycle,
    record,
    variable,
)

from drivers.canopen.bus import CanopenBus  # noqa: E402
from drivers.canopen.settings import CanBusSettings  # noqa: E402
from drivers.cia402.device import Cia402Servos  # noqa: E402
from drivers.cia402.settings import Cia402Settings, DriveSettings  # noqa: E402
from rig.hal import ConnectionFailed, DeviceFault  # noqa: E402

NODE = 0x11
COUNTS = 6283.185307179586  # for one turn: 1000 for a radian
SETTINGS = Cia402Settings(
    joints={
        "wrist": DriveSettings(
            node=NODE, counts_per_turn=COUNTS, limits=(-1.0, 1.0), following_time=0.05
        )
    }
)
SHOWN = {name: bits for name, (_, bits) in p402.State402.SW_MASK.items()}


@pytest.fixture
def world(record_property):
    before = get_scheduler()
    made = World()
    set_scheduler(made.scheduler)
    yield made
    set_scheduler(before)
    record_property("exchanges", ("our drivers on durand's devices", made.exchanges))


class ForeignDrive:
    """A durand node that walks through canopen's transition table and follows at once."""

    def __init__(self, world):
        self.node = durand.MinimalNode(NodeNetwork(world), NODE)
        od = self.od = self.node.object_dictionary
        od.write(0x1000, 0, 0x00020192)
        od[0x1016] = record(variable(DT.UNSIGNED32))
        for index, kind in (
            (0x603F, DT.UNSIGNED16),
            (0x6041, DT.UNSIGNED16),
            (0x6061, DT.INTEGER8),
            (0x6064, DT.INTEGER32),
            (0x606C, DT.INTEGER32),
            (0x6077, DT.INTEGER16),
        ):
            od[index] = variable(kind, "ro")
        for index in (0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007):
            od[index] = variable(DT.INTEGER16)
        for index in (0x6065, 0x6080, 0x6084, 0x6085):
            od[index] = variable(DT.UNSIGNED32)
        od[0x6066] = variable(DT.UNSIGNED16)
        od[0x6040] = variable(DT.UNSIGNED16)
        od[0x6060] = variable(DT.INTEGER8)
        od[0x607A] = variable(DT.INTEGER32)
        od[0x607D] = record(variable(DT.INTEGER32), variable(DT.INTEGER32))
        od[0x60C2] = record(variable(DT.UNSIGNED8, value=1), variable(DT.INTEGER8, value=-3))
        od[0x6502] = variable(DT.UNSIGNED32, "ro", 0x80)
        self.history = []
        self.state = "SWITCH ON DISABLED"
        od.write(0x6041, 0, SHOWN[self.state])
        od.update_callbacks[0x6040, 0].add(self.obey)
        od.update_callbacks[0x6060, 0].add(lambda mode: od.write(0x6061, 0, mode))
        od.update_callbacks[0x607A, 0].add(self.follow)

    def obey(self, word):
        for (state, reached), command in p402.State402.TRANSITIONTABLE.items():
            if state == self.state and command == word and state not in ("START", "FAULT"):
                self.enter(reached)
                return

    def enter(self, state):
        self.state = state
        self.history.append(state)
        self.od.write(0x6041, 0, SHOWN[state])

    def follow(self, target):
        if self.state == "OPERATION ENABLED":
            self.od.write(0x6064, 0, target)


def make(world):
    drive = ForeignDrive(world)
    bus = CanopenBus("can0", CanBusSettings("scripted", "w"), lambda: world, world, PERIOD)
    bus.open()
    return drive, bus, Cia402Servos("arm", SETTINGS, bus)


def enable(world, bus, servos):
    servos.connect()
    servos.arm()
    for _ in range(20):
        cycle(world, bus, servos)
        if servos.is_enabled:
            return
    raise AssertionError("never enabled")


def test_a_foreign_drive_is_configured_enabled_moved_and_stopped(world):
    drive, bus, servos = make(world)
    drive.od.write(0x6064, 0, 250)
    enable(world, bus, servos)
    od = drive.od
    assert [od.read(index, 0) for index in (0x605A, 0x605E, 0x6007)] == [6, 2, 3]
    assert (od.read(0x60C2, 1), od.read(0x60C2, 2)) == (2, -3)
    assert (od.read(0x607D, 1), od.read(0x607D, 2)) == (-1000, 1000)
    assert od.read(0x6065, 0) == 100
    assert drive.history == ["READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"]
    assert servos.positions().value == pytest.approx((0.25,))
    assert od.read(0x607A, 0) == 250, "the first target is where the joint is"
    q = 0.25
    for _ in range(50):
        q += 0.002
        cycle(world, bus, servos, before_transmit=lambda q=q: servos.command_positions((q,)))
    assert od.read(0x607A, 0) == 350
    for _ in range(2):
        cycle(world, bus, servos)
    assert servos.positions().value == pytest.approx((0.35,), abs=1e-6)
    servos.make_safe()
    bus.transmit(world.now())
    world.sleep_until(world.now() + PERIOD)
    assert drive.state == "QUICK STOP ACTIVE"
    servos.close()
    bus.close()
    assert drive.node.nmt.state == 4


def test_a_foreign_emergency_is_named_in_the_words_of_drives(world):
    drive, bus, servos = make(world)
    enable(world, bus, servos)
    drive.node.emcy.set(0x8611, 0x21, b"")
    with pytest.raises(DeviceFault, match=r"joint wrist \(node 0x11\).*following error too large"):
        cycle(world, bus, servos)


def test_a_foreign_drive_without_the_mode_is_refused(world):
    drive, _, servos = make(world)
    drive.od[0x6502] = variable(DT.UNSIGNED32, "ro", 0x01)
    with pytest.raises(ConnectionFailed, match="does not know the mode csp"):
        servos.connect()


def test_what_durand_packs_is_what_the_driver_reads(world):
    drive, bus, servos = make(world)
    drive.od.write(0x6064, 0, -999)
    enable(world, bus, servos)
    world.to_master.clear()
    bus.synchronise()
    world.deliver()
    frames = dict(world.to_master)
    assert frames[0x191] == struct.pack("<Hib", 0x27, -999, 8)
    assert frames[0x291] == bytes(8)
