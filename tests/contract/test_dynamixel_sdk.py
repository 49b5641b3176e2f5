"""The emulated chain and our codec, judged by the maker's own library over a pseudo-terminal.

`dynamixel-sdk` 4.1.0 computes the byte stuffing of what it sends and then throws it away:
`txPacket` ignores the list that `addStuffing` returns. So it is no judge of stuffed
instructions; those have vectors of their own in tests/wire/test_dynamixel_frames.py. What it
receives it does unstuff.
"""

import math
import threading

import pytest
from dynamixel_sdk import (
    COMM_SUCCESS,
    GroupBulkRead,
    GroupSyncRead,
    GroupSyncWrite,
    PacketHandler,
    PortHandler,
)
from dynamixel_terminal import PseudoTerminal

from drivers.dynamixel import codec as protocol
from drivers.dynamixel.bus import SerialBus
from drivers.dynamixel.device import DynamixelServos
from drivers.dynamixel.port import open_port
from drivers.dynamixel.registers import describe_status_error
from drivers.dynamixel.settings import DynamixelAxisSettings, DynamixelSettings, SerialBusSettings
from drivers.sim.dynamixel.chain import EmulatedChain
from drivers.sim.dynamixel.wiring import emulate_dynamixel
from drivers.sim.wiring import Installed
from rig.hal import DeviceFault, MonotonicClock

IDS = (1, 2, 7)
SETTINGS = DynamixelSettings(
    joints={f"joint_{k}": DynamixelAxisSettings(id=k, max_speed=1e3) for k in IDS}
)
STEP = math.tau / 4096
TORQUE, GOAL, VELOCITY, POSITION = 64, 116, 128, 132


class Joints:
    """Joints that are at once where they are told to be."""

    def __init__(self):
        self.angles = [0.1, -0.2, 0.3]
        self.velocities = [0.0] * 3

    def command_joint(self, channel, position, velocity, torque_on):
        if torque_on:
            self.angles[channel] = position

    def limit_joint(self, channel, speed, torque):
        pass

    def joint_position(self, channel):
        return self.angles[channel]

    def joint_velocity(self, channel):
        return self.velocities[channel]

    def joint_torque(self, channel):
        return 0.0


class Served:
    """An emulated chain on a pseudo-terminal, served by a thread."""

    def __init__(self):
        self.joints = Joints()
        (self.node,) = emulate_dynamixel(Installed("legs", SETTINGS, self.joints, (0, 1, 2)))
        self.terminal = PseudoTerminal(EmulatedChain(self.node.stations))
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self.terminal.serve, args=(self._stop.is_set,))
        self._thread.start()

    def servo(self, k):
        return self.node.stations[k].servo

    def stop(self):
        self._stop.set()
        self._thread.join()


@pytest.fixture
def served():
    chain = Served()
    yield chain
    chain.stop()
    chain.terminal.close()


class PatientPort(PortHandler):
    """The maker's port, which gives up after 34 ms; on a busy machine the chain may rest longer."""

    def setPacketTimeout(self, packet_length):
        super().setPacketTimeout(packet_length)
        self.packet_timeout += 1000.0  # ms


@pytest.fixture
def sdk(served, record_property):
    port = PatientPort(served.terminal.path)
    assert port.openPort()
    packets = []
    write = port.writePort
    port.writePort = lambda packet: packets.append(packet) or write(packet)
    yield port, PacketHandler(2.0)
    port.closePort()
    record_property("exchanges", ("the emulated chain under dynamixel-sdk", len(packets)))


def test_ping(sdk):
    port, packets = sdk
    assert packets.ping(port, 7) == (1020, COMM_SUCCESS, 0)
    assert packets.ping(port, 9)[1] != COMM_SUCCESS


def test_broadcast_ping(sdk):
    port, packets = sdk
    found, result = packets.broadcastPing(port)
    assert result == COMM_SUCCESS
    assert found == {servo: [1020, 48] for servo in IDS}


def test_read_and_write(sdk, served):
    port, packets = sdk
    value, result, error = packets.read4ByteTxRx(port, 1, POSITION)
    assert (value, result, error) == (2048 + round(0.1 / STEP), COMM_SUCCESS, 0)
    assert packets.write1ByteTxRx(port, 1, TORQUE, 1) == (COMM_SUCCESS, 0)
    assert packets.write4ByteTxRx(port, 1, GOAL, 3000) == (COMM_SUCCESS, 0)
    assert served.joints.angles[0] == pytest.approx((3000 - 2048) * STEP)


