"""JSON files that are whole or not there, of any plain data and numpy's numbers."""

import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path

from rig.whole_file import write_whole


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Write a file, whole or not at all; numbers that JSON does not have become null.

    Raises
    ------
    OSError
        It cannot be written, or there is a link; what was there is as it was.
    """
    text = json.dumps(plain(content), indent=2, ensure_ascii=False, allow_nan=False)
    write_whole(path, text + "\n")


def plain(value: object) -> object:
    """Make a value of JSON's own types, with null for numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    numpy = sys.modules.get("numpy")  # without it there is nothing of its kinds
    if numpy is not None and isinstance(value, numpy.generic | numpy.ndarray):
        return plain(value.tolist())
    return str(value)
