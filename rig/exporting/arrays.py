"""A log column by column: npz and mat."""

import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import numpy as np

from rig.runtime.log import LogFile
from rig.runtime.log_columns import LogColumns, columns_of

_MATLAB_NAME_LENGTH = 31
"""What MATLAB's level-5 files allow for a name."""


def write_npz(file: LogFile, target: Path) -> None:
    """Write one array per column by its name, and ``names``, ``units``, ``descriptions``."""
    log = columns_of(file)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:

        def member(name: str) -> IO[bytes]:
            return archive.open(f"{name}.npy", "w", force_zip64=True)

        for name, kind in _kinds(log).items():
            head = {"descr": np.dtype(kind).str, "fortran_order": False, "shape": (log.rows,)}
            with member(name) as stream:
                np.lib.format.write_array_header_1_0(stream, head)
                for piece in log.pieces(name):
                    stream.write(piece.tobytes())
        for name, texts in (
            ("names", [c.name for c in file.columns]),
            ("units", [c.unit for c in file.columns]),
            ("descriptions", [c.description for c in file.columns]),
        ):
            with member(name) as stream:
                np.lib.format.write_array(stream, np.array(texts), allow_pickle=False)


def _kinds(log: LogColumns) -> dict[str, type[np.generic]]:
    """Return the names of all arrays, each with the kind of its numbers."""
    names = ["t", *(column.name for column in log.columns)]
    return {"cycle": np.uint64, **dict.fromkeys(names, np.float64)}


def write_mat(file: LogFile, target: Path) -> None:
    """Write one column vector per column, and ``columns``: its names, units, descriptions.

    ``reading.position`` becomes ``reading_position``, since a dot is not legal in a name.
    """
    from scipy.io import savemat

    log = columns_of(file)
    kinds = _kinds(log)
    legal = matlab_names([*kinds])
    told = {
        "variable": np.array(legal[2:], dtype=object),
        "name": np.array([c.name for c in file.columns], dtype=object),
        "unit": np.array([c.unit for c in file.columns], dtype=object),
        "description": np.array([c.description for c in file.columns], dtype=object),
    }
    with target.open("wb") as stream:
        # Variables follow each other in a file, and the head is written at its start alone.
        for name, (column, kind) in zip(legal, kinds.items(), strict=True):
            values, end = np.empty(log.rows, kind), 0
            for piece in log.pieces(column):
                start, end = end, end + len(piece)
                values[start:end] = piece
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
