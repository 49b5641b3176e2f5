"""What goes wrong between two processes: how the run ends, what it says, what the nodes do."""

import contextlib
import errno
import json
import os
import signal
import socket
import struct
import subprocess
import threading

import pytest
from two_processes import Program, now, only_run, pause, set_all, simulate
from vcan_links import ip

pytestmark = pytest.mark.vcan

LINK = "vcan0"
RATE = set_all(loop__rate="200 Hz")
REGULATORS, HEARTBEAT_TIMEOUT = 0x10, 0.15
SETPOINTS, HEARTBEAT, EMERGENCY = 0x200 + REGULATORS, 0x700 + REGULATORS, 0x080 + REGULATORS
OPERATIONAL, PRE_OPERATIONAL = b"\x05", b"\x7f"
MASTER_LOST = b"\x30\x81"
FRAME = struct.Struct("=IB3x8s")


class Recorder:
    """Every frame on the link, with the time at which it was seen, s."""

    def __init__(self):
        self.frames = []
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._socket.bind((LINK,))
        self._socket.settimeout(0.1)
        self._over = False
        self._thread = threading.Thread(target=self._record)
        self._thread.start()

    def _record(self):
        while not self._over:
            try:
                can_id, length, data = FRAME.unpack(self._socket.recv(16))
            except TimeoutError:
                continue
            except OSError as error:
                assert error.errno == errno.ENETDOWN
            else:
                self.frames.append((now(), can_id, data[:length]))

    def since(self, start, *ids):
        return [(t, i, data) for t, i, data in list(self.frames) if t >= start and i in ids]

    def wait_for(self, start, can_id, beginning):
        """Return when such a frame first came after a time."""
        deadline = now() + 20.0
        while now() < deadline:
            for t, _, data in self.since(start, can_id):
                if data.startswith(beginning):
                    return t
            pause(0.02)
        raise AssertionError(
            f"no 0x{can_id:03X}#{beginning.hex()}: {self.since(start, can_id)[-9:]}"
        )

    def close(self):
        self._over = True
        self._thread.join()
        self._socket.close()


@pytest.fixture
def recorder():
    made = Recorder()
    yield made
    made.close()
    ip("link", "set", LINK, "up")


@pytest.fixture(scope="module")
def simulation():
    """One for all: every run resets its nodes, whatever the one before did to them."""
    with simulate("cylinder", LINK, *RATE) as program:
        yield program
        assert program.stop() == 0, program.talk


def run(tmp_path, *options):
    return Program(
        "run", "cylinder-step", "--on", LINK, "--no-report", "--out", tmp_path, *RATE, *options
    )  # fmt: skip


def send(can_id, data):
    with contextlib.closing(socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)) as sock:
        sock.bind((LINK,))
        sock.send(FRAME.pack(can_id, len(data), data))


def check(rig, *options):
    program = Program("check", rig, "--on", LINK, "--json", *options)
    with program:
        code = program.end()
    text = "".join(program.printed)
    return code, json.loads(text)["buses"] if text else None, program.talk


def safe_setpoints(frames):
    """Whether every setpoint is the vented one with the supply valve closed: all bits 0."""
    return all(not any(data) for _, _, data in frames)


def test_no_such_interface_and_one_that_is_down(tmp_path, recorder):
    with Program("run", "cylinder-step", "--on", "vcan99", "--out", tmp_path) as program:
        assert program.end() == 3
    assert "sudo ip link add dev vcan99 type vcan" in program.talk
    for command in (
        ("simulate", "cylinder"),
        ("check", "cylinder"),
        ("monitor", "cylinder", "--frames"),
    ):
        with Program(*command, "--on", "vcan99") as program:
            assert program.end() == 3
        assert "sudo ip link add dev vcan99 type vcan" in program.talk
    ip("link", "set", LINK, "down")
    with run(tmp_path / "down") as program:
        assert program.end() == 3
    assert f"sudo ip link set {LINK} up" in program.talk


