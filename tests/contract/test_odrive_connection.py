"""Parameters of an emulated ODrive over a connection, in the frames of the maker's libodrive.

They were seen on the bus between libodrive 0.9.6 and an axis that answered until it was content;
`tests/vcan/test_odrive_maker.py` has libodrive itself. A connection's number is even and stands
around the opcode; the fourth byte bears a sequence number, and both come back.
"""

import json
import struct

import pytest
from servo_bench import LaggedJoints

from drivers.sim.nodes.odrive import EmulatedOdrive, OdriveBuild

NODE, CONNECTION, SERIAL = 5, 0x4C, 0x3A0000000002
ENDPOINTS = {"axis0.config.enable_watchdog": 300, "axis0.config.watchdog_timeout": 301}


class Host:
    """One axis, and the frames of a host that is connected to it."""

    def __init__(self, firmware=(0, 6, 11)):
        self.axis = EmulatedOdrive(
            "axis",
            NODE,
            LaggedJoints(1),
            0,
            OdriveBuild(serial=SERIAL, firmware=firmware, endpoints=ENDPOINTS),
        )
        self.heard = []
        self.axis.send = lambda can_id, data: self.heard.append((can_id, data))
        self.connect()

    def connect(self):
        address = bytes((NODE, *SERIAL.to_bytes(6, "little"), CONNECTION))
        self.axis.receive(0x7E6, address, 0.0)

    def ask(self, frame):
        """Send an RxSdo, in hexadecimal; return the data of the TxSdo that follows, if one does."""
        self.heard.clear()
        self.axis.receive(NODE << 5 | 0x04, bytes.fromhex(frame), 0.0)
        answers = [data.hex() for can_id, data in self.heard if can_id == NODE << 5 | 0x05]
        return answers[0] if answers else None

    def describe(self):
        """Read endpoint 0 as libodrive does: four bytes at a time, until there are no more."""
        text = b""
        while True:
            answer = self.ask(f"4c000010{struct.pack('<I', len(text)).hex()}")
            text += bytes.fromhex(answer)[4:]
            if len(answer) < 16:
                return json.loads(text)


@pytest.fixture
def host():
    return Host()


def test_a_value_is_as_long_as_its_type(host):
    assert host.ask("4c2c0120") == "4c2c012000"
    assert host.ask("4c2d0130") == "4c2d013000000000"


def test_a_write_is_confirmed_and_seen_by_the_manual(host):
    assert host.ask("4d2d01400000803e") == "4d2d0140"
    assert host.axis.watchdog_timeout == 0.25
    assert host.ask("002d010000000000") == "002d01000000803e"


def test_the_description_names_every_number_and_its_version_stays_the_same(host):
    described = {}

    def walk(members, path):
        for member in members:
            here = [*path, member["name"]]
            if member["type"] == "object":
                walk(member["members"], here)
            else:
                described[".".join(here)] = member["id"]

    walk(host.describe(), [])
    assert described.pop("") == 0
    assert described == host.axis.parameters.numbers
    assert described["axis0.config.enable_watchdog"] == 300
    assert len(set(described.values())) == len(described)
    assert host.ask("4c000010ffffffff") == Host().ask("4c000010ffffffff")


def test_what_was_asked_twice_is_done_once(host):
    number = host.axis.parameters.numbers["clear_errors"]
    call = f"4d{struct.pack('<H', number).hex()}50"
    host.axis.disarm(0x100)
    assert host.ask(call) == call
    host.axis.disarm(0x200)
    assert host.ask(call) == call, "its answer was lost"
    assert host.axis.active_errors == 0x200
    assert host.ask(f"{call[:-2]}60") == f"{call[:-2]}60"
    assert host.axis.active_errors == 0


def test_saving_reboots_without_an_answer_and_keeps_what_was_set(host):
    host.ask("4d2c011001")
    host.ask("4d2d01200000803e")
    number = host.axis.parameters.numbers["save_configuration"]
    assert host.ask(f"4d{struct.pack('<H', number).hex()}30") is None
    assert host.ask("4c2c0140") is None, "the connection is gone with the reboot"
    host.connect()
    host.ask("4d2d01500000003f")
    host.axis.reboot()
    assert (host.axis.enable_watchdog, host.axis.watchdog_timeout) == (True, 0.25)


@pytest.mark.parametrize(
    "frame",
    [
        "4e2c0120",  # of another host
        "4c00ff20",  # no such number
        "4d010010ff",  # cannot be written
        "4d2d01100000",  # too short for its type
        "4c000010",  # where in the description?
    ],
)
def test_what_cannot_be_answered_is_not(host, frame):
    assert host.ask(frame) is None


def test_firmware_that_knows_no_connections_answers_by_the_manual_only():
    host = Host(firmware=(0, 6, 10))
    assert host.ask("4c2c0120") is None
    assert host.ask("002c010000000000") == "002c010000000000"
    assert host.ask("012c010001000000") is None, "it does not confirm"
    assert host.axis.enable_watchdog