@pytest.mark.parametrize(
    ("address", "size", "value", "error"),
    [
        (TORQUE, 1, 2, "out of range"),
        (GOAL, 4, 5000, "limit"),
        (GOAL, 2, 5, "length"),
        (POSITION, 4, 0, "not available"),
        (11, 1, 1, "not available"),  # EEPROM is locked under torque
    ],
)
def test_refused_writes_have_the_makers_error(sdk, address, size, value, error):
    port, packets = sdk
    packets.write1ByteTxRx(port, 1, TORQUE, 1)
    write = {1: packets.write1ByteTxRx, 2: packets.write2ByteTxRx, 4: packets.write4ByteTxRx}
    result, number = write[size](port, 1, address, value)
    assert result == COMM_SUCCESS
    assert error in packets.getRxPacketError(number)


@pytest.mark.parametrize(
    ("number", "theirs", "ours"),
    [
        (1, "Failed to process the instruction", "failed to process the instruction"),
        (2, "Undefined instruction", "does not know the instruction"),
        (3, "CRC", "CRC"),
        (4, "out of range", "out of the register's range"),
        (5, "data length", "data are shorter"),
        (6, "limit", "limits"),
        (7, "not available", "cannot be accessed"),
    ],
)
def test_every_status_error_has_the_makers_meaning(number, theirs, ours):
    assert theirs in PacketHandler(2.0).getRxPacketError(number)
    assert ours in describe_status_error(number)
    assert "hardware error" in describe_status_error(0x80 | number)


def test_an_unknown_instruction_is_refused(sdk):
    port, packets = sdk
    packet = list(protocol.encode_packet(1, 0x42))
    _, result, error = packets.txRxPacket(port, packet)
    assert result == COMM_SUCCESS
    assert "Undefined instruction" in packets.getRxPacketError(error)


def test_prepared_writes_act_together(sdk, served):
    port, packets = sdk
    for servo in IDS:
        packets.write1ByteTxRx(port, servo, TORQUE, 1)
        assert packets.regWriteTxRx(port, servo, GOAL, 4, [0, 8, 0, 0]) == (COMM_SUCCESS, 0)
    assert served.joints.angles != pytest.approx([0.0] * 3)
    packets.action(port, 0xFE)
    assert packets.ping(port, 1)[1] == COMM_SUCCESS
    assert served.joints.angles == pytest.approx([0.0] * 3)


def test_sync_read(sdk):
    port, packets = sdk
    group = GroupSyncRead(port, packets, POSITION, 4)
    for servo in IDS:
        group.addParam(servo)
    assert group.txRxPacket() == COMM_SUCCESS
    positions = [group.getData(servo, POSITION, 4) for servo in IDS]
    assert positions == [2048 + round(angle / STEP) for angle in (0.1, -0.2, 0.3)]


def test_fast_sync_read(sdk):
    port, packets = sdk
    group = GroupSyncRead(port, packets, 126, 10)
    for servo in IDS:
        group.addParam(servo)
    assert group.fastSyncRead() == COMM_SUCCESS
    positions = [group.getData(servo, POSITION, 4) for servo in IDS]
    assert positions == [2048 + round(angle / STEP) for angle in (0.1, -0.2, 0.3)]


@pytest.mark.parametrize("fast", [False, True])
def test_data_that_look_like_a_header_are_read(sdk, served, fast):
    """Current -1 and velocity -3 are FF FF FD FF FF FF: stuffed in a status, not in a fast one."""
    port, packets = sdk
    served.joints.joint_torque = lambda channel: -2.69e-3 * 1.78
    served.joints.velocities[0] = -3 * 0.229 * math.tau / 60
    group = GroupSyncRead(port, packets, 126, 10)
    for servo in IDS:
        group.addParam(servo)
    assert (group.fastSyncRead() if fast else group.txRxPacket()) == COMM_SUCCESS
    assert group.getData(1, 126, 2) == 0xFFFF
    assert group.getData(1, VELOCITY, 4) == 0xFFFF_FFFD
    assert group.getData(1, POSITION, 4) == 2048 + round(0.1 / STEP)


def test_bulk_read(sdk):
    port, packets = sdk
    group = GroupBulkRead(port, packets)
    group.addParam(1, 144, 2)
    group.addParam(2, 146, 1)
    assert group.txRxPacket() == COMM_SUCCESS
    assert group.getData(1, 144, 2) == 120
    assert group.getData(2, 146, 1) == 35


