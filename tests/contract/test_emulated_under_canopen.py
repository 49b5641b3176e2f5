"""The emulated nodes under somebody else's master: the `canopen` package, and tshark.

`canopen` works with threads and the wall clock, so the rig runs in real time here, in a
thread of its own, and the time-outs are generous.
"""

import shutil
import struct
import subprocess
import threading
import time
from types import SimpleNamespace

import pytest

can = pytest.importorskip("can")
canopen = pytest.importorskip("canopen")

from drivers.can.fast_path import AdaptedBus  # noqa: E402
from drivers.sim.emulated_bus import EmulatedBus  # noqa: E402
from drivers.sim.emulated_rig import EmulatedRig  # noqa: E402
from drivers.sim.nodes.analogue import AnalogueScale  # noqa: E402
from drivers.sim.nodes.cia401 import EmulatedCia401, RegulatorWiring  # noqa: E402
from drivers.sim.nodes.cia406 import EmulatedCia406  # noqa: E402

SCALE = AnalogueScale(raw=(0, 0x7FFF), electrical=(0.0, 10.0), pressure=(0.0, 900e3))
REGULATORS, ENCODER, MASTER = 0x10, 0x20, 0x7F
PATIENCE = 5.0
# A transfer that was refused is closed again when it is forgotten, which Python tells from 3.13 on.
pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <canopen.sdo.client:pytest.PytestUnraisableExceptionWarning"
)


class StillPlant:
    """Pressures that follow at once; a rod that stands still."""

    def __init__(self):
        self.setpoints = [0.0, 0.0]
        self.supply = False
        self.extension = 0.0125

    def advance(self, t):
        pass

    def set_pressure_setpoint(self, channel, pressure):
        self.setpoints[channel] = pressure

    def pressure(self, channel):
        return self.setpoints[channel]

    def position(self, channel):
        return self.extension

    def set_supply(self, open):
        self.supply = open


class LiveRig:
    """Emulated nodes in real time on a virtual bus, and a canopen network as their master."""

    def __init__(self, channel):
        self.plant = StillPlant()
        self.sim_bus = can.Bus(channel, interface="virtual")
        wiring = [RegulatorWiring(n, n, SCALE, SCALE) for n in (1, 2)]
        self.nodes = (
            EmulatedCia401("regulators", REGULATORS, self.plant, wiring),
            EmulatedCia406("encoder", ENCODER, self.plant, 0),
        )
        self.side = EmulatedBus("can0", AdaptedBus(self.sim_bus), self.nodes)
        self.frames = []
        self.side.monitor = lambda t, can_id, data: self.frames.append((t, can_id, data))
        settings = SimpleNamespace(seed=0, bus_latency=0.0, frame_loss=0.0, faults=())
        self.rig = EmulatedRig(self.plant, [self.side], settings)
        self.network = canopen.Network(can.Bus(channel, interface="virtual"))
        self.network.NOTIFIER_CYCLE = 0.01  # how long its thread takes to stop, s
        self.network.connect()
        self.remotes = {}
        for node in self.nodes:
            remote = canopen.RemoteNode(node.node_id, canopen.ObjectDictionary())
            remote.sdo.RESPONSE_TIMEOUT = PATIENCE
            self.network.add_node(remote)
            self.remotes[node.node_id] = remote
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self._thread.start()
        # canopen's own wait_for_bootup misses a message that came before it was called
        wait_until(
            lambda: {0x700 + node for node in self.remotes} <= {i for _, i, _ in self.frames}
        )
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join(PATIENCE)
        self.network.disconnect()
        self.sim_bus.shutdown()

    def _run(self):
        start = time.monotonic()
        while not self._stop.is_set():
            with self._lock:
                self.rig.advance(time.monotonic() - start)
            time.sleep(0.0005)

    def inject(self, *arguments):
        with self._lock:
            self.rig.inject(*arguments)


@pytest.fixture
def live(request, record_property):
    with LiveRig(request.node.name) as rig:
        yield rig
    record_property("exchanges", ("emulated nodes under canopen", len(rig.frames)))


def wait_until(condition):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "it never happened"
        time.sleep(0.002)


def layout(variable):
    return struct.Struct("<" + variable.data_type.code)


@pytest.mark.parametrize("node_id", [REGULATORS, ENCODER])
def test_every_object_reads_as_it_is_and_takes_its_own_value(live, node_id):
    node = next(item for item in live.nodes if item.node_id == node_id)
    remote = live.remotes[node_id]
    compared = 0
    for variable in list(node.dictionary):
        index, sub = variable.index, variable.sub
        if index == 0x1003:
            continue
        data = remote.sdo.upload(index, sub)
        if variable.data_type.size:
            assert layout(variable).unpack(data)[0] == variable.value, f"{index:04X}:{sub}"
        else:
            assert data == variable.value
        compared += 1
        if variable.access == "rw" and not 0x1400 <= index < 0x1C00:
            remote.sdo.download(index, sub, data)
        elif variable.access != "rw":
            with pytest.raises(canopen.SdoAbortedError) as refusal:
                remote.sdo.download(index, sub, data)
            assert refusal.value.code == 0x06010002
    assert compared > 60


