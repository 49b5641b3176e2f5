"""The records around the messages of an MCAP file: header, schema, channel; index, footer.

They are written by hand: the `mcap` library's record classes take a quarter of a second to
import, which every run would wait for, and its `Writer` keeps its statistics to itself, so it
would count none of the messages that `LogRecorder` packs, and call a finished log empty.

References
----------
MCAP specification, https://mcap.dev/spec, section "Records".
"""

import json
import struct
import zlib
from collections.abc import Mapping, Sequence

from rig.hal.columns import SCHEMA_NAME, Column, check_columns, schema_text

TOPIC = "/cycle"
CHANNEL_ID = 1
COLUMNS_KEY = "columns"
"""Key of the channel metadata under which the columns stand as JSON."""
CHECKSUM_KEY, CHECKSUM = "checksum", "crc32"
"""Entry of the channel metadata that says that every message ends with its checksum."""

MAGIC = b"\x89MCAP0\r\n"
_HEADER, _FOOTER, _SCHEMA, _CHANNEL = 0x01, 0x02, 0x03, 0x04
_STATISTICS, _SUMMARY_OFFSET, _DATA_END = 0x0B, 0x0E, 0x0F
_SCHEMA_ID = 1


def encode_preamble(columns: Sequence[Column]) -> bytes:
    """Compose everything before the first message.

    Raises
    ------
    ValueError
        The columns do not make a legal message.
    """
    header = _record(_HEADER, _text("ros2") + _text("rig"))
    return MAGIC + header + _schema(columns) + _channel(columns)


def encode_ending(
    columns: Sequence[Column], offset: int, count: int, first: int, last: int
) -> bytes:
    """Compose everything after the last message: end of data, summary, footer.

    Parameters
    ----------
    columns : sequence of Column
        Those of the preamble.
    offset : int
        Where in the file this will stand.
    count : int
        Number of messages.
    first, last : int
        Log times of the first and last message, ns since the epoch.
    """
    # One schema, one channel; no attachments, metadata records or chunks.
    counts = struct.pack("<HQ", CHANNEL_ID, count) if count else b""
    statistics = struct.pack("<QHIIIIQQ", count, 1, 1, 0, 0, 0, first, last) + _sized(counts)
    data_end = _record(_DATA_END, struct.pack("<I", 0))  # 0: without a checksum
    start = offset + len(data_end)
    summary = offsets = b""
    for data in (_schema(columns), _channel(columns), _record(_STATISTICS, statistics)):
        group = struct.pack("<BQQ", data[0], start + len(summary), len(data))
        offsets += _record(_SUMMARY_OFFSET, group)
        summary += data
    offset_start = start + len(summary)
    summary += offsets
    # The checksum covers the footer too, up to itself.
    footer_head = struct.pack("<BQQQ", _FOOTER, 20, start, offset_start)
    checksum = struct.pack("<I", zlib.crc32(summary + footer_head))
    return data_end + summary + footer_head + checksum + MAGIC


def decode_channel(channel_record: bytes) -> tuple[tuple[Column, ...], bool] | None:
    """Return the columns of a Channel record's body, and whether messages have a checksum.

    Returns
    -------
    tuple or None
        None if it names no columns.

    Raises
    ------
    ValueError
        It is no Channel record, or what it says of the columns is no list of them.
    """
    try:
        _, rest = _take_text(channel_record[4:])  # two identifiers; topic
        _, rest = _take_text(rest)  # encoding of the messages
        metadata = _take_texts(rest)
        told = metadata.get(COLUMNS_KEY)
        if told is None:
            return None
        columns = tuple(Column(*map(str, column)) for column in json.loads(told))
        check_columns(columns)
    except (struct.error, TypeError, RecursionError) as error:
        raise ValueError(str(error)) from error
    return columns, metadata.get(CHECKSUM_KEY) == CHECKSUM


def _schema(columns: Sequence[Column]) -> bytes:
    body = struct.pack("<H", _SCHEMA_ID) + _text(SCHEMA_NAME) + _text("ros2msg")
    return _record(_SCHEMA, body + _sized(schema_text(columns).encode()))


def _channel(columns: Sequence[Column]) -> bytes:
    # ROS definitions have units only in comments, so `read_log` takes its columns from here.
    metadata = {
        COLUMNS_KEY: json.dumps([list(column) for column in columns]),
        CHECKSUM_KEY: CHECKSUM,
    }
    body = struct.pack("<HH", CHANNEL_ID, _SCHEMA_ID) + _text(TOPIC) + _text("cdr")
    return _record(_CHANNEL, body + _texts(metadata))


def _record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def _sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def _text(text: str) -> bytes:
    return _sized(text.encode())


def _texts(texts: Mapping[str, str]) -> bytes:
    return _sized(b"".join(_text(key) + _text(value) for key, value in texts.items()))


def _take_sized(data: bytes) -> tuple[bytes, bytes]:
    """Return what stands at the front after its length, and the rest.

    Raises
    ------
    struct.error, ValueError
        There is no length, or less than it says.
    """
    (length,) = struct.unpack_from("<I", data)
    end = 4 + length
    if end > len(data):
        raise ValueError(f"{length} bytes are announced, and {len(data) - 4} there")
    return data[4:end], data[end:]


def _take_text(data: bytes) -> tuple[str, bytes]:
    text, rest = _take_sized(data)
    return text.decode(), rest


def _take_texts(data: bytes) -> dict[str, str]:
    rest, _ = _take_sized(data)
    texts = {}
    while rest:
        key, rest = _take_text(rest)
        texts[key], rest = _take_text(rest)
    return texts
