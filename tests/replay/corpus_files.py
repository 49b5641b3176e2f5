"""Recorded runs, small enough to be kept: what a replay needs of a run folder, in one file."""

import json
import lzma
import struct
from pathlib import Path

import numpy as np

from rig.hal.columns import Column
from rig.runtime.log import read_log
from rig.runtime.recorder import LogRecorder

CORPUS = Path(__file__).parents[1] / "data" / "replay"
MANIFEST = CORPUS / "manifest.json"
SUFFIX = ".run.xz"

_NOT_KEPT = ("timing.", "truth.")
"""Groups of columns that no command follows from."""
_TEXTS = ("profile.yaml", "experiment.yaml")
_LENGTH = struct.Struct("<I")


def pack(folder, target):
    """Keep a run folder: its files, and its log column by column, which compresses four times
    as well as row by row. Returns the number of cycles."""
    log = read_log(folder / "log.mcap")
    kept = [k for k, c in enumerate(log.columns) if not c.name.startswith(_NOT_KEPT)]
    texts = [*_TEXTS, *(f"eds/{path.name}" for path in sorted((folder / "eds").glob("*")))]
    head = {
        "manifest": json.loads((folder / "manifest.json").read_text()),
        "texts": {name: (folder / name).read_text() for name in texts},
        "columns": [list(log.columns[k]) for k in kept],
        "cycles": len(log.cycle),
    }
    told = json.dumps(head).encode()
    numbers = (log.cycle.astype("<u8"), log.t.astype("<f8"), *log.values.T[kept].astype("<f8"))
    content = _LENGTH.pack(len(told)) + told + b"".join(column.tobytes() for column in numbers)
    target.write_bytes(lzma.compress(content, preset=9 | lzma.PRESET_EXTREME))
    return len(log.cycle)


def unpack(source, folder):
    """Make a run folder of a kept run, as far as a replay looks at one."""
    content = lzma.decompress(source.read_bytes())
    (length,) = _LENGTH.unpack_from(content)
    start = _LENGTH.size + length
    head = json.loads(content[_LENGTH.size : start])
    folder.mkdir(parents=True)
    (folder / "manifest.json").write_text(json.dumps(head["manifest"]))
    (folder / "events.jsonl").touch()
    for name, text in head["texts"].items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    cycles = head["cycles"]
    columns = [Column(*column) for column in head["columns"]]
    cycle = np.frombuffer(content, "<u8", cycles, start)
    numbers = np.frombuffer(content, "<f8", (1 + len(columns)) * cycles, start + 8 * cycles)
    t, *values = numbers.reshape(1 + len(columns), cycles)
    with LogRecorder(folder / "log.mcap", columns, wall_clock_ns=0) as recorder:
        for k, at, row in zip(cycle.tolist(), t.tolist(), np.array(values).T.tolist(), strict=True):
            recorder.write(k, at, row)
    return folder
