"""The emulated CiA 402 drive under somebody else's master: `canopen`'s BaseNode402.

`canopen` works with threads and the wall clock, so the drive runs in a thread of its own here.
Its time goes on by equal steps, whatever the wall clock does meanwhile: a loaded machine makes the
tests slower, not the drive different.
"""

import logging
import threading
import time
from types import SimpleNamespace

import pytest
from servo_bench import LaggedJoints

can = pytest.importorskip("can")
canopen = pytest.importorskip("canopen")

from canopen.profiles.p402 import BaseNode402  # noqa: E402

from drivers.can.fast_path import AdaptedBus  # noqa: E402
from drivers.sim.emulated_bus import EmulatedBus  # noqa: E402
from drivers.sim.emulated_rig import EmulatedRig  # noqa: E402
from drivers.sim.nodes.cia402 import EmulatedCia402  # noqa: E402

NODE = 5
COUNTS = 4096
PATIENCE = 20.0
"""For what has to happen, s of the wall clock; nothing waits for all of it."""
STEP = 0.5e-3
OD = canopen.objectdictionary
# A transfer that was refused is closed again when it is forgotten, which Python tells from 3.13 on.
pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <canopen.sdo.client:pytest.PytestUnraisableExceptionWarning"
)
KINDS = {
    "b": OD.INTEGER8,
    "h": OD.INTEGER16,
    "i": OD.INTEGER32,
    "B": OD.UNSIGNED8,
    "H": OD.UNSIGNED16,
    "I": OD.UNSIGNED32,
    "": OD.VISIBLE_STRING,
}


def describe(node):
    """Return the drive's object dictionary as `canopen` wants it, as an EDS would give it."""
    by_index = {}
    for variable in node.dictionary:
        by_index.setdefault(variable.index, []).append(variable)
    dictionary = OD.ObjectDictionary()
    for index, variables in by_index.items():
        made = []
        for variable in variables:
            described = OD.ODVariable(f"{index:04X}:{variable.sub}", index, variable.sub)
            described.data_type = KINDS[variable.data_type.code]
            described.access_type = variable.access
            described.pdo_mappable = bool(variable.mapping)
            made.append(described)
        if len(made) == 1 and made[0].subindex == 0:
            dictionary.add_object(made[0])
            continue
        record = OD.ODRecord(f"{index:04X}", index)
        for described in made:
            record.add_member(described)
        dictionary.add_object(record)
    return dictionary


class LiveDrive:
    """One emulated drive on a virtual bus, with canopen's node as its master."""

    def __init__(self, channel):
        self.plant = LaggedJoints(1, lag=0.005)
        self.sim_bus = can.Bus(channel, interface="virtual")
        self.node = EmulatedCia402("drive", NODE, self.plant, 0, counts_per_turn=COUNTS)
        side = EmulatedBus("can0", AdaptedBus(self.sim_bus), [self.node])
        settings = SimpleNamespace(seed=0, bus_latency=0.0, frame_loss=0.0, faults=())
        self.rig = EmulatedRig(self.plant, [side], settings)
        self.frames = []
        side.monitor = lambda t, can_id, data: self.frames.append((can_id, data))
        self.network = canopen.Network(can.Bus(channel, interface="virtual"))
        self.network.NOTIFIER_CYCLE = 0.01
        self.network.connect()
        self.master = BaseNode402(NODE, describe(self.node))
        self.network.add_node(self.master)
        self.master.sdo.RESPONSE_TIMEOUT = PATIENCE
        self.master.TIMEOUT_RESET_FAULT = 0.05  # canopen always waits for all of it
        for name in ("CHECK_TPDO", "SWITCH_OP_MODE", "SWITCH_STATE_FINAL", "SWITCH_STATE_SINGLE"):
            setattr(self.master, f"TIMEOUT_{name}", PATIENCE)
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self._thread.start()
        wait_until(lambda: (0x700 + NODE, b"\0") in self.frames)
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join(PATIENCE)
        self.network.disconnect()
        self.sim_bus.shutdown()

    def _run(self):
        steps = 0
        while not self._stop.is_set():
            steps += 1
            with self._lock:
                self.rig.advance(steps * STEP)
            time.sleep(STEP)

    def inject(self, *arguments):
        with self._lock:
            self.rig.inject("drive", *arguments)


