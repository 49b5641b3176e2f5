"""A run's log for other programs: csv, npz, mat, parquet and indexed MCAP."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rig.exporting.arrays import matlab_names, write_mat, write_npz
from rig.exporting.rows import write_csv, write_mcap, write_parquet
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten
from rig.run_folder import RunFolder
from rig.runtime.log import LogFile
from rig.whole_file import clear_left_over, whole_file

FORMATS: dict[str, Callable[[LogFile, Path], None]] = {
    "csv": write_csv,
    "npz": write_npz,
    "mat": write_mat,
    "parquet": write_parquet,
    "mcap": write_mcap,
}


class ExportError(ConfigurationError):
    """The exported file cannot be written."""


class Exported(NamedTuple):
    """A log in another format.

    Parameters
    ----------
    path : Path
        The file written.
    missing : str or None
        Says that the run came to its end and the log does not: the file ends as the log does.
    """

    path: Path
    missing: str | None


def export_run(path: str | Path, format: str, out: str | Path | None = None) -> Exported:
    """Export the log of a run folder, whatever became of the run.

    Parameters
    ----------
    path : Path
        The run folder.
    format : str
        One of `FORMATS`.
    out : Path, optional
        The file to write; default: ``log.<format>`` in the run folder, and for MCAP
        ``log-indexed.mcap``.

    Raises
    ------
    ConfigurationError
        There is no such format or run folder.
    LogError
        The folder has no readable log, or it is damaged; nothing is written then.
    ExportError
        The file cannot be written.
    """
    if format not in FORMATS:
        raise ConfigurationError(
            f"cannot export to {format!r}; the formats are {', '.join(FORMATS)}"
        )
    folder = RunFolder.open(path)
    file = LogFile(folder.log_path)
    name = "log-indexed.mcap" if format == "mcap" else f"log.{format}"
    target = folder.place(name) if out is None else Path(out)
    if target.exists() and target.samefile(folder.log_path):
        raise ConfigurationError(f"{target} is the run's log itself; choose another place")
    try:
        if out is not None and target.exists() and not target.is_file():  # a pipe or a terminal
            FORMATS[format](file, target)
        else:
            clear_left_over(target.parent, target.name)
            with whole_file(target) as temporary:
                FORMATS[format](file, temporary)
    except OSError as error:
        reason = reason_unwritten(target, error)
        elsewhere = "; --out FILE writes elsewhere" if isinstance(error, PermissionError) else ""
        raise ExportError(f"cannot write {target}: {reason}{elsewhere}") from error
    return Exported(target, folder.missing_end(complete=file.complete))


__all__ = ["FORMATS", "ExportError", "Exported", "export_run", "matlab_names"]
