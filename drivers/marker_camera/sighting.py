"""What one frame showed, and its form between two processes."""

import struct
from enum import IntEnum
from math import nan
from typing import Final, NamedTuple

from drivers.marker_camera.projection import Vector3


class Sight(IntEnum):
    """A verdict on one frame: the marker was seen, or why it was not."""

    SEEN = 0
    COVERED = 1
    """The image is dark: the lens is covered or the lamp is off; `amount` is its mean, counts."""
    LOST = 2
    """Nothing stands out; `amount` is the contrast, counts."""
    SWAPPED = 3
    """Another marker is in view; `amount` is its number, or the diameter of its disc, m."""
    MIRRORED = 4
    """The marker is there in mirror writing; `amount` is its number."""
    OUTSIDE = 5
    """What stands out is off the marker's sphere; `amount` is its x, pixels."""
    FROZEN = 6
    """The image repeats itself; `amount` is how often in a row."""


class Sighting(NamedTuple):
    """One frame's outcome.

    Attributes
    ----------
    frame : int
        Number of the frame in its stream; a gap is a dropped frame.
    t : float
        Middle of the exposure, s on the rig's clock.
    sight : Sight
        Whether the marker was seen, or why not.
    ids : tuple of int
        Markers seen.
    positions : tuple of tuple of float
        Their centres in the joint's base frame, m.
    twists : tuple of float
        Their twists, rad; NaN for a marker that does not show it.
    amount : float
        The number that goes with `sight`.
    """

    frame: int
    t: float
    sight: Sight
    ids: tuple[int, ...] = ()
    positions: tuple[Vector3, ...] = ()
    twists: tuple[float, ...] = ()
    amount: float = nan


_HEAD: Final = struct.Struct("<QdBdB")
_MARKER: Final = struct.Struct("<i4d")


def encode_sighting(sighting: Sighting) -> bytes:
    """Return a sighting as bytes."""
    head = _HEAD.pack(
        sighting.frame, sighting.t, sighting.sight, sighting.amount, len(sighting.ids)
    )
    rows = zip(sighting.ids, sighting.positions, sighting.twists, strict=True)
    return head + b"".join(_MARKER.pack(number, *at, twist) for number, at, twist in rows)


def decode_sighting(data: bytes) -> Sighting:
    """Return the sighting of `encode_sighting`.

    Raises
    ------
    ValueError
        The bytes are not those of a sighting.
    """
    if len(data) < _HEAD.size:
        raise ValueError(f"A sighting has at least {_HEAD.size} bytes, not {len(data)}.")
    frame, t, sight, amount, count = _HEAD.unpack_from(data)
    if len(data) != _HEAD.size + count * _MARKER.size:
        raise ValueError(f"A sighting of {count} markers does not have {len(data)} bytes.")
    rows = tuple(_MARKER.iter_unpack(data[_HEAD.size :]))
    return Sighting(
        frame,
        t,
        Sight(sight),
        tuple([row[0] for row in rows]),
        tuple([row[1:4] for row in rows]),
        tuple([row[4] for row in rows]),
        amount,
    )
