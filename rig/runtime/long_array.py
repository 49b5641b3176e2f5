"""Arrays too long for the memory: they stand in files, and so does what is computed from them.

Whoever judges or draws a long run computes with whole columns. Here their pages are those of files,
which the system takes from memory when it needs it. The numbers are those of arrays in memory, to
the last bit: numpy computes them as ever, and is told where they go.
"""

import contextlib
import math
import mmap
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

Given = Any
"""What numpy takes or returns, of which it says no more itself."""

if TYPE_CHECKING:
    from numpy.typing import DTypeLike, NDArray

    Some = NDArray[Given]

LONG: Final = 1 << 20
"""An array of so many bytes stands in a file."""
_FEW: Final = 1 << 10
"""Fewer rows are computed in memory, whatever becomes of them."""
_PIECE: Final = 1 << 16
"""Rows that are computed in one go where numpy cannot be told where they go."""
_TIP: Final = 2
"""Rows whose result shows of what type all of it is, and in which order it lies in memory."""


class LongArray(np.ndarray[Given, Given]):
    """Numbers in a nameless file; what is computed from them goes into others like it.

    A result that is short, or for which there is no room, is an array like any other.
    """

    folder: Path | None = None
    """Where the files are."""

    def __array_finalize__(self, parent: object) -> None:
        """Know the folder of the array that this is a part of."""
        self.folder = getattr(parent, "folder", None)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Given, **how: Given) -> Given:
        """Compute as numpy does, a long result into a file."""
        compute: Callable[..., Given] = getattr(ufunc, method)
        values, how = list(map(_plain, inputs)), {key: _plain(how[key]) for key in how}
        if (out := how.pop("out", None)) is not None:
            compute(*values, out=tuple(map(_plain, out)), **how)
            return out if len(out) > 1 else out[0]
        rows = _rows_of(ufunc, method, values, how)
        if rows < _FEW:
            return compute(*values, **how)
        tip = compute(*_cut(values, rows, slice(_TIP)), **how)
        found = _room(self.folder, rows, tip)
        compute(*values, out=_plain(found), **how)
        return found

    def __array_function__(self, function: Given, types: Given, args: Given, how: Given) -> Given:
        """Compute as numpy does, where it allows a long result into a file."""
        handle = _FUNCTIONS.get(function)
        found = NotImplemented if handle is None else handle(self.folder, *args, **how)
        if found is NotImplemented:
            return super().__array_function__(function, types, args, how)
        return found

    def __getitem__(self, key: Given) -> Given:
        """Return a part, or what an array of places or of truths chooses."""
        if isinstance(key, np.ndarray) and key.ndim == 1 and len(key) >= _FEW:
            return _chosen(self.folder, _plain(self), _plain(key))
        part = super().__getitem__(key)
        return _plain(part) if isinstance(part, LongArray) and part.nbytes < LONG else part

    def astype(self, dtype: Given, *args: Given, **how: Given) -> Given:
        """Return the same numbers of another type."""
        if args or how:
            return super().astype(dtype, *args, **how)
        found = np.empty_like(self, dtype)
        np.copyto(found, self, casting="unsafe")
        return found

    def copy(self, order: Given = "C") -> Given:
        """Return the same numbers once more."""
        return self.astype(self.dtype) if self.ndim == 1 or order == "K" else super().copy(order)

    def flatten(self, order: Given = "C") -> Given:
        """Return the same numbers once more, in a row."""
        return self.ravel(order).copy()

    def cumsum(self, axis: Given = None, *args: Given, **how: Given) -> Given:
        """Return the sum of all numbers up to each."""
        if self.ndim == 1:
            return np.add.accumulate(self, axis or 0, *args, **how)
        return super().cumsum(axis, *args, **how)

    def nonzero(self) -> "tuple[Some, ...]":
        """Return the places of what is not zero."""
        values = _plain(self)
        if self.ndim != 1:
            found: tuple[Some, ...] = values.nonzero()
            return found
        places = (part.start + np.flatnonzero(values[part]) for part in _pieces(len(values)))
        empty = np.zeros(0, np.intp)
        return (_filled(_room(self.folder, int(np.count_nonzero(values)), empty), places),)


def laid(
    folder: Path | None,
    shape: tuple[int, ...],
    kind: "DTypeLike",
    order: Literal["C", "F"] = "C",
) -> "Some":
    """Return room for numbers: in a file if they are many and the folder takes it, else in memory.

    Parameters
    ----------
    folder : Path
        Where the file is.
    shape : tuple of int
        Of the array.
    kind : dtype
        Of its numbers.
    order : str
        How they lie.
    """
    size = math.prod(shape) * np.dtype(kind).itemsize
    if size >= LONG and not np.dtype(kind).hasobject:
        with contextlib.suppress(OSError), tempfile.TemporaryFile(dir=folder) as nameless:
            # All of the room now: where a disk turns out to be full later, the process ends.
            os.posix_fallocate(nameless.fileno(), 0, size)
            pages = mmap.mmap(nameless.fileno(), size)
            return _array(folder, shape, kind, pages, order)
    return np.empty(shape, kind, order)


def mapped(folder: Path, file: int, start: int, count: int, kind: "DTypeLike") -> "Some":
    """Return numbers that stand in a file; changing them does not change it.

    Parameters
    ----------
    folder : Path
        Where to compute with them.
    file : int
        Open for reading and writing.
    start : int
        Where they begin, bytes; a multiple of `mmap.ALLOCATIONGRANULARITY`.
    count : int
        How many there are.
    kind : dtype
        Theirs.
    """
    size = count * np.dtype(kind).itemsize
    pages = mmap.mmap(file, size, access=mmap.ACCESS_COPY, offset=start)
    return _array(folder, (count,), kind, pages, "C")