def test_an_interface_at_another_bit_rate(tmp_path):
    """vcan has none: what the kernel would tell of a real one is said by another `ip`."""
    ip("link", "add", "dev", "can7", "type", "vcan")
    ip("link", "set", "can7", "up")
    told = [{"ifname": "can7", "linkinfo": {"info_data": {"bittiming": {"bitrate": 500000}}}}]
    other = tmp_path / "ip"
    other.write_text(f"#!/bin/sh\necho '{json.dumps(told)}'\n")
    other.chmod(0o755)
    environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    with Program(
        "run",
        "cylinder-step",
        "--on",
        "can7",
        "--yes",
        "cylinder",
        "--set",
        "cylinder.limits.stop_energy=1 J",
        "--set",
        "loop.small_margin=a test",
        "--out",
        tmp_path / "runs",
        environment=environment,
    ) as program:
        assert program.end() == 3, program.talk
    ip("link", "del", "can7")
    assert "runs at 500000 bit/s and the profile asks for 1000000" in program.talk
    assert "sudo ip link set can7 type can bitrate 1000000" in program.talk


def test_nobody_answers(tmp_path):
    with run(tmp_path) as program:
        assert program.end() == 3
    assert "did not answer" in program.talk
    assert f"rig check cylinder --on {LINK}" in program.talk
    code, nodes, talk = check("cylinder")
    assert code == 3
    assert {node["differences"][0] for node in nodes} == {"does not answer"}
    assert f"rig simulate cylinder --on {LINK}" in talk


def test_a_bit_rate_that_only_the_controller_notices(tmp_path):
    """The interface is as the profile says and the devices are not: nobody acknowledges."""
    with run(tmp_path) as program:
        program.wait_for("recording to")
        pause(0.5)
        send(0x20000004, bytes((0, 0x20, 0, 0, 0, 0, 0, 0)))
        assert program.end() == 3, program.talk
    assert "error passive" in program.talk
    assert "bit rate (ip -details link show)" in program.talk


def test_devices_that_vanish_in_a_run(tmp_path):
    with simulate("cylinder", LINK, *RATE) as devices, run(tmp_path) as program:
        program.wait_for("run …")
        devices.send(signal.SIGKILL)
        assert program.end() == 4, program.talk
    assert only_run(tmp_path)[0]["status"] == "faulted"
    assert "regulators" in program.talk or "encoder-" in program.talk


def test_a_twin_of_a_node_that_is_switched_on_in_a_run(tmp_path):
    with simulate("cylinder", LINK, *RATE) as devices, run(tmp_path) as program:
        program.wait_for("run …")
        with simulate("cylinder", LINK, *RATE) as other:
            assert program.end() == 4, program.talk
            assert other.stop() == 0
        assert devices.stop() == 0
    assert "rebooted while running" in program.talk


def test_nodes_vent_by_themselves_when_the_controlling_process_is_killed(
    tmp_path, simulation, recorder
):
    with run(tmp_path, "--frames") as program:
        program.wait_for("run …")
        pause(0.5)
        program.send(signal.SIGKILL)
        killed = now()
        assert program.end() == -signal.SIGKILL
    lost = recorder.wait_for(killed, EMERGENCY, MASTER_LOST)
    recorder.wait_for(killed, HEARTBEAT, PRE_OPERATIONAL)
    last = max(t for t, *_ in recorder.since(0.0, 0x77F))
    # Slowed time, and two looks at the clock by busy programs: a tenth of a second.
    assert lost - last <= HEARTBEAT_TIMEOUT + 0.1
    assert recorder.since(killed + 0.1, SETPOINTS) == []
    _, folder = only_run(tmp_path)
    assert (folder / "log.mcap").stat().st_size > 10_000
    assert (folder / "frames.log").stat().st_size > 10_000
    # And the next run has the rig again.
    with run(tmp_path / "next") as program:
        program.wait_for("run …")
        program.send(signal.SIGTERM)
        assert program.end() == 130, program.talk


