"""SocketCAN as it really behaves, under the bus that the cycle uses."""

import contextlib
import errno
import os
import pty
import socket
import struct
import subprocess
import time

import pytest
from two_processes import IN_USER_MODE_LINUX
from vcan_links import ip

from drivers.can.cyclic import CyclicFrame
from drivers.can.interfaces import open_bus
from drivers.can.socketcan import open_socketcan
from drivers.canopen.bus import CanopenBus
from drivers.canopen.settings import CanBusSettings
from rig.hal import ConnectionFailed, DeviceFault, MonotonicClock

pytestmark = pytest.mark.vcan

LINK = "vcan2"
COMMAND = 0x210
SETTLE = 0.02  # the kernel hands frames over when it has time, s
BUS_OFF, CONTROLLER, RESTARTED = 0x040, 0x004, 0x100
FRAME = struct.Struct("=IB3x8s")


@pytest.fixture
def far():
    """The raw socket of somebody else on the bus."""
    sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    sock.bind((LINK,))
    sock.setblocking(False)
    yield sock
    sock.close()
    ip("link", "set", LINK, "up")


@pytest.fixture
def bus():
    """The master's end; it hears 0x190 and commands 0x210."""
    made = make_bus()
    yield made
    made.close()
    time.sleep(SETTLE)  # its last frame is not the first one of the next test


def make_bus(link=LINK):
    clock = MonotonicClock()
    settings = CanBusSettings("socketcan", link)
    made = CanopenBus("can0", settings, lambda: open_bus(settings), clock, 0.005)
    made.heard = []
    made.subscribe(0x190, lambda data, now: made.heard.append((data, now)))
    made.command = CyclicFrame(COMMAND, bytes(4))
    made.command.active = True
    made.add(made.command)
    made.open()
    return made


def give(sock, can_id, data=b""):
    with contextlib.suppress(OSError):
        sock.send(FRAME.pack(can_id, len(data), data))
        return
    sock.send(FRAME.pack(can_id, len(data), data))  # an outage is told once, however long ago


def take(sock):
    """Return what has come, as (identifier, data)."""
    time.sleep(SETTLE)
    frames = []
    while True:
        try:
            can_id, length, data = FRAME.unpack(sock.recv(16))
        except OSError as error:
            if error.errno != errno.ENETDOWN:  # which is told once
                return frames
        else:
            frames.append((can_id, data[:length]))


def cycle(bus, number):
    """One cycle whose command is its number."""
    time.sleep(SETTLE)
    bus.receive(bus.clock.now())
    bus.command.data = struct.pack("<I", number)
    bus.transmit(bus.clock.now())


def commands(frames):
    return [int.from_bytes(data, "little") for can_id, data in frames if can_id == COMMAND]


def test_frames_go_both_ways_with_monotonic_stamps(bus, far):
    before = bus.clock.now()
    give(far, 0x190, b"\1\2")
    cycle(bus, 7)
    ((data, stamp),) = bus.heard
    assert data == b"\1\2" and before <= stamp <= bus.clock.now()
    assert [can_id for can_id, _ in take(far)] == [COMMAND, 0x080, 0x77F]


@pytest.mark.skipif(not IN_USER_MODE_LINUX, reason="it would set the clock of this machine")
def test_stamps_do_not_follow_a_wall_clock_that_is_set_back(bus, far):
    give(far, 0x190)
    cycle(bus, 1)
    wall = time.clock_gettime(time.CLOCK_REALTIME)
    time.clock_settime(time.CLOCK_REALTIME, wall - 3600.0)
    try:
        give(far, 0x190)
        cycle(bus, 2)
    finally:
        time.clock_settime(time.CLOCK_REALTIME, wall)
    (_, first), (_, second) = bus.heard
    assert 0.0 <= second - first < 60.0


def test_the_kernel_passes_what_is_subscribed_and_counts_the_rest(bus, far):
    for can_id in (0x191, 0x7E5, 0x80000190, 0x40000190, 0x190):
        give(far, can_id, b"" if can_id & 0x40000000 else b"\0")
    cycle(bus, 1)
    time.sleep(SETTLE)
    assert len(bus.heard) == 1
    assert bus.statistics()["frames_in"] == 1  # the kernel held the others back
    bus.close()
    assert bus.statistics()["unknown"] == 4


