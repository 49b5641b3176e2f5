"""Dynamixel Protocol 2.0: the maker's byte tables, stuffing, and a parser that recovers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel import codec as protocol
from drivers.dynamixel.codec import Status
from drivers.dynamixel.parser import StatusParser
from drivers.sim.dynamixel import framing

# Examples of the maker's e-Manual, "DYNAMIXEL Protocol 2.0", and of its SDK.
INSTRUCTIONS = {
    "ping 1": (protocol.encode_ping(1), "FF FF FD 00 01 03 00 01 19 4E"),
    "ping all": (protocol.encode_ping(0xFE), "FF FF FD 00 FE 03 00 01 31 42"),
    "read position": (
        protocol.encode_read(1, 132, 4),
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",
    ),
    "write goal position": (
        protocol.encode_write(1, 116, bytes.fromhex("00020000")),
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
    "torque on": (
        protocol.encode_write(1, 64, b"\x01"),
        "FF FF FD 00 01 06 00 03 40 00 01 DB 66",
    ),
    "sync read": (
        protocol.encode_sync_read(132, 4, (1, 2), fast=False),
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    "sync write": (
        protocol.encode_sync_write(116, 4, bytes.fromhex("01960000 0002AA00 0000")),
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
}
STATUSES = {
    "ping": ("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D", Status(1, 0, b"\x06\x04\x26")),
    "position of 1": (
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",
        Status(1, 0, b"\xa6\0\0\0"),
    ),
    "position of 2": (
        "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE",
        Status(2, 0, b"\x1f\x08\0\0"),
    ),
    "written": ("FF FF FD 00 01 04 00 55 00 A1 0C", Status(1, 0, b"")),
    "voltage": ("FF FF FD 00 01 06 00 55 00 77 00 C3 69", Status(1, 0, b"\x77\0")),
}

# Vectors of our own: the SDK computes the stuffing and then drops it when it sends, so it
# cannot be the judge here. The CRCs were computed with its `updateCRC` over these bytes.
STUFFED_INSTRUCTIONS = {
    "goal 0x00FDFFFF": (
        protocol.encode_write(1, 116, bytes.fromhex("FFFFFD00")),
        "FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD 00 21 E7",
    ),
    "two goals": (
        protocol.encode_sync_write(116, 4, bytes.fromhex("01FFFFFD00 02FFFFFDFF")),
        "FF FF FD 00 FE 13 00 83 74 00 04 00 01 FF FF FD FD 00 02 FF FF FD FD FF 02 48",
    ),
}
STUFFED_STATUS = "FF FF FD 00 01 0F 00 55 00 FF FF FD FD FF FF FF 00 08 00 00 49 F0"
STUFFED_DATA = bytes.fromhex("FFFF FDFFFFFF 00080000")  # current -1, velocity -3, position 2048
FAST = bytes.fromhex("FFFFFD00FE11005500 03A6000000 87BB 8007FFFFFD00 8AF0".replace(" ", ""))


@pytest.mark.parametrize("name", [*INSTRUCTIONS, *STUFFED_INSTRUCTIONS])
def test_instruction_has_the_bytes_of_the_table(name):
    packet, table = (INSTRUCTIONS | STUFFED_INSTRUCTIONS)[name]
    assert packet == bytes.fromhex(table)


@pytest.mark.parametrize("name", [*INSTRUCTIONS, *STUFFED_INSTRUCTIONS])
def test_emulated_servo_reads_the_same_packet(name):
    packet, _ = (INSTRUCTIONS | STUFFED_INSTRUCTIONS)[name]
    (read,) = framing.InstructionReader().take(packet)
    assert read.intact
    assert read.servo == packet[4]
    assert read.instruction == packet[7]
    assert b"\xff\xff\xfd\xfd" not in read.parameters


@pytest.mark.parametrize("name", STATUSES)
def test_status_says_what_the_table_says(name):
    table, status = STATUSES[name]
    packet = bytes.fromhex(table)
    assert StatusParser().feed(packet) == [packet]
    assert protocol.decode_status(packet) == status
    assert framing.build_status(*status) == packet


def test_stuffed_status_is_unstuffed():
    packet = bytes.fromhex(STUFFED_STATUS)
    assert framing.build_status(1, 0, STUFFED_DATA) == packet
    (found,) = StatusParser().feed(packet)
    assert protocol.decode_status(found) == Status(1, 0, STUFFED_DATA)


def test_fast_reply_has_no_stuffing_and_one_crc_per_servo():
    (found,) = StatusParser().feed(FAST)
    assert protocol.decode_fast_status(found, 4) == [
        Status(3, 0, b"\xa6\0\0\0"),
        Status(7, 0x80, b"\xff\xff\xfd\0"),
    ]
    assert len(FAST) == protocol.compute_fast_length(4, 2)


@given(st.binary(max_size=60))
def test_crc_is_the_division_by_the_polynomial(data):
    register = 0
    for byte in data:
        for bit in range(7, -1, -1):
            carry = register >> 15 ^ byte >> bit & 1
            register = (register << 1 & 0xFFFF) ^ (0x8005 if carry else 0)
    assert protocol.compute_crc(data) == register
    half = len(data) // 2
    assert protocol.compute_crc(data[half:], protocol.compute_crc(data[:half])) == register


MARKS = st.lists(st.sampled_from([0x00, 0xFD, 0xFE, 0xFF]), max_size=40).map(bytes)


@given(MARKS)
def test_stuffing_hides_every_header_and_is_undone(content):
    stuffed = protocol.stuff(content)
    assert protocol.HEADER not in stuffed
    assert protocol.unstuff(stuffed) == content


@given(servo=st.integers(0, 252), error=st.integers(0, 255), data=MARKS)
def test_status_of_the_emulated_servo_is_decoded(servo, error, data):
    packet = framing.build_status(servo, error, data)
    (found,) = StatusParser().feed(packet)
    assert protocol.decode_status(found) == Status(servo, error, data)


@given(address=st.integers(0, 700), data=MARKS.filter(bool), cuts=st.integers(1, 7))
def test_emulated_servo_puts_a_cut_packet_together(address, data, cuts):
    packet = protocol.encode_write(9, address, data)
    reader = framing.InstructionReader()
    found = []
    for at in range(0, len(packet), cuts):
        found += reader.take(packet[at : at + cuts])
    (read,) = found
    assert read.intact
    assert read.parameters == address.to_bytes(2, "little") + data


NOISE = st.lists(st.sampled_from([0x00, 0x01, 0x55, 0xFD, 0xFE, 0xFF]), max_size=30).map(bytes)


@given(before=NOISE, cut=st.integers(1, 13), between=NOISE)
def test_parser_finds_the_packet_behind_noise_and_a_cut_off_one(before, cut, between):
    whole = bytes.fromhex(STATUSES["ping"][0])
    parser = StatusParser(longest=64)
    packets = parser.feed(before + whole[:cut] + between + whole)
    more, part = parser.finish()
    assert whole in [*packets, *more] or part, "a fast reply in the noise may hide it"
    assert not parser.pending


@given(st.integers(1, 13))
def test_parser_waits_for_the_rest(cut):
    whole = bytes.fromhex(STATUSES["ping"][0])
    parser = StatusParser()
    assert parser.feed(whole[:cut]) == []
    assert parser.feed(whole[cut:]) == [whole]
    assert (parser.corrupt, parser.noise) == (0, 0)


@pytest.mark.parametrize("at", range(14))
def test_parser_counts_a_flipped_bit_and_recovers(at):
    whole = bytes.fromhex(STATUSES["ping"][0])
    broken = whole[:at] + bytes((whole[at] ^ 0x10,)) + whole[at + 1 :]
    parser = StatusParser(longest=64)
    packets = parser.feed(broken + whole)
    more, _ = parser.finish()
    assert [*packets, *more] == [whole]
    assert parser.corrupt + parser.noise > 0


def test_parser_ignores_the_echo_of_an_instruction():
    echo = protocol.encode_sync_read(132, 4, (1, 2), fast=False)
    status = bytes.fromhex(STATUSES["position of 1"][0])
    parser = StatusParser()
    assert parser.feed(echo + status) == [status]
    assert (parser.corrupt, parser.noise) == (0, 0)


def fast_reply(count, size=4):
    line = framing.begin_common_status(size, count)
    for servo in range(1, count + 1):
        line += framing.build_block(framing.checksum(line), servo, 0, bytes((servo,)) * size)
    return line


@pytest.mark.parametrize("cut", range(8, 8 + 3 * 8))
def test_fast_reply_that_is_cut_off_gives_its_whole_blocks(cut):
    line = fast_reply(3)[:cut]
    parser = StatusParser()
    assert parser.feed(line) == []
    packets, part = parser.finish()
    assert packets == []
    found = protocol.decode_fast_status(part, 4)
    assert [status.id for status in found] == list(range(1, 1 + (cut - 8) // 8))


@pytest.mark.parametrize("at", range(8, 14))
def test_damage_on_the_way_to_us_costs_one_block_only(at):
    line = fast_reply(3)
    broken = line[:at] + bytes((line[at] ^ 0x04,)) + line[at + 1 :]
    found = protocol.decode_fast_status(broken, 4)
    assert [status and status.id for status in found] == [None, 2, 3]


def test_damage_that_all_heard_costs_one_block_only():
    line = framing.begin_common_status(4, 3)
    block = framing.build_block(framing.checksum(line), 1, 0, b"\1\1\1\1")
    line += bytes(byte & 0x5A for byte in block)  # two spoke at once, and all heard that
    for servo in (2, 3):
        line += framing.build_block(framing.checksum(line), servo, 0, bytes(4))
    found = protocol.decode_fast_status(line, 4)
    assert [status and status.id for status in found] == [None, 2, 3]