def test_sync_write(sdk, served):
    port, packets = sdk
    for servo in IDS:
        packets.write1ByteTxRx(port, servo, TORQUE, 1)
    group = GroupSyncWrite(port, packets, GOAL, 4)
    for servo, goal in zip(IDS, (1000, 2000, 3000), strict=True):
        group.addParam(servo, list(goal.to_bytes(4, "little")))
    assert group.txPacket() == COMM_SUCCESS
    assert packets.ping(port, 1)[1] == COMM_SUCCESS
    angles = [(goal - 2048) * STEP for goal in (1000, 2000, 3000)]
    assert served.joints.angles == pytest.approx(angles)


def test_reboot_clears_a_hardware_error(sdk, served):
    port, packets = sdk
    packets.write1ByteTxRx(port, 2, TORQUE, 1)
    served.node.inject("joint_2.overloaded")
    value, _, error = packets.read1ByteTxRx(port, 2, 70)
    assert (value, error) == (0x20, 0x80)
    assert packets.read1ByteTxRx(port, 2, TORQUE)[0] == 0, "it dropped its torque"
    assert "Hardware error" in packets.getRxPacketError(error)
    assert packets.reboot(port, 2)[0] == COMM_SUCCESS
    assert packets.read1ByteTxRx(port, 2, 70) == (0, COMM_SUCCESS, 0)


def test_a_tripped_bus_watchdog_locks_the_goals(sdk, served):
    port, packets = sdk
    packets.write1ByteTxRx(port, 1, TORQUE, 1)
    packets.write1ByteTxRx(port, 1, 98, 1)
    served.servo(0).tick(float(2**40))  # much later
    assert packets.read1ByteTxRx(port, 1, 98)[0] == 0xFF
    _, error = packets.write4ByteTxRx(port, 1, GOAL, 2048)
    assert "out of range" in packets.getRxPacketError(error)
    assert packets.write1ByteTxRx(port, 1, 98, 0) == (COMM_SUCCESS, 0)
    assert packets.write4ByteTxRx(port, 1, GOAL, 2048) == (COMM_SUCCESS, 0)


def test_the_sdk_makes_the_packets_that_our_codec_makes():
    sent = []

    class Port:
        is_using = False

        def clearPort(self):
            pass

        def writePort(self, packet):
            sent.append(bytes(packet))
            return len(packet)

        def setPacketTimeout(self, length):
            pass

    port, packets = Port(), PacketHandler(2.0)

    def made(call, *arguments):
        port.is_using = False
        call(port, *arguments)
        return sent[-1]

    assert made(packets.readTx, 1, 132, 4) == protocol.encode_read(1, 132, 4)
    for fast in (False, True):
        assert made(packets.syncReadTx, 126, 10, [1, 2, 7], 3, fast) == (
            protocol.encode_sync_read(126, 10, (1, 2, 7), fast=fast)
        )
    data = [1, 0, 8, 0, 0, 7, 1, 9, 0, 0]
    assert made(packets.syncWriteTxOnly, 116, 4, data, len(data)) == (
        protocol.encode_sync_write(116, 4, bytes(data))
    )
    # The trap: what must be stuffed goes out as it is, and is then no packet of ours.
    mark = [0xFF, 0xFF, 0xFD, 0x00]
    trapped = made(packets.writeTxOnly, 1, 116, 4, mark)
    assert trapped[10:14] == bytes(mark)
    assert trapped != protocol.encode_write(1, 116, bytes(mark))


# Our driver on the same terminal ------------------------------------------------------


def test_driver_over_the_pseudo_terminal(served):
    settings = SerialBusSettings(
        served.terminal.path, max_latency=0.1, reply_timeout=0.1, attempts=5, fault_after=10
    )
    clock = MonotonicClock()
    bus = SerialBus("chain", settings, lambda: open_port(settings), clock, 5e-3)
    device = DynamixelServos("legs", SETTINGS, bus)
    bus.open()
    device.connect()
    device.arm()
    assert device.positions().value == pytest.approx((0.1, -0.2, 0.3), abs=STEP)
    wanted = (0.5, 0.6, 0.7)
    deadline = clock.now() + 5.0
    while device.positions().value != pytest.approx(wanted, abs=STEP):
        assert clock.now() < deadline
        device.command_positions(wanted)
        bus.transmit(clock.now())
        bus.wait(5e-3)
        bus.receive(clock.now())
    served.stop()
    served.terminal.unplug()
    bus.transmit(clock.now())
    bus.receive(clock.now())
    with pytest.raises(DeviceFault, match="the serial adapter is gone while in use"):
        bus.check(clock.now())
    device.close()
    bus.close()
