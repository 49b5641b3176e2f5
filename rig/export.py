"""A run's log for other programs: csv, npz and mat."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rig.hal import ConfigurationError, RigError
from rig.run_folder import RunFolder
from rig.runtime.log import Log, read_log

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MATLAB_NAME_LENGTH = 31
"""What MATLAB's level-5 files allow for a name."""


class ExportError(RigError):
    """The exported file cannot be written."""


def export_run(path: str | Path, format: str, out: str | Path | None = None) -> Path:
    """Export the log of a run folder, whatever became of the run.

    Parameters
    ----------
    path : Path
        The run folder.
    format : str
        ``"csv"``, ``"npz"`` or ``"mat"``.
    out : Path, optional
        The file to write; default: ``log.<format>`` in the run folder.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ConfigurationError
        There is no such format or run folder.
    LogError
        The folder has no readable log.
    ExportError
        The file cannot be written.
    """
    if format not in FORMATS:
        raise ConfigurationError(
            f"cannot export to {format!r}; the formats are {', '.join(FORMATS)}"
        )
    folder = RunFolder.open(path)
    log = read_log(folder.log_path)
    target = folder.path / f"log.{format}" if out is None else Path(out)
    try:
        FORMATS[format](log, target)
    except OSError as error:
        raise ExportError(f"cannot write {target}: {error.strerror or error}") from error
    return target


def write_csv(log: Log, target: Path) -> None:
    """Write one line per cycle under a line of names with their unit in brackets.

    Numbers have as many digits as give back the very same number.
    """
    import csv

    with target.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            ["cycle", "t [s]"] + [f"{c.name} [{c.unit}]" if c.unit else c.name for c in log.columns]
        )
        for cycle, t, row in zip(
            log.cycle.tolist(), log.t.tolist(), log.values.tolist(), strict=True
        ):
            writer.writerow([cycle, t, *row])


def write_npz(log: Log, target: Path) -> None:
    """Write one array per column by its name, and ``names``, ``units``, ``descriptions``."""
    arrays = _arrays(log)
    # A file object, because numpy would append ".npz" to another name.
    with target.open("wb") as stream:
        np.savez_compressed(
            stream,
            allow_pickle=False,
            **arrays,
            names=np.array([c.name for c in log.columns]),
            units=np.array([c.unit for c in log.columns]),
            descriptions=np.array([c.description for c in log.columns]),
        )


def write_mat(log: Log, target: Path) -> None:
    """Write one column vector per column, and ``columns``: its names, units, descriptions.

    ``reading.position`` becomes ``reading_position``, since a dot is not legal in a name.
    """
    from scipy.io import savemat

    legal = matlab_names(["cycle", "t", *(column.name for column in log.columns)])
    arrays: dict[str, object] = dict(zip(legal, _arrays(log).values(), strict=True))
    arrays["columns"] = {
        "variable": np.array(legal[2:], dtype=object),
        "name": np.array([c.name for c in log.columns], dtype=object),
        "unit": np.array([c.unit for c in log.columns], dtype=object),
        "description": np.array([c.description for c in log.columns], dtype=object),
    }
    with target.open("wb") as stream:
        savemat(stream, arrays, oned_as="column", do_compression=True)


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


FORMATS: dict[str, Callable[[Log, Path], None]] = {
    "csv": write_csv,
    "npz": write_npz,
    "mat": write_mat,
}


def _arrays(log: Log) -> "dict[str, NDArray[np.generic]]":
    arrays: dict[str, NDArray[np.generic]] = {"cycle": log.cycle, "t": log.t}
    arrays.update({column.name: log.column(column.name) for column in log.columns})
    return arrays