@pytest.fixture
def live(request, record_property):
    logging.getLogger("canopen").addHandler(logging.NullHandler())
    with LiveDrive(request.node.name) as made:
        yield made
    record_property("exchanges", ("emulated nodes under canopen", len(made.frames)))


def wait_until(condition):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "it never happened"
        time.sleep(0.002)


def start(live):
    """Bring the drive up as canopen's documentation does."""
    live.master.sdo[0x1017].raw = 50
    live.master.sdo[0x1800][5].raw = 10  # canopen waits for a status word that comes by itself
    live.master.nmt.state = "PRE-OPERATIONAL"
    live.master.setup_402_state_machine()
    live.master.nmt.state = "OPERATIONAL"
    wait_until(lambda: live.node.state == 5)
    # What canopen knows of the drive is its last status word, and before the first one nothing.
    wait_until(lambda: live.master.state == "SWITCH ON DISABLED")


def test_canopen_takes_the_drive_through_its_states_and_back(live):
    start(live)
    master = live.master
    assert master.state == "SWITCH ON DISABLED"
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        master.state = state
        wait_until(lambda state=state: master.state == state)
    assert live.plant.powered == [True]
    master.state = "SWITCHED ON"
    wait_until(lambda: live.plant.powered == [False])
    master.state = "SWITCH ON DISABLED"
    wait_until(lambda: master.state == "SWITCH ON DISABLED")


def test_canopen_walks_straight_to_operation_enabled(live):
    start(live)
    live.master.state = "OPERATION ENABLED"
    assert live.node.machine.state.name == "ENABLED"


def test_canopen_chooses_the_modes_and_moves_the_shaft(live):
    start(live)
    master = live.master
    master.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    assert master.op_mode == "CYCLIC SYNCHRONOUS POSITION"
    assert not master.is_op_mode_supported("PROFILED POSITION")
    master.state = "OPERATION ENABLED"
    master.sdo[0x607A].raw = COUNTS // 8
    # At rest there: on its way through, a joint may be asked at the right moment, too.
    wait_until(lambda: master.sdo[0x606C].raw == 0 and master.sdo[0x6064].raw == COUNTS // 8)
    assert live.plant.angles[0] == pytest.approx(3.14159265 / 4, abs=2e-3)
    master.sdo[0x60FF].raw = -COUNTS
    master.op_mode = "CYCLIC SYNCHRONOUS VELOCITY"
    wait_until(lambda: master.sdo[0x606C].raw == pytest.approx(-COUNTS, rel=0.2))


def test_canopen_sees_a_fault_and_resets_it(live):
    start(live)
    master = live.master
    master.state = "OPERATION ENABLED"
    live.inject("drive_fault", 0x3210)
    wait_until(lambda: master.state == "FAULT")
    assert master.sdo[0x603F].raw == 0x3210
    wait_until(lambda: master.emcy.log)
    assert (master.emcy.log[0].code, master.emcy.log[0].register) == (0x3210, 0x05)
    assert live.plant.powered == [False]
    master.reset_from_fault()
    assert master.state == "OPERATION ENABLED"
    assert master.sdo[0x603F].raw == 0
    wait_until(lambda: master.emcy.active == [])


def test_every_object_reads_as_it_is_and_takes_its_own_value(live):
    compared = 0
    for variable in list(live.node.dictionary):
        index, sub = variable.index, variable.sub
        if index == 0x1003:
            continue
        data = live.master.sdo.upload(index, sub)
        assert data == variable.encode(), f"{index:04X}:{sub}"
        compared += 1
        if variable.access == "rw" and not 0x1400 <= index < 0x1C00:
            live.master.sdo.download(index, sub, data)
        elif variable.access != "rw":
            with pytest.raises(canopen.SdoAbortedError) as refusal:
                live.master.sdo.download(index, sub, data)
            assert refusal.value.code == 0x06010002
    assert compared > 100


@pytest.mark.parametrize(
    ("index", "sub", "data"),
    [
        (0x605A, 0, b"\x03\x00"),
        (0x605E, 0, b"\xff\xff"),
        (0x6007, 0, b"\x04\x00"),
        (0x6060, 0, b"\x01"),
        (0x60C2, 1, b"\x00"),
    ],
)
def test_what_the_drive_does_not_know_is_refused(live, index, sub, data):
    with pytest.raises(canopen.SdoAbortedError) as refusal:
        live.master.sdo.download(index, sub, data)
    assert refusal.value.code == 0x06090030