def test_an_outage_ends_the_run_and_nothing_old_is_sent_after_it(tmp_path, simulation, recorder):
    with run(tmp_path) as program:
        program.wait_for("run …")
        pause(0.5)
        ip("link", "set", LINK, "down")
        pause(0.01)  # for the recorder, to which the last frame is on its way
        down = now()
        assert program.end() == 4, program.talk
        assert "the interface went down while in use" in program.talk
    ip("link", "set", LINK, "up")
    up = now()
    recorder.wait_for(up, HEARTBEAT, PRE_OPERATIONAL)
    assert recorder.since(down, SETPOINTS) == []
    manifest, _ = only_run(tmp_path)
    assert manifest["status"] == "faulted"


def test_after_a_blink_of_the_link_only_safe_setpoints_are_sent(tmp_path, simulation, recorder):
    with run(tmp_path) as program:
        program.wait_for("run …")
        pause(0.5)
        subprocess.run(f"ip link set {LINK} down; ip link set {LINK} up", shell=True, check=True)
        up = now()
        assert program.end() == 4, program.talk
    recorder.wait_for(up, 0x000, b"\x02\x00")  # all nodes stopped, last
    sent = recorder.since(up, SETPOINTS)
    assert safe_setpoints(sent), sent


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ((0x20000040, bytes(8)), "bus-off"),
        ((0x20000100, bytes(8)), "restarted after bus-off"),
        ((0x20000004, bytes((0, 0x20, 0, 0, 0, 0, 0, 0))), "error passive"),
        ((HEARTBEAT, b"\x00"), "rebooted while running"),
    ],
    ids=["bus-off", "restarted", "passive", "reboot"],
)
def test_a_frame_that_ends_a_run(tmp_path, simulation, recorder, frame, words):
    with run(tmp_path) as program:
        program.wait_for("run …")
        send(*frame)
        told = now()
        assert program.end() == 4, program.talk
        assert words in program.talk
    sent = recorder.since(told + 0.1, SETPOINTS)
    assert safe_setpoints(sent), sent


def test_check_lists_who_answers(simulation):
    code, nodes, talk = check("cylinder")
    assert code == 0, talk
    assert [(node["node"], node["name"], node["found"]["profile"]) for node in nodes] == [
        (0x10, "regulators", 401),
        (0x20, "encoder-agonist", 406),
        (0x21, "encoder-antagonist", 406),
    ]
    code, nodes, _ = check("cylinder", "--set", "devices.encoder-agonist.node=0x22")
    assert code == 3
    assert {node["node"]: node["differences"] for node in nodes if node["differences"]} == {
        0x20: ["not in the profile"],
        0x22: ["does not answer"],
    }


def test_a_node_of_another_type_and_one_that_is_missing(tmp_path, simulation):
    swapped = (
        "--set",
        "devices.encoder-agonist.node=0x10",
        "--set",
        "devices.regulators.node=0x20",
    )
    with run(tmp_path / "swapped", *swapped) as program:
        assert program.end() == 3, program.talk
    assert "another kind of device" in program.talk and "CiA 401" in program.talk
    code, nodes, _ = check("cylinder", *swapped)
    assert code == 3
    assert nodes[0]["differences"] == ["device profile CiA 406 expected"]
    with run(tmp_path / "missing", "--set", "devices.encoder-agonist.node=0x22") as program:
        assert program.end() == 3
    assert "encoder-agonist (node 0x22)" in program.talk and "did not answer" in program.talk


def test_two_nodes_with_one_number(tmp_path, simulation):
    with simulate("cylinder", LINK, *RATE) as other:
        code, nodes, talk = check("cylinder")
        assert code == 3
        assert all(node["differences"] == ["2 devices have this number"] for node in nodes)
        assert "off the bus" in talk
        with run(tmp_path) as program:
            assert program.end() == 3, program.talk
        assert "several devices have this node number" in program.talk
        assert other.stop() == 0


@pytest.mark.parametrize(
    "numbers", [(signal.SIGINT,), (signal.SIGTERM,), (signal.SIGTERM, signal.SIGTERM)], ids=str
)
def test_a_simulation_stops_cleanly(numbers):
    """`timeout`, and people who are impatient, send two."""
    with simulate("cylinder", LINK) as program:
        for number in numbers:
            program.send(number)
        assert program.end() == 0
        assert program.said[-1].startswith("stopped after")
