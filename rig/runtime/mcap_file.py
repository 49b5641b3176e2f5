"""The records around the messages of an MCAP file: header, schema, channel; index, footer.

The records are those of the `mcap` library; only their order is ours. Its `Writer` keeps its
statistics to itself, so it would count none of the messages that `LogRecorder` packs by itself,
and the index of a finished log would call the log empty.
"""

import io
import json
import struct
import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rig.hal.columns import SCHEMA_NAME, Column, check_columns, schema_text

if TYPE_CHECKING:
    from mcap.records import Channel, McapRecord, Schema

TOPIC = "/cycle"
CHANNEL_ID = 1
COLUMNS_KEY = "columns"
"""Key of the channel metadata under which the columns stand as JSON."""
CHECKSUM_KEY, CHECKSUM = "checksum", "crc32"
"""Entry of the channel metadata that says that every message ends with its checksum."""


def encode_preamble(columns: Sequence[Column]) -> bytes:
    """Compose everything before the first message.

    Raises
    ------
    ValueError
        The columns do not make a legal message.
    """
    from mcap.records import Header
    from mcap.well_known import Profile
    from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC

    header = Header(profile=Profile.ROS2, library=LIBRARY_IDENTIFIER)
    return bytes(MCAP0_MAGIC) + _encode(header, _schema(columns), _channel(columns))


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
    from mcap.opcode import Opcode
    from mcap.records import DataEnd, Footer, Statistics, SummaryOffset
    from mcap.writer import MCAP0_MAGIC

    statistics = Statistics(
        attachment_count=0,
        channel_count=1,
        channel_message_counts={CHANNEL_ID: count} if count else {},
        chunk_count=0,
        message_count=count,
        metadata_count=0,
        message_start_time=first,
        message_end_time=last,
        schema_count=1,
    )
    data_end = _encode(DataEnd(data_section_crc=0))
    start = offset + len(data_end)
    summary = b""
    offsets = []
    for opcode, record in (
        (Opcode.SCHEMA, _schema(columns)),
        (Opcode.CHANNEL, _channel(columns)),
        (Opcode.STATISTICS, statistics),
    ):
        data = _encode(record)
        offsets.append(
            SummaryOffset(
                group_opcode=opcode, group_start=start + len(summary), group_length=len(data)
            )
        )
        summary += data
    offset_start = start + len(summary)
    summary += _encode(*offsets)
    # The checksum covers the footer too, up to itself.
    footer_head = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
    footer = Footer(
        summary_start=start,
        summary_offset_start=offset_start,
        summary_crc=zlib.crc32(summary + footer_head),
    )
    return data_end + summary + _encode(footer) + bytes(MCAP0_MAGIC)


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
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.records import Channel

    try:
        channel = Channel.read(ReadDataStream(io.BytesIO(channel_record)))
        told = channel.metadata.get(COLUMNS_KEY)
        if told is None:
            return None
        columns = tuple(Column(*map(str, column)) for column in json.loads(told))
        check_columns(columns)
    except (McapError, struct.error, TypeError, RecursionError) as error:
        raise ValueError(str(error)) from error
    return columns, channel.metadata.get(CHECKSUM_KEY) == CHECKSUM


def _schema(columns: Sequence[Column]) -> "Schema":
    from mcap.records import Schema
    from mcap.well_known import SchemaEncoding

    data = schema_text(columns).encode()
    return Schema(id=1, name=SCHEMA_NAME, encoding=SchemaEncoding.ROS2, data=data)


def _channel(columns: Sequence[Column]) -> "Channel":
    from mcap.records import Channel
    from mcap.well_known import MessageEncoding

    # ROS definitions have units only in comments, so `read_log` takes its columns from here.
    metadata = {
        COLUMNS_KEY: json.dumps([list(column) for column in columns]),
        CHECKSUM_KEY: CHECKSUM,
    }
    return Channel(
        id=CHANNEL_ID,
        topic=TOPIC,
        message_encoding=MessageEncoding.CDR,
        schema_id=1,
        metadata=metadata,
    )


def _encode(*records: "McapRecord") -> bytes:
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap has types elsewhere
