"""A log row by row: csv, parquet, and MCAP in chunks with an index."""

from pathlib import Path

import numpy as np

from rig.hal import ConfigurationError
from rig.installation import installing
from rig.runtime.log import LogError, LogFile

_ROW_GROUP = 50_000
"""Rows of a parquet file that are compressed together."""


def write_csv(file: LogFile, target: Path) -> None:
    """Write one line per cycle under a line of names with their unit in brackets.

    Numbers have as many digits as give back the very same number.
    """
    import csv

    with target.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        titles = [f"{c.name} [{c.unit}]" if c.unit else c.name for c in file.columns]
        writer.writerow(["cycle", "t [s]", *titles])
        for rows in file.pieces():
            columns = (rows["cycle"].tolist(), rows["t"].tolist(), rows["row"].tolist())
            for cycle, t, row in zip(*columns, strict=True):
                writer.writerow([cycle, t, *row])


def write_parquet(file: LogFile, target: Path) -> None:
    """Write one column per column; unit and description are metadata of each.

    Raises
    ------
    ConfigurationError
        `pyarrow` is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise ConfigurationError(f"parquet needs pyarrow: {installing('pyarrow')}") from error
    fields = [pa.field("cycle", pa.uint64()), pa.field("t", pa.float64(), metadata={"unit": "s"})]
    for column in file.columns:
        told = {"unit": column.unit, "description": column.description}
        fields.append(pa.field(column.name, pa.float64(), metadata=told))
    schema = pa.schema(fields)
    with pq.ParquetWriter(target, schema, compression="zstd") as writer:
        waiting: list[pa.RecordBatch] = []
        for rows in file.pieces():
            values = np.ascontiguousarray(rows["row"].T)
            arrays = [rows["cycle"].copy(), rows["t"].copy(), *values]
            waiting.append(pa.record_batch([pa.array(array) for array in arrays], schema))
            if sum(batch.num_rows for batch in waiting) >= _ROW_GROUP:
                writer.write_table(pa.Table.from_batches(waiting, schema))
                waiting.clear()
        if waiting:
            writer.write_table(pa.Table.from_batches(waiting, schema))


def write_mcap(file: LogFile, target: Path) -> None:
    """Write the same messages in compressed chunks with an index of their times.

    The log itself has neither, so that nothing is lost when the program is killed; readers that
    look for the index see it as empty, or read it whole.
    """
    from mcap.records import Channel, Schema
    from mcap.stream_reader import StreamReader
    from mcap.well_known import Profile
    from mcap.writer import LIBRARY_IDENTIFIER, CompressionType, Writer

    found: dict[type, Schema | Channel] = {}
    with file.path.open("rb") as stream:
        for record in StreamReader(stream).records:
            if isinstance(record, Schema | Channel):
                found[type(record)] = record
            if len(found) == 2:
                break
    schema, channel = found.get(Schema), found.get(Channel)
    if not isinstance(schema, Schema) or not isinstance(channel, Channel):
        raise LogError(f"the log {file.path} does not describe its messages")
    with target.open("wb") as output:
        writer = Writer(output, compression=CompressionType.ZSTD)
        writer.start(Profile.ROS2, LIBRARY_IDENTIFIER)
        schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
        channel_id = writer.register_channel(
            channel.topic, channel.message_encoding, schema_id, channel.metadata
        )
        for stamp, number, data in file.raw_messages():
            writer.add_message(channel_id, stamp, data, stamp, number)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap has types elsewhere
