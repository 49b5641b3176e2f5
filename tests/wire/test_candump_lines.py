"""Frames as lines of text: what candump writes, and what its readers and ours make of it."""

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.can.candump import bounded, format_frame, parse_line, parse_lines
from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from rig.hal.frames import LoggedFrame

# Written by candump -L of can-utils 2020.11, and by newer ones, which tell the direction.
LINES = [
    ("(1700000000.000001) can0 080#", LoggedFrame(1700000000.000001, "can0", 0x080, b"")),
    ("(1700000000.5) vcan0 61D#00FF", LoggedFrame(1700000000.5, "vcan0", 0x61D, b"\x00\xff")),
    ("(1.000000) can0 061#R", LoggedFrame(1.0, "can0", 0x061 | REMOTE_FLAG, b"")),
    ("(1.000000) can0 061#R8", LoggedFrame(1.0, "can0", 0x061 | REMOTE_FLAG, b"")),
    (
        "(1.000000) can0 1FFFFFFF#01.02",
        LoggedFrame(1.0, "can0", 0x1FFF_FFFF | EXTENDED_FLAG, b"\x01\x02"),
    ),
    ("(1.000000) can0 00000001#", LoggedFrame(1.0, "can0", 1 | EXTENDED_FLAG, b"")),
    (
        "(1.000000) can0 20000004#0010000000000000",
        LoggedFrame(1.0, "can0", 4 | ERROR_FLAG, b"\x00\x10" + bytes(6)),
    ),
    ("(1.000000) can0 123#ab T", LoggedFrame(1.0, "can0", 0x123, b"\xab", True)),
    (
        "(0000000001.250000)  leg-1  123#AB R\r\n",
        LoggedFrame(1.25, "leg-1", 0x123, b"\xab", False),
    ),
]


@pytest.mark.parametrize(("line", "frame"), LINES)
def test_lines_of_candump_are_read(line, frame):
    assert parse_line(line) == frame


@pytest.mark.parametrize(
    "line",
    [
        "",
        "can0  123   [2]  11 22",  # candump without -L
        "(1.0) can0 12#11",
        "(1.0) can0 123#1",
        "(1.0) can0 FFF#11",
        "(1.0) can0 123##111",  # CAN FD
        "(1.0) can0 123#112233445566778899",
        "(x) can0 123#11",
    ],
)
def test_other_lines_are_refused(line):
    with pytest.raises(ValueError, match=r"candump -L|11-bit"):
        parse_line(line)


@given(
    can_id=st.one_of(
        st.integers(0, 0x7FF),
        st.integers(0, 0x7FF).map(lambda i: i | REMOTE_FLAG),
        st.integers(0, 0x1FFF_FFFF).map(lambda i: i | EXTENDED_FLAG),
        st.integers(0, 0xFFF).map(lambda i: i | ERROR_FLAG),
    ),
    data=st.binary(max_size=8),
)
def test_what_is_written_is_read_back(can_id, data):
    read = parse_line(f"(12.345678) can0 {format_frame(can_id, data)}")
    assert read == (12.345678, "can0", can_id, b"" if can_id & REMOTE_FLAG else data, None)


def test_a_torn_last_line_is_left_out_and_a_broken_one_is_named():
    good = "(1.0) can0 123#11\n"
    assert len(list(parse_lines([good, "\n", good, "(2.0) can0 12"], "x.log"))) == 2
    with pytest.raises(ValueError, match=r"^x\.log:2: this is no frame"):
        list(parse_lines([good, "(2.0) can0 12\n", good], "x.log"))


def test_a_line_that_fills_the_memory_is_refused():
    stream = io.StringIO(f"(1.0) can0 181#\n(2.0) can0 181#{'0' * 1_000_000}\n")
    with pytest.raises(ValueError, match=r"mine\.log:2: a line is longer"):
        list(bounded(stream, "mine.log"))
    assert stream.tell() < 100_000
