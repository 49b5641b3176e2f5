"""A log column by column: npz and mat."""

import re
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rig.runtime.log import LogFile

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MATLAB_NAME_LENGTH = 31
"""What MATLAB's level-5 files allow for a name."""
_AT_ONCE = 32 << 20
"""Bytes of columns that are collected in one pass through the log."""


def columns_of(file: LogFile) -> "Iterator[tuple[str, NDArray[np.generic]]]":
    """Yield ``cycle``, ``t`` and every column with its name; the log is read once for a few."""
    names = ["cycle", "t", *(column.name for column in file.columns)]
    at_once = max(_AT_ONCE // (8 * max(file.room, 1)), 1)
    for first in range(0, len(names), at_once):
        some = names[first : first + at_once]
        kinds = [np.uint64 if name == "cycle" else np.float64 for name in some]
        made = [np.empty(file.room, kind) for kind in kinds]
        end = 0
        for rows in file.pieces():
            start, end = end, end + len(rows)
            for k, values in enumerate(made, first):
                values[start:end] = rows[names[k]] if k < 2 else rows["row"][:, k - 2]
        for name, values in zip(some, made, strict=True):
            yield name, values[:end]


def write_npz(file: LogFile, target: Path) -> None:
    """Write one array per column by its name, and ``names``, ``units``, ``descriptions``."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:

        def put(name: str, values: "NDArray[np.generic]") -> None:
            with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, values, allow_pickle=False)

        for name, values in columns_of(file):
            put(name, values)
        put("names", np.array([c.name for c in file.columns]))
        put("units", np.array([c.unit for c in file.columns]))
        put("descriptions", np.array([c.description for c in file.columns]))


def write_mat(file: LogFile, target: Path) -> None:
    """Write one column vector per column, and ``columns``: its names, units, descriptions.

    ``reading.position`` becomes ``reading_position``, since a dot is not legal in a name.
    """
    from scipy.io import savemat

    legal = matlab_names(["cycle", "t", *(column.name for column in file.columns)])
    told = {
        "variable": np.array(legal[2:], dtype=object),
        "name": np.array([c.name for c in file.columns], dtype=object),
        "unit": np.array([c.unit for c in file.columns], dtype=object),
        "description": np.array([c.description for c in file.columns], dtype=object),
    }
    with target.open("wb") as stream:
        # Variables follow each other in a file, and the head is written at its start alone.
        for name, (_, values) in zip(legal, columns_of(file), strict=True):
            savemat(stream, {name: values}, oned_as="column", do_compression=True)
        savemat(stream, {"columns": told}, oned_as="column", do_compression=True)


def matlab_names(names: Sequence[str]) -> list[str]:
    """Return names that MATLAB accepts, each different from the others.

    Letters, digits and underscores, a letter first, at most 31 characters; ``columns`` is
    taken.
    """
    taken = {"columns"}
    legal = []
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9_]", "_", name)
        if not stem[:1].isalpha():
            stem = f"x{stem}"
        candidate = stem[:_MATLAB_NAME_LENGTH]
        number = 1
        while candidate in taken:
            number += 1
            candidate = f"{stem[: _MATLAB_NAME_LENGTH - len(str(number)) - 1]}_{number}"
        taken.add(candidate)
        legal.append(candidate)
    return legal
