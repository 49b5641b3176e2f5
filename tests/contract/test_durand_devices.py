"""Our drivers against devices that somebody else's CANopen stack runs: durand.

durand's network and scheduler are interfaces, so both are played here by one world in
virtual time: no thread, no wall clock, and yet none of our code on the device side.
"""

import struct

import pytest

durand = pytest.importorskip("durand")

from durand.network import NetworkABC  # noqa: E402
from durand.scheduler import VirtualScheduler, get_scheduler, set_scheduler  # noqa: E402

from drivers.canopen.bus import CanopenBus  # noqa: E402
from drivers.canopen.settings import CanBusSettings  # noqa: E402
from drivers.cia401.channel_settings import MonitorSignal, RegulatorChannel, SetpointSignal  # noqa: E402
from drivers.cia401.device import Cia401Regulators  # noqa: E402
from drivers.cia401.settings import Cia401Settings  # noqa: E402
from drivers.cia406.device import Cia406Encoder  # noqa: E402
from drivers.cia406.settings import Cia406Settings  # noqa: E402
from rig.hal import ConnectionFailed, DeviceFault, FastCanBus  # noqa: E402

DT = durand.DatatypeEnum
REGULATORS, ENCODER = 0x10, 0x20
PERIOD = 0.002


class World(FastCanBus):
    """The wire between master and durand's nodes, and the time of both."""

    def __init__(self):
        self.time = 0.0
        self.scheduler = VirtualScheduler()
        self.to_nodes = []
        self.to_master = []
        self.networks = []
        self.exchanges = 0

    # the master's interface
    def send_data(self, can_id, data):
        self.exchanges += 1
        self.to_nodes.append((can_id, bytes(data)))

    def drain(self, limit):
        frames, self.to_master[:] = self.to_master[:limit], self.to_master[limit:]
        return frames

    def shutdown(self):
        self.deliver()

    # the rig's clock
    def now(self):
        return self.time

    def sleep_until(self, t):
        self.deliver()
        if t > self.time:
            self.scheduler.run(t - self.time)
            self.time = t

    def deliver(self):
        while self.to_nodes:
            can_id, data = self.to_nodes.pop(0)
            for network in self.networks:
                for callback in list(network.subscriptions.get(can_id, ())):
                    callback(can_id, bytearray(data))


class NodeNetwork(NetworkABC):
    """One durand node's connection to the wire."""

    def __init__(self, world):
        self.world = world
        self.subscriptions = {}
        self.connected = True
        world.networks.append(self)

    def add_subscription(self, cob_id, callback):
        self.subscriptions.setdefault(cob_id, []).append(callback)

    def remove_subscription(self, cob_id, callback=None):
        self.subscriptions.pop(cob_id, None)

    def send(self, cob_id, msg):
        if self.connected:
            self.world.exchanges += 1
            self.world.to_master.append((cob_id, bytes(msg)))


@pytest.fixture
def world(record_property):
    before = get_scheduler()
    made = World()
    set_scheduler(made.scheduler)
    yield made
    set_scheduler(before)
    record_property("exchanges", ("our drivers on durand's devices", made.exchanges))


def record(*variables):
    made = durand.Record()
    for sub, variable in enumerate(variables, 1):
        made[sub] = variable
    return made


def variable(kind, access="rw", value=0):
    return durand.Variable(kind, access, value)


def add_safety_objects(od):
    """durand has no heartbeat consumer and no error behaviour: plain variables stand in."""
    od[0x1016] = record(variable(DT.UNSIGNED32))
    od[0x1029] = record(variable(DT.UNSIGNED8, value=1))