def test_foreign_traffic_at_high_load_reaches_nobody_and_is_counted(bus, far):
    flood, asked = 20_000, 100
    for number in range(flood):
        give(far, 0x300 + number % 0x80, bytes(8))
        if number % (flood // asked) == 0:
            give(far, 0x190, struct.pack("<I", number))
            cycle(bus, number)
    cycle(bus, flood)
    assert [data for data, _ in bus.heard] == [
        struct.pack("<I", number) for number in range(0, flood, flood // asked)
    ]
    bus.check(bus.clock.now())
    bus.close()
    statistics = bus.statistics()
    assert statistics["frames_in"] == asked
    assert statistics["refused"] == 0
    assert statistics["unknown"] == flood


def test_what_nobody_takes_in_time_is_dropped_and_counted(bus, far):
    listener = open_socketcan(LINK, 1_000_000)
    flood = 30_000  # more than there is room for
    for number in range(flood):
        give(far, 0x190, struct.pack("<I", number))
        if number % 500 == 0:  # between interface and sockets the kernel has a queue of its own
            time.sleep(SETTLE)
    time.sleep(SETTLE)
    taken = 0
    while frames := listener.drain():
        taken += len(frames)
    dropped = listener.count_dropped()
    listener.shutdown()
    assert 0 < dropped == flood - taken
    bus.close()
    statistics = bus.statistics()
    assert statistics["dropped"] == dropped, "the run's own socket has as much room"


def test_own_frames_do_not_come_back(bus, far):
    for number in range(10):
        cycle(bus, number)
    bus.receive(bus.clock.now())
    assert bus.statistics()["frames_in"] == 0
    assert len(commands(take(far))) == 10
    bus.close()
    assert bus.statistics()["unknown"] == 0


@pytest.mark.parametrize(
    ("classes", "data", "words"),
    [
        (BUS_OFF, bytes(8), "bus-off"),
        (RESTARTED, bytes(8), "restarted"),
        (CONTROLLER, bytes((0, 0x10, 0, 0, 0, 0, 0, 0)), "error passive"),
        (CONTROLLER, bytes((0, 0x20, 0, 0, 0, 0, 0, 0)), "error passive"),
    ],
)
def test_an_error_frame_is_a_latched_fault(bus, far, classes, data, words):
    give(far, 0x20000000 | classes, data)
    cycle(bus, 1)
    with pytest.raises(DeviceFault, match=words):
        bus.check(bus.clock.now())
    cycle(bus, 2)  # the bus works again
    with pytest.raises(DeviceFault, match=words):
        bus.check(bus.clock.now())
    assert bus.statistics()["error_frames"] == 1


def test_error_warning_is_counted_and_no_fault(bus, far):
    give(far, 0x20000000 | CONTROLLER, bytes((0, 0x04, 0, 0, 0, 0, 0, 0)))
    cycle(bus, 1)
    bus.check(bus.clock.now())
    assert bus.statistics()["error_frames"] == 1


def test_a_link_that_goes_down_is_a_fault_that_outlives_its_coming_up(bus, far):
    cycle(bus, 1)
    bus.check(bus.clock.now())
    ip("link", "set", LINK, "down")
    for number in range(2, 5):
        cycle(bus, number)
    with pytest.raises(DeviceFault, match="went down"):
        bus.check(bus.clock.now())
    ip("link", "set", LINK, "up")
    assert commands(take(far)) == [1]
    with pytest.raises(DeviceFault, match="went down"):
        bus.check(bus.clock.now())
    bus.make_safe()  # the same socket sends again; python-can's notifier would be dead
    assert commands(take(far)) == [0]


def test_a_bus_opens_again_after_an_outage(bus, far):
    ip("link", "set", LINK, "down")
    cycle(bus, 1)
    bus.close()
    with pytest.raises(ConnectionFailed, match=f"down.*sudo ip link set {LINK} up"):
        bus.open()
    ip("link", "set", LINK, "up")
    bus.open()
    bus.command.active = True
    give(far, 0x190)
    cycle(bus, 2)
    bus.check(bus.clock.now())
    assert len(bus.heard) == 1
    assert commands(take(far)) == [2]


@pytest.fixture
def queued():
    """A bus whose interface has a queue that can be held back, as it is where nobody acknowledges.

    vcan hands frames over without one, so this is one end of a tunnel between two interfaces.
    """
    ip("link", "add", "dev", "vxcan0", "type", "vxcan", "peer", "name", "vxcan1")
    for link in ("vxcan0", "vxcan1"):
        ip("link", "set", link, "up")

    def plug(verb, *words):
        command = ["tc", "qdisc", verb, "dev", "vxcan0", "root", "handle", "1:", "plug", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    made = plug("add", "limit", "2000")
    if made.returncode:
        pytest.skip(f"no queue that can be held back: {made.stderr.strip()}")
    plug("change", "release_indefinite")
    far = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    far.bind(("vxcan1",))
    far.setblocking(False)
    bus = make_bus("vxcan0")
    bus.hold = lambda: plug("change", "block")
    bus.release = lambda: plug("change", "release_indefinite")
    yield bus, far
    bus.close()
    far.close()
    ip("link", "del", "vxcan0")


def test_commands_do_not_pile_up_behind_an_outage(queued):
    bus, far = queued
    cycle(bus, 1)
    assert commands(take(far)) == [1]
    bus.hold()
    for number in range(2, 30):
        cycle(bus, number)
        try:
            bus.check(bus.clock.now())
        except DeviceFault as fault:
            assert "transmit queue is full" in str(fault)
            break
    assert number == 2 + bus.settings.max_refused + 1
    bus.make_safe()
    assert take(far) == []
    bus.release()
    # What the kernel had already, of the very cycle, and behind it what is safe; nothing of the
    # cycles of the outage.
    assert commands(take(far)) == [2, 0]


def test_a_short_outage_costs_cycles_and_is_no_fault(queued):
    bus, far = queued
    bus.hold()
    for number in range(1, 1 + bus.settings.max_refused):
        cycle(bus, number)
        bus.check(bus.clock.now())
    bus.release()
    assert commands(take(far)) == [1]
    cycle(bus, 9)
    bus.check(bus.clock.now())
    assert commands(take(far)) == [9]


def test_what_waits_is_dropped_with_the_link(queued):
    bus, far = queued
    bus.hold()
    cycle(bus, 1)
    ip("link", "set", "vxcan0", "down")
    ip("link", "set", "vxcan0", "up")
    bus.release()
    assert commands(take(far)) == []


def test_a_full_queue_is_enobufs(queued):
    bus, _ = queued
    bus.hold()
    near = open_socketcan("vxcan0", 1_000_000)
    with pytest.raises(OSError) as refused:
        for number in range(1000):
            near.send_data(0x123, struct.pack("<I", number))
    assert refused.value.errno == errno.ENOBUFS
    near.shutdown()


def test_no_such_interface():
    with pytest.raises(ConnectionFailed, match=r"no such CAN interface.*ip link add dev vcan99"):
        open_socketcan("vcan99", 1_000_000)


def test_an_interface_that_is_no_can():
    with pytest.raises(ConnectionFailed, match="is no CAN interface"):
        open_socketcan("lo", 1_000_000)


def test_an_interface_that_is_down(far):
    ip("link", "set", LINK, "down")
    with pytest.raises(ConnectionFailed, match=f"is down.*sudo ip link set {LINK} up"):
        open_socketcan(LINK, 1_000_000)


def test_a_port_without_permission():
    """A serial CAN adapter that belongs to root, opened by somebody else."""
    master, slave = pty.openpty()
    os.fchmod(slave, 0o600)
    settings = CanBusSettings("slcan", os.ttyname(slave))
    import can.interfaces.slcan  # noqa: F401 - nobody else may read where it is installed

    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setgid(65534)
            os.setuid(65534)
            open_bus(settings)
        except ConnectionFailed as error:
            code = 0 if "Permission denied" in str(error) and "dialout" in str(error) else 2
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    os.close(master)
    os.close(slave)
