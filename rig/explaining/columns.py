"""The columns of a log: of a profile's mechanism and devices, or as a run has recorded them."""

from collections.abc import Iterable
from pathlib import Path

from rig.config import Profile
from rig.explaining.glossary import Word
from rig.hal import ConfigurationError
from rig.hal.columns import Column
from rig.run_facts import LOG
from rig.run_names import list_runs

COLUMN = "log column"


def columns_called(word: str, profile: Profile | None, runs: Path) -> list[Word]:
    """Return the columns of a name, or of a name below a group: ``position`` of ``reading``.

    Parameters
    ----------
    word : str
        As somebody asks for it.
    profile : Profile, optional
        Whose columns; None: those of the newest run.
    runs : Path
        Where run folders live.
    """
    if profile is not None:
        from rig.assembly import check_profile

        return _words(word, check_profile(profile), profile.name)
    for run in list_runs(runs)[:1]:
        from rig.runtime.log import LogFile  # with numpy

        try:
            return _words(word, LogFile(run / LOG).columns, run.name)
        except ConfigurationError:  # never recorded, or damaged: that is for `rig report` to tell
            continue
    return []


def _words(word: str, columns: Iterable[Column], of: str) -> list[Word]:
    return [
        Word(column.name, COLUMN, of, f"{column.description}, {column.unit or '1'}")
        for column in columns
        if column.name == word or column.name.endswith(f".{word}")
    ]