def make_analogue_module(world):
    """Two analogue outputs and inputs, a digital byte each way, CiA 401."""
    node = durand.MinimalNode(NodeNetwork(world), REGULATORS)
    od = node.object_dictionary
    od.write(0x1000, 0, 0x000F0191)
    od.write(0x1018, 1, 0x2A)
    od.write(0x1018, 4, 4711)
    add_safety_objects(od)
    od[0x6000] = record(variable(DT.UNSIGNED8, "ro"))
    od[0x6200] = record(variable(DT.UNSIGNED8))
    od[0x6206] = record(variable(DT.UNSIGNED8, value=0x00))
    od[0x6207] = record(variable(DT.UNSIGNED8, value=0xFF))
    od[0x6401] = record(variable(DT.INTEGER16, "ro"), variable(DT.INTEGER16, "ro"))
    od[0x6411] = record(variable(DT.INTEGER16), variable(DT.INTEGER16))
    od[0x6443] = record(variable(DT.UNSIGNED8), variable(DT.UNSIGNED8))
    od[0x6444] = record(variable(DT.INTEGER32, value=999), variable(DT.INTEGER32, value=999))
    return node


def make_encoder(world, step=1000):
    """Position, speed and alarms, CiA 406."""
    node = durand.MinimalNode(NodeNetwork(world), ENCODER)
    od = node.object_dictionary
    od.write(0x1000, 0, 0x00080196)
    add_safety_objects(od)
    od[0x6004] = variable(DT.INTEGER32, "ro")
    od[0x6005] = record(variable(DT.UNSIGNED32, "ro", step), variable(DT.UNSIGNED32, "ro", 1))
    od[0x6030] = record(variable(DT.INTEGER16, "ro"))
    od[0x6503] = variable(DT.UNSIGNED16, "ro")
    return node


def channel(sub):
    return RegulatorChannel(
        SetpointSignal(sub=sub, voltage=(0.0, 10.0), pressure=(0.0, 900e3)),
        MonitorSignal(sub=sub, raw=(0.0, 20000.0), current=(4e-3, 20e-3), pressure=(0.0, 1e6)),
    )


SETTINGS = Cia401Settings(
    node=REGULATORS,
    channels={"agonist": channel(1), "antagonist": channel(2)},
    supply_bit=0,
    stop_bit=3,
)


def make_bus(world):
    settings = CanBusSettings("scripted", "wire")
    bus = CanopenBus("can0", settings, lambda: world, world)
    bus.open()
    return bus


def cycle(world, bus, *devices, before_transmit=lambda: None):
    now = world.now()
    bus.receive(now)
    for device in devices:
        device.check(now)
    bus.check(now)
    before_transmit()
    bus.transmit(now)
    world.sleep_until(now + PERIOD)


def test_regulators_are_configured_and_follow_setpoints(world):
    module = make_analogue_module(world)
    bus = make_bus(world)
    regulators = Cia401Regulators("valves", SETTINGS, bus, serial=4711)
    regulators.connect()
    od = module.object_dictionary

    assert od.read(0x1017, 0) == 50
    assert od.read(0x1016, 1) == 127 << 16 | 150
    assert od.read(0x1029, 1) == 0
    assert [od.read(0x6443, n) for n in (1, 2)] == [1, 1]
    assert [od.read(0x6444, n) for n in (1, 2)] == [0, 0]
    assert (od.read(0x6206, 1), od.read(0x6207, 1)) == (0xFF, 0)
    assert od.read(0x1600, 0) == 3
    assert [od.read(0x1600, n) for n in (1, 2, 3)] == [0x64110110, 0x64110210, 0x62000108]
    assert [od.read(0x1A00, n) for n in (1, 2, 3)] == [0x64010110, 0x64010210, 0x60000108]
    assert all(od.read(0x1800 + n, 1) & 0x80000000 for n in (1, 2, 3))
    assert not od.read(0x1800, 1) & 0x80000000

    od.write(0x6401, 1, 2000)
    od.write(0x6401, 2, 10000)
    od.write(0x6000, 1, 0b1000)  # the stop's contact is closed
    regulators.arm()
    assert module.nmt.state == 5
    assert od.read(0x6200, 1) == 0, "the supply opens with the first setpoint, not before"
    assert regulators.pressure().value == pytest.approx((100e3, 500e3))
    assert regulators.emergency_stop().value is False

    for _ in range(3):
        sampled = world.now()
        cycle(
            world,
            bus,
            regulators,
            before_transmit=lambda: regulators.set_pressure((90e3, 450e3)),
        )
    assert od.read(0x6411, 1) == round(0x7FFF * 0.1)
    assert od.read(0x6411, 2) == round(0x7FFF * 0.5)
    assert od.read(0x6200, 1) == 1
    od.write(0x6000, 1, 0)
    cycle(world, bus, regulators)
    bus.receive(world.now())
    assert regulators.emergency_stop().value is True
    assert regulators.pressure().t == pytest.approx(sampled + PERIOD)

    regulators.make_safe()
    cycle(world, bus)
    assert [od.read(0x6411, n) for n in (1, 2)] == [0, 0]
    assert od.read(0x6200, 1) == 0
    regulators.close()
    bus.close()
    assert module.nmt.state == 4


