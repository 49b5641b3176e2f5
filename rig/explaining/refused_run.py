"""The last command that was refused: it left no run folder, and is what somebody asks about."""

import contextlib
import os
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple, TypedDict

from rig.explaining.ended_run import Remark, age_since
from rig.explaining.faults import FaultTopic, refusal_of, topic_of
from rig.hal import ConfigurationError
from rig.hal.files import users_folder
from rig.json_file import write_json
from rig.run_facts import read_manifest
from rig.run_names import RUNS, list_runs
from rig.typed_json import read_json

REFUSED = (2, 3)
"""Exit codes of a run that was refused: usage or configuration, device or preflight."""
_OPTIONS = ("--out", "--runs")
_MOST = 50
"""So many folders have their last refusal kept."""
_MEANS = {
    2: "A file, an option or code of yours is wrong. Nothing was run, and nothing has moved.",
    3: "A device or the preflight says no. Nothing was energised.",
}


class _Kept(TypedDict):
    """A refusal in the file, by the folder of runs that it would have gone to."""

    command: list[str]
    code: int
    message: str
    when: str


class RefusedRun(NamedTuple):
    """A run that was refused.

    Parameters
    ----------
    command : tuple of str
        The words of its command line after ``rig``.
    code : int
        Its exit code.
    message : str
        What was said.
    when : str
        UTC, ISO 8601.
    """

    command: tuple[str, ...]
    code: int
    message: str
    when: str

    def remarks(self, before: Path | None) -> list[Remark]:
        """Return why it was refused, and what to do.

        Parameters
        ----------
        before : Path, optional
            The newest run that there is.
        """
        line = shlex.join(("rig", *self.command))
        is_step = self.command[:1] == ("commission",) and self.code == 3
        label, left = ("stopped", "") if is_step else ("refused", ", no run folder")
        told = [
            Remark(label, f"`{line}`: exit code {self.code}{left}{age_since(self.when)}"),
            Remark("message", self.message),
        ]
        topic = step_topic(self.message) if is_step else self._topic()
        if topic is not None:
            told += [Remark(*pair) for pair in topic.remarks()]
        else:
            told.append(Remark("means", _MEANS[self.code]))
            told.append(Remark("next", "Mend what the message names, and run it again."))
        if before is not None:
            told.append(
                Remark("before", f"The run before it: `rig explain {before}` explains that one.")
            )
        return told

    def _topic(self) -> FaultTopic | None:
        tellers = (topic_of, refusal_of) if self.code == 3 else (refusal_of,)
        return next((found for tell in tellers if (found := tell(self.message))), None)


def step_topic(message: str) -> FaultTopic | None:
    """Return what is known of what a step of the acceptance test has found.

    Which kind of fault it is says most, but for kinds that speak of laws and limits.
    """
    of_steps, fault = refusal_of(message), topic_of(message)
    if of_steps is not None and of_steps.name == "step_setpoint":
        return of_steps
    return of_steps if fault is None or fault.name in ("out_of_range", "command") else fault


def keep_refusal(words: Sequence[str], code: int, message: str, began: float) -> None:
    """Keep what a command was refused with; the one before, of the same runs, is forgotten.

    It is a convenience: where it cannot be kept, nothing is said of that. A run that has left a
    folder and ended by somebody's code is none: its folder says what happened.

    Parameters
    ----------
    words : sequence of str
        The command line after ``rig``.
    code : int
        The exit code.
    message : str
        What was said.
    began : float
        When the command was given, s since the epoch.
    """
    runs = _runs_of(words)
    since = datetime.fromtimestamp(began, UTC).isoformat(timespec="milliseconds")
    with contextlib.suppress(ConfigurationError):
        if any(read_manifest(run).get("started", "") >= since for run in list_runs(runs)[:1]):
            return
    kept: _Kept = {
        "command": list(words),
        "code": code,
        "message": message,
        "when": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }
    path = _path()
    others = _kept()
    others.pop(_key(runs), None)
    newest = dict([*others.items(), (_key(runs), kept)][-_MOST:])
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, newest)


def _kept() -> dict[str, _Kept]:
    """Return what is kept; nothing if nobody was refused, or somebody has spoilt it."""
    try:
        return read_json(_path(), dict[str, _Kept])
    except (ConfigurationError, OSError):
        return {}


def last_refusal(runs: Path) -> tuple[RefusedRun | None, Path | None]:
    """Return the refusal that is newer than every run in a folder, and the newest run there.

    Parameters
    ----------
    runs : Path
        Where run folders live.

    Raises
    ------
    ConfigurationError
        The folder cannot be read.
    """
    newest = next(iter(list_runs(runs)), None)
    kept = _kept().get(_key(runs))
    if kept is None or kept["code"] not in REFUSED:
        return None, newest
    if newest is not None and read_manifest(newest).get("started", "") >= kept["when"]:
        return None, newest
    refusal = RefusedRun(tuple(kept["command"]), kept["code"], kept["message"], kept["when"])
    return refusal, newest


def _key(runs: Path) -> str:
    """Return the one name of a folder of runs, however a command line spells it."""
    return os.path.realpath(runs)


def _path() -> Path:
    return users_folder("XDG_STATE_HOME", ".local", "state") / "rig" / "refused.json"


def _runs_of(words: Sequence[str]) -> Path:
    """Return where a command line would have put its run; click may not have come so far."""
    found = RUNS
    options = _OPTIONS if words[:1] == ["run"] else _OPTIONS[1:]  # another's --out may be a file
    for place, word in enumerate(words):
        name, sign, value = word.partition("=")
        if name in options and sign:
            found = Path(value)
        elif word in options and place + 1 < len(words):
            found = Path(words[place + 1])
    return found
