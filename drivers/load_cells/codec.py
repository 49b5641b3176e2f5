"""Codec of load cells: counts to force, and which counts tell of a cell that is at its end."""

from typing import NamedTuple

from drivers.load_cells.settings import LoadCell


class CellCodec(NamedTuple):
    """One cell's straight line.

    Attributes
    ----------
    gain, offset : float
        ``force = gain · counts + offset``, N.
    low, high : float
        Counts at and beyond which the cell is overloaded or its wire is off.
    """

    gain: float
    offset: float
    low: float
    high: float


def cell_codec(cell: LoadCell) -> CellCodec:
    """Return the codec of a cell."""
    low, high = cell.raw
    gain = (cell.force[1] - cell.force[0]) / (high - low)
    return CellCodec(gain, cell.force[0] - gain * low - cell.zero, low, high)


def decode_force(codec: CellCodec, counts: float) -> float:
    """Return the force for counts, N."""
    return codec.gain * counts + codec.offset