def test_an_emergency_of_the_module_is_a_latched_fault_in_words(world):
    module = make_analogue_module(world)
    bus = make_bus(world)
    regulators = Cia401Regulators("valves", SETTINGS, bus)
    regulators.connect()
    module.object_dictionary.write(0x6401, 1, 100)
    regulators.arm()
    cycle(world, bus, regulators)
    module.emcy.set(0x2310, 0x03, b"\x01")
    bus.receive(world.now())
    for _ in range(2):
        with pytest.raises(DeviceFault, match=r"valves \(node 0x10\).*0x2310.*current at the outp"):
            regulators.check(world.now())


def test_a_silent_module_is_found_lost(world):
    module = make_analogue_module(world)
    bus = make_bus(world)
    regulators = Cia401Regulators("valves", SETTINGS, bus)
    regulators.connect()
    regulators.arm()
    cycle(world, bus, regulators)
    module.network.connected = False
    with pytest.raises(DeviceFault, match="does not answer SYNC") as caught:
        for _ in range(200):
            cycle(world, bus, regulators)
    assert "PDO 0x190" in str(caught.value)


def test_a_module_that_refuses_a_setting_is_named_with_the_object(world):
    module = make_analogue_module(world)
    bus = make_bus(world)
    od = module.object_dictionary
    od[0x6444] = record(variable(DT.INTEGER32, "ro"), variable(DT.INTEGER32, "ro"))
    regulators = Cia401Regulators("valves", SETTINGS, bus)
    with pytest.raises(ConnectionFailed, match=r"refused.*read only.*0x6444:01"):
        regulators.connect()


def test_the_encoder_reads_its_step_position_and_speed(world):
    device = make_encoder(world, step=5000)
    bus = make_bus(world)
    encoder = Cia406Encoder("rod", Cia406Settings(node=ENCODER, stroke=0.06, offset=1e-3), bus)
    encoder.connect()
    od = device.object_dictionary
    assert [od.read(0x1A00, n) for n in (1, 2, 3)] == [0x60040020, 0x60300110, 0x65030010]
    od.write(0x6004, 0, 2000)
    od.write(0x6030, 1, -150)
    encoder.arm()
    assert encoder.position().value == pytest.approx((11e-3,))
    assert encoder.velocity().value == pytest.approx((-1.5e-3,))

    od.write(0x6503, 0, 1)
    cycle(world, bus, encoder)
    with pytest.raises(DeviceFault, match=r"rod .*alarm: position error.*0x6503"):
        cycle(world, bus, encoder)


def test_an_encoder_in_the_place_of_the_module_is_refused(world):
    node = durand.MinimalNode(NodeNetwork(world), REGULATORS)
    node.object_dictionary.write(0x1000, 0, 0x00080196)
    bus = make_bus(world)
    with pytest.raises(ConnectionFailed, match=r"another kind.*CiA 406.*bound CiA 401"):
        Cia401Regulators("valves", SETTINGS, bus).connect()


def test_what_durand_packs_is_what_struct_packs(world):
    """The codec of the PDO by hand, so that the test above cannot pass by symmetry."""
    module = make_analogue_module(world)
    bus = make_bus(world)
    regulators = Cia401Regulators("valves", SETTINGS, bus)
    regulators.connect()
    module.object_dictionary.write(0x6401, 1, 0x1234)
    module.object_dictionary.write(0x6401, 2, 0x0056)
    regulators.arm()
    world.to_master.clear()
    bus.synchronise()
    world.deliver()
    assert dict(world.to_master)[0x190] == struct.pack("<hhB", 0x1234, 0x0056, 0)