def test_identity_and_strings(live):
    remote = live.remotes[REGULATORS]
    assert remote.sdo.upload(0x1000, 0) == bytes.fromhex("91010F00")
    assert remote.sdo.upload(0x1008, 0) == b"emulated regulators"
    assert live.remotes[ENCODER].sdo.upload(0x1000, 0) == bytes.fromhex("96010800")


def test_states_are_confirmed_by_heartbeats(live):
    remote = live.remotes[REGULATORS]
    remote.sdo.download(0x1017, 0, struct.pack("<H", 20))
    for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
        live.frames.clear()
        remote.nmt.state = state
        code = {"OPERATIONAL": 5, "STOPPED": 4, "PRE-OPERATIONAL": 127}[state]
        wait_until(lambda code=code: (0x710, bytes((code,))) in [f[1:] for f in live.frames])
        assert remote.nmt.wait_for_heartbeat(PATIENCE) == state
    live.frames.clear()
    remote.nmt.send_command(0x81)
    wait_until(lambda: (0x710, b"\x00") in [frame[1:] for frame in live.frames])
    assert struct.unpack("<H", remote.sdo.upload(0x1017, 0)) == (0,)


def add_variable(dictionary, index, sub, size, name):
    types = {
        8: canopen.objectdictionary.UNSIGNED8,
        16: canopen.objectdictionary.INTEGER16,
        32: canopen.objectdictionary.INTEGER32,
    }
    variable = canopen.objectdictionary.ODVariable(name, index, sub)
    variable.data_type = types[size]
    variable.pdo_mappable = True
    if index not in dictionary:
        dictionary.add_object(canopen.objectdictionary.ODArray(f"array {index:04X}", index))
    dictionary[index].add_member(variable)


def test_canopen_remaps_and_exchanges_pdos_on_sync(live):
    """Let canopen's own PDO code write the parameters and pack the data."""
    remote = live.remotes[REGULATORS]
    dictionary = remote.object_dictionary
    for index, sub, size in (
        (0x6411, 1, 16),
        (0x6411, 2, 16),
        (0x6200, 1, 8),
        (0x6401, 1, 16),
        (0x6401, 2, 16),
        (0x6000, 1, 8),
    ):
        add_variable(dictionary, index, sub, size, f"v{index:04X} {sub}")
    sdo = remote.sdo

    def remap(communication, mapping, cob_id, entries):
        sdo.download(communication, 1, struct.pack("<I", cob_id | 1 << 31))
        sdo.download(communication, 2, b"\x01")
        sdo.download(mapping, 0, b"\x00")
        for sub, entry in enumerate(entries, start=1):
            sdo.download(mapping, sub, struct.pack("<I", entry))
        sdo.download(mapping, 0, bytes((len(entries),)))
        sdo.download(communication, 1, struct.pack("<I", cob_id))

    remap(0x1400, 0x1600, 0x210, (0x64110110, 0x64110210, 0x62000108))
    remap(0x1800, 0x1A00, 0x40000190, (0x64010110, 0x64010210, 0x60000108))

    received = []
    live.network.subscribe(0x190, lambda can_id, data, t: received.append(bytes(data)))
    remote.nmt.state = "OPERATIONAL"
    wait_until(lambda: live.nodes[0].state == 5)
    live.network.send_message(0x210, struct.pack("<hhB", 0x4000, 0x2000, 1))
    live.network.sync.transmit()
    wait_until(lambda: live.plant.supply)
    live.network.sync.transmit()
    wait_until(lambda: len(received) == 2)
    assert received[0] == struct.pack("<hhB", 0, 0, 1)
    assert received[1] == struct.pack("<hhB", 0x4000, 0x2000, 1)
    assert live.plant.setpoints[0] == pytest.approx(0x4000 / 0x7FFF * 900e3)


def test_canopen_reads_back_and_saves_a_pdo_of_its_own(live):
    """`canopen` reads the default mapping, changes it and saves it by its own procedure."""
    remote = live.remotes[ENCODER]
    dictionary = remote.object_dictionary
    import_parameters(dictionary)
    for index, size in ((0x6004, 32), (0x6503, 16)):
        variable = canopen.objectdictionary.ODVariable(f"v{index:04X}", index, 0)
        variable.data_type = {
            32: canopen.objectdictionary.INTEGER32,
            16: canopen.objectdictionary.UNSIGNED16,
        }[size]
        variable.pdo_mappable = True
        dictionary.add_object(variable)
    add_variable(dictionary, 0x6030, 1, 16, "speed")
    remote.tpdo = canopen.pdo.TPDO(remote)
    remote.tpdo.associated_network = remote.network = live.network
    remote.tpdo.network = live.network
    remote.tpdo.read()
    assert [variable.index for variable in remote.tpdo[1]] == [0x6004]
    assert remote.tpdo[1].trans_type == 254
    pdo = remote.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6004)
    pdo.add_variable(0x6030, 1)
    pdo.add_variable(0x6503)
    pdo.trans_type = 1
    pdo.enabled = True
    pdo.save()
    frames = []
    pdo.add_callback(lambda message: frames.append([v.raw for v in message]))
    remote.nmt.state = "OPERATIONAL"
    wait_until(lambda: live.nodes[1].state == 5)
    live.network.sync.transmit()
    wait_until(lambda: frames)
    assert frames[0] == [12500, 0, 0]