def _array(
    folder: Path | None, shape: tuple[int, ...], kind: "DTypeLike", pages: mmap.mmap, order: Given
) -> LongArray:
    found = LongArray(shape, kind, pages, order=order)
    found.folder = folder
    return found


def _plain(value: Given) -> Given:
    return value.view(np.ndarray) if isinstance(value, LongArray) else value


def _room(folder: Path | None, rows: int, tip: "Some") -> "Some":
    """Return room for a result of which the first rows are known."""
    is_other = tip.flags.f_contiguous and not tip.flags.c_contiguous
    return laid(folder, (rows, *tip.shape[1:]), tip.dtype, "F" if is_other else "C")


def _pieces(rows: int) -> Iterator[slice]:
    return (slice(start, start + _PIECE) for start in range(0, rows, _PIECE))


def _cut(values: Iterable[Given], rows: int, part: slice) -> list[Given]:
    """Return the same part of all that has so many rows."""
    return [value[part] if np.ndim(value) and len(value) == rows else value for value in values]


def _filled(room: "Some", parts: Iterable["Some"]) -> "Some":
    end = 0
    for part in parts:
        start, end = end, end + len(part)
        room[start:end] = part
    return room


def _rows_of(ufunc: np.ufunc, method: str, values: Sequence[Given], how: dict[str, Given]) -> int:
    """Return how many rows a result has whose place numpy can be told; 0: it cannot."""
    first = np.ndim(values[0])
    if ufunc.nout != 1 or how.get("where", True) is not True:
        return 0
    if method == "__call__" and ufunc.signature is None:
        most = max(map(np.ndim, values))
        return max((len(value) for value in values if np.ndim(value) == most), default=0)
    goes_by_rows = {
        "__call__": first > 1,
        "accumulate": first == 1,
        "reduce": first > 1 and how.get("axis", 0) in (-1, first - 1),
    }
    return len(values[0]) if goes_by_rows.get(method, False) else 0


def _chosen(folder: Path | None, values: "Some", key: "Some") -> "Some":
    """Return the rows that truths or places choose."""
    if key.dtype != bool:
        return _filled(
            _room(folder, len(key), values[:_TIP]),
            (values[key[part]] for part in _pieces(len(key))),
        )
    if len(key) != len(values):
        raise IndexError(f"{len(key)} truths cannot choose among {len(values)} rows")
    return _filled(
        _room(folder, int(np.count_nonzero(key)), values[:_TIP]),
        (values[part][key[part]] for part in _pieces(len(key))),
    )


def _by_rows(folder: Path | None, compute: Callable[..., Given], *values: Given) -> "Some":
    """Compute what depends on nothing but its own row, a piece at a time."""
    values, rows = tuple(map(_plain, values)), len(values[0])
    tip = compute(*_cut(values, rows, slice(_TIP)))
    parts = (compute(*_cut(values, rows, part)) for part in _pieces(rows))
    return _filled(_room(folder, rows, tip), parts)


def _concatenate(
    folder: Path | None,
    arrays: Sequence[Given],
    axis: int | None = 0,
    out: Given = None,
    *,
    dtype: Given = None,
    **how: Given,
) -> Given:
    plain = [np.asarray(array) for array in arrays]
    if axis is None or out is not None or dtype is not None:
        return np.concatenate(plain, axis, _plain(out), dtype=dtype, **how)
    is_along = axis % plain[0].ndim == 0
    tip = np.concatenate([array[:_TIP] for array in plain], axis, **how)
    found = _room(folder, sum(map(len, plain)) if is_along else len(plain[0]), tip)
    np.concatenate(plain, axis, _plain(found), **how)
    return found


def _empty_like(
    folder: Path | None, like: Given, dtype: Given = None, order: Given = "K", subok: Given = True,
    shape: Given = None, **_: Given,
) -> Given:  # fmt: skip
    kind = like.dtype if dtype is None else dtype
    if shape is not None:
        return laid(folder, tuple(np.atleast_1d(shape).tolist()), kind)
    return _room(folder, len(like), np.empty_like(_plain(like)[:_TIP], kind))


def _interp(folder: Path | None, x: Given, *knots: Given, **how: Given) -> Given:
    # What does not lie in one piece would be copied for every piece of x.
    each = [np.asanyarray(values) for values in knots]
    knots = tuple(_plain(values if values.flags.c_contiguous else values.copy()) for values in each)
    if np.ndim(x) != 1:
        return np.interp(_plain(x), *knots, **how)
    return _by_rows(folder, lambda part: np.interp(part, *knots, **how), x)


def _norm(
    folder: Path | None, x: Given, ord: Given = None, axis: Given = None, **how: Given
) -> Given:
    if axis not in (1, -1) or x.ndim != 2:
        return np.linalg.norm(_plain(x), ord, axis, **how)
    return _by_rows(folder, lambda part: np.linalg.norm(part, ord, axis, **how), x)


def _where(folder: Path | None, condition: Given, *values: Given) -> Given:
    if np.ndim(condition) != 1 or not values:
        return NotImplemented
    return _by_rows(folder, np.where, condition, *values)


_FUNCTIONS: Final[dict[Given, Callable[..., Given]]] = {
    np.concatenate: _concatenate,
    np.empty_like: _empty_like,
    np.interp: _interp,
    np.linalg.norm: _norm,
    np.where: _where,
    np.nanmax: lambda _, x, *args, **how: np.nanmax(_plain(x), *args, **how),
    np.nanmin: lambda _, x, *args, **how: np.nanmin(_plain(x), *args, **how),
}
"""What to do instead of what numpy does, which would take memory for a whole column."""
