"""JSON files that are whole or not there, of any plain data and numpy's numbers."""

import contextlib
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Write a file, whole or not at all; numbers that JSON does not have become null.

    Raises
    ------
    OSError
        It cannot be written; what was there is as it was.
    """
    text = json.dumps(plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


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
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    return str(value)
