"""What page and server say to each other: numbers as bytes, everything else as JSON."""

import json
import math
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.hal.pictures import Snapshot

ROWS, FRAMES, BESIDE, CAMERA = 1, 2, 3, 4
"""Kinds of packed messages."""
_HEAD = struct.Struct("<IIIId")
"""Kind, number of the request that it answers, rows, values of a row, and the first time, s."""
_SIZE = struct.Struct("<HH24s")
LONGEST = 16 << 10
"""Bytes of the longest message that a page may send."""
MOST_COLUMNS = 256
MOST_ROWS = 20_000
MOST_FRAMES = 600

Request = dict[str, object]


class BadMessage(ValueError):
    """A message is none that a page sends."""


def pack(kind: int, number: int, t: "NDArray[np.float64]", values: "NDArray[np.float32]") -> bytes:
    """Return rows as bytes: single precision, times as differences from the first one."""
    origin = float(t[0]) if len(t) else 0.0
    body = np.empty((len(t), values.shape[1] + 1), "<f4")
    body[:, 0] = t - origin
    body[:, 1:] = values
    return _HEAD.pack(kind, number, len(t), values.shape[1], origin) + body.tobytes()


def pack_picture(number: int, picture: "Snapshot") -> bytes:
    """Return what a camera saw: where markers are, the image's size, a word, and the picture.

    Its frame's number stands where rows have their first time.
    """
    marks = np.array(picture.marks, "<f4").reshape(-1, 2)
    head = _HEAD.pack(CAMERA, number, len(marks), 1, float(picture.frame))
    size = _SIZE.pack(picture.width, picture.height, picture.verdict.encode()[:24])
    return head + marks.tobytes() + size + picture.jpeg


def parse(text: str, columns: int) -> Request:
    """Return a page's message with nothing in it but what may be in it.

    Parameters
    ----------
    text : str
        JSON.
    columns : int
        How many the log has.

    Raises
    ------
    BadMessage
        It is something else.
    """
    try:
        told = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadMessage("no JSON") from error
    if not isinstance(told, dict) or not isinstance(told.get("type"), str):
        raise BadMessage("no message")
    fields = _FIELDS.get(told["type"])
    if fields is None or told.keys() - {"type"} != fields.keys():
        raise BadMessage(f"no message of this kind: {str(told['type'])[:40]}")
    found: Request = {"type": told["type"]}
    for name, check in fields.items():
        value = told[name]
        if not check(value, columns):
            raise BadMessage(f"{name} is not what it may be")
        found[name] = value
    return found


Check = Callable[[object, int], bool]


def _is_count(most: int) -> Check:
    return lambda value, _: type(value) is int and 0 <= value <= most


def _is_number(value: object, _: int) -> bool:
    return type(value) in (int, float) and math.isfinite(float(str(value)))


def _is_text(longest: int) -> Check:
    return lambda value, _: isinstance(value, str) and len(value) <= longest


def _is_flag(value: object, _: int) -> bool:
    return isinstance(value, bool)


def _is_columns(value: object, columns: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) <= MOST_COLUMNS
        and all(type(k) is int and 0 <= k < columns for k in value)
    )


_NUMBER = _is_count(2**31)
_FIELDS: dict[str, dict[str, Check]] = {
    "open": {"token": _is_text(64)},
    "here": {"heard": _NUMBER},
    "follow": {"id": _NUMBER, "columns": _is_columns, "seconds": _is_number},
    "view": {
        "id": _NUMBER,
        "columns": _is_columns,
        "from": _is_number,
        "to": _is_number,
        "most": _is_count(MOST_ROWS),
    },
    "beside": {
        "id": _NUMBER,
        "columns": _is_columns,
        "from": _is_number,
        "to": _is_number,
        "most": _is_count(MOST_ROWS),
    },
    "frames": {
        "id": _NUMBER,
        "from": _is_number,
        "to": _is_number,
        "most": _is_count(MOST_FRAMES),
    },
    "gain": {"key": _is_text(80), "value": _is_number, "ramp": _is_number, "sure": _is_flag},
    "hold": {},
}