def import_parameters(dictionary):
    """Describe the first transmit PDO's parameter records to canopen."""
    od = canopen.objectdictionary
    for index, name, sizes in (
        (0x1800, "communication", {0: 5, 1: 7, 2: 5, 3: 6, 5: 6}),
        (0x1A00, "mapping", {0: 5, **dict.fromkeys(range(1, 9), 7)}),
    ):
        record = od.ODRecord(name, index)
        for sub, data_type in sizes.items():
            variable = od.ODVariable(f"{name} {sub}", index, sub)
            variable.data_type = data_type
            record.add_member(variable)
        dictionary.add_object(record)


def test_abort_codes_reach_the_client(live):
    sdo = live.remotes[REGULATORS].sdo
    for index, sub, data, code in (
        (0x5FFF, 0, b"\0", 0x06020000),
        (0x6411, 9, b"\0\0", 0x06090011),
        (0x6411, 1, b"\0", 0x06070010),
        (0x1000, 0, bytes(4), 0x06010002),
        (0x6443, 1, b"\x05", 0x06090030),
        (0x1601, 0, b"\0", 0x06010000),
    ):
        with pytest.raises(canopen.SdoAbortedError) as refusal:
            sdo.download(index, sub, data)
        assert refusal.value.code == code


def test_emergency_and_venting_when_the_heartbeat_stops(live):
    remote = live.remotes[REGULATORS]
    remote.sdo.download(0x1016, 1, struct.pack("<I", MASTER << 16 | 200))
    live.network.send_message(0x700 + MASTER, b"\x05")
    remote.nmt.state = "OPERATIONAL"
    wait_until(lambda: live.nodes[0].state == 5)
    live.network.send_message(0x210, b"\x01")
    live.network.send_message(0x310, struct.pack("<4h", 0x4000, 0x4000, 0, 0))
    wait_until(lambda: live.plant.setpoints[0] > 0)
    wait_until(lambda: remote.emcy.log)
    assert [(e.code, e.register, e.data[0]) for e in remote.emcy.log] == [(0x8130, 0x11, MASTER)]
    wait_until(lambda: live.plant.setpoints == [0.0, 0.0])
    assert not live.plant.supply
    live.network.send_message(0x700 + MASTER, b"\x05")
    wait_until(lambda: len(remote.emcy.log) == 2)
    assert remote.emcy.active == []
    assert struct.unpack("<I", remote.sdo.upload(0x1003, 1)) == (0x8130,)


def test_alarm_of_the_encoder_is_an_emergency(live):
    live.inject("encoder", "alarm")
    emergencies = live.remotes[ENCODER].emcy
    wait_until(lambda: emergencies.log)
    assert (emergencies.log[0].code, emergencies.log[0].register) == (0x7300, 0x21)


@pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
def test_tshark_knows_every_frame(live, tmp_path):
    """Wireshark's dissector finds a CANopen service in each frame and none malformed."""
    remote, encoder = live.remotes[REGULATORS], live.remotes[ENCODER]
    for node in (remote, encoder):
        node.sdo.download(0x1017, 0, struct.pack("<H", 20))
    remote.sdo.upload(0x1008, 0)
    with pytest.raises(canopen.SdoAbortedError):
        remote.sdo.upload(0x5FFF, 0)
    encoder.sdo.download(0x1801, 2, b"\x01")
    live.network.nmt.send_command(1)
    wait_until(lambda: live.nodes[1].state == 5)
    for _ in range(3):
        live.network.send_message(0x310, struct.pack("<4h", 1, 2, 3, 4))
        live.network.sync.transmit()
    live.inject("encoder", "alarm")
    wait_until(lambda: encoder.emcy.log and sum(f[1] == 0x2A0 for f in live.frames) >= 3)
    frames = list(live.frames)
    log = tmp_path / "exchange.log"
    log.write_text(
        "".join(f"({t:.6f}) vcan0 {i:03X}#{data.hex().upper()}\n" for t, i, data in frames)
    )
    output = subprocess.run(
        [
            "tshark",
            "-r",
            str(log),
            "-d",
            "can.subdissector,canopen",
            "-T",
            "fields",
            "-e",
            "_ws.col.Protocol",
            "-e",
            "_ws.col.Info",
        ],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    ).stdout.splitlines()
    assert len(output) == len(frames)
    named = [line.startswith("CANopen") for line in output]
    bad = [line for line in output if "malformed" in line.lower() or "unknown" in line.lower()]
    assert all(named), "\n".join(output)
    assert not bad, "\n".join(bad)
    text = "\n".join(output)
    for service in ("NMT", "SYNC", "PDO", "SDO", "EMCY", "Boot-up"):
        assert service.lower() in text.lower(), f"no {service} in\n{text}"
