"""A run folder as what is needed to replay it: its plan, made anew, and its log."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rig import provenance
from rig.experiment.plan import Plan, load_plan
from rig.hal import ConfigurationError
from rig.run_folder import RunFolder
from rig.runtime.cycle import RUN_COLUMNS
from rig.runtime.log import Log, LogError, read_log

PROFILE, EXPERIMENT, CODE = "profile.yaml", "experiment.yaml", "code"


class Logged(NamedTuple):
    """A cycle of a log.

    Parameters
    ----------
    cycle : int
        Its number: the tick that it was due at.
    t : float
        Since the first cycle, s.
    values : dict
        By the names of the columns.
    """

    cycle: int
    t: float
    values: dict[str, float]


class RecordedRun(NamedTuple):
    """A run that is on disk, and the plan that its own files lead to with the code at hand.

    Parameters
    ----------
    folder : RunFolder
        As it was found.
    plan : Plan
        From the profile and the experiment in the folder.
    log : Log
        Every cycle that was recorded.
    """

    folder: RunFolder
    plan: Plan
    log: Log

    def cycles(self) -> Iterator[Logged]:
        """Yield the cycles in their order."""
        names = [column.name for column in self.log.columns]
        log = self.log
        for cycle, t, row in zip(log.cycle.tolist(), log.t.tolist(), log.values, strict=True):
            yield Logged(cycle, t, dict(zip(names, row.tolist(), strict=True)))


def open_recorded(path: Path, overrides: Sequence[str] = ()) -> RecordedRun:
    """Open a run folder for a replay.

    Parameters
    ----------
    path : Path
        The folder.
    overrides : sequence of str
        ``a.b=c`` options over the folder's profile and experiment.

    Raises
    ------
    ConfigurationError
        It is no run folder, it lacks a file, it comes from a version whose logs say too little,
        or its profile or experiment is not valid for the code at hand.
    LogError
        The log is none, or is damaged.
    """
    folder = RunFolder.open(path)
    if any(event.get("kind") == "tuning" for event in folder.events()):
        raise ConfigurationError(
            f"{path}: its gains were changed while it ran, which a replay does not do"
        )
    plan = plan_of(folder, overrides)
    log = read_log(folder.log_path)
    torn = folder.missing_end(complete=log.complete)
    if torn is not None:
        raise LogError(torn)
    known = {column.name for column in log.columns}
    missing = [column.name for column in RUN_COLUMNS if column.name not in known]
    if missing:
        raise ConfigurationError(
            f"{path}: the log has no column {', '.join(missing)}: an older version recorded it, "
            "and it cannot be replayed"
        )
    if not len(log.cycle):
        raise ConfigurationError(f"{path}: the log has no cycle: there is nothing to replay")
    return RecordedRun(folder, plan, log)


def other_version(folder: RunFolder) -> str | None:
    """Say which version recorded a run and which looks at it; None if it is the same."""
    git = folder.manifest.get("git")
    commit = None if git is None else str(git["commit"])
    then = _version(folder.manifest.get("versions", {}), commit)
    state = provenance.git_state()
    now = _version(provenance.versions(), None if state is None else state["commit"])
    return None if then == now else f"{then} recorded it, {now} replays it"


def _version(versions: Mapping[str, str], commit: str | None) -> str:
    at = "no checkout" if commit is None else f"commit {commit[:12]}"
    return f"rig {versions.get('rig-controller', 'of an unknown version')} ({at})"


def plan_of(folder: RunFolder, overrides: Sequence[str] = ()) -> Plan:
    """Return the plan that the files in a run folder lead to.

    Raises
    ------
    ConfigurationError
        A file is missing or not valid.
    """
    for name in (PROFILE, EXPERIMENT):
        if not (folder.path / name).is_file():
            raise ConfigurationError(f"{folder.path} has no {name}: it is not a whole run folder")
    if (folder.path / CODE).is_dir():
        given = ", ".join(sorted(path.name for path in (folder.path / CODE).iterdir()))
        raise ConfigurationError(
            f"{folder.path} ran code that was given from Python ({CODE}/: {given}): only a program "
            "that gives it again, with rig.run, can run it"
        )
    # Absolute, so that nothing in it is taken for a name that is looked for elsewhere.
    here = folder.path.resolve()
    return load_plan(here / EXPERIMENT, overrides, rig=str(here / PROFILE))
