"""Why a run ended as it did, and what to do about it."""

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, TypedDict, cast

from rig.config.names import is_path
from rig.explaining.exit_codes import EXIT_CODES
from rig.explaining.faults import FaultTopic, refusal_of, topic_of
from rig.hal import ConfigurationError
from rig.hal.formats import format_against
from rig.hal.hindsight import FLAWS, STRAYED
from rig.run_facts import (
    EVALUATION,
    MARGINS,
    UNTOLD,
    Manifest,
    RunStatus,
    has_moved,
    read_events,
    read_metrics,
)
from rig.run_folder import RunFolder

_DIAGNOSIS = "diagnosis"
_FELL = "fell"
_STOP = "stop"
_LOOKED_BACK = (_DIAGNOSIS, _FELL, *FLAWS, STRAYED, "camera", _STOP)
"""Kinds of events that say what a log told once its run had ended, or how it was stopped."""
_UNSAFE = "unsafe"
"""Kind of the events that say who is not known to be safe after a stop."""
_INJECTED = "injected"
"""Kind of the events that say what a simulation was to break."""
_WARNED = (
    "too fast",
    "is too fast",
    "leaves its path",
    "starts or stops",
    "ends early",
    "stands",
    "jumps",
    "has little room",
)
"""Kinds of remarks on a motion that may be why its run did not go well."""
_HELD_BACK = re.compile("stood at the end of limits")
_SEEN = ("oscillation", "stick_slip")
"""Kinds that a message tells because it was seen: a diagnosis only says what would fit as well."""
_RECENT = 10.0
"""A run that ended less long ago (s) is the one that whoever asks means."""
_UNITS = ((86_400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))
_ON = "--on hardware"
_CHECK = "rig check EXPERIMENT --rig RIG"
"""What looks at a motion before it runs: with all that the run's command has set."""
_PLACEHOLDER = re.compile(rf"\b(?:RIG|EXPERIMENT|RUN)\b|{_ON}")
_BREAKS = "simulation.faults"
"""Settings that plant a fault: they are told as injected."""
_WITHOUT_BUS = ("--on sim", "--on virtual")


class _Cause(TypedDict):
    sentence: str


class _Diagnosed(TypedDict, total=False):
    """The data of a diagnosis' event."""

    causes: list[_Cause]


class _Said(TypedDict):
    kind: str
    message: str


class _Foreseen(TypedDict, total=False):
    """The part of `evaluation.json` that was known of a motion beforehand."""

    facts: dict[str, object]
    remarks: list[_Said]


class Remark(NamedTuple):
    """A line of an explanation.

    Parameters
    ----------
    label : str
        One or two words.
    text : str
        A sentence or a few.
    """

    label: str
    text: str


def explain_run(folder: Path) -> list[Remark]:
    """Return why a run ended, the likeliest causes, and what finds and mends them.

    Raises
    ------
    ConfigurationError
        The folder is none of a run, or is damaged.
    """
    manifest = RunFolder.open(folder).manifest  # a process that died could not say so itself
    status, code = manifest["status"], manifest.get("exit_code")
    ended = status if code is None else f"{status}, exit code {code}"
    said = [Remark("run", f"{folder.name}: {ended}{age_since(manifest.get('ended'))}")]
    message = manifest.get("message")
    if message and status != RunStatus.FAILED:  # what it swings by is looked back at below
        said.append(Remark("message", message))
    if status in (RunStatus.FAULTED, RunStatus.CRASHED):
        from rig.explaining.fault_time import fault_time  # with numpy

        when = fault_time(folder)
        said += [Remark("when", when)] if when is not None else []
    if status in (RunStatus.FAULTED, RunStatus.CRASHED, RunStatus.FAILED):
        said += _given(manifest.get("command", []))
    said += [*_foreseen(folder), *_injected(folder), *_looked_back(folder)]
    unsafe = list(_messages(folder, _UNSAFE))
    wrongs = manifest.get("wrongs", [])
    said[1:1] = [Remark("not counted", left) for left in manifest.get("uncounted", [])]
    said[1:1] = [Remark("truth", wrong) for wrong in wrongs]  # what a campaign has judged it by
    said[1:1] = [Remark("not safe", sentence) for sentence in unsafe]  # before all else
    rig = _rig_of(folder) or manifest.get("rig")
    names = as_given(rig, manifest.get("experiment"), manifest.get("command", []))
    names |= {_ON: _on_option(manifest), _CHECK: _checked(manifest.get("command", []))}
    seen = [topic for kind in (_FELL, *FLAWS, _STOP) if (topic := _topic_of_event(folder, kind))]
    if status == RunStatus.FAILED:
        after = [remark for topic in seen for remark in _remarks(topic, folder, names)]
        return [*said, *_missed(folder), *(after or _after_missing(rig, folder, names))]
    if untold := _untold(folder):
        said.append(Remark("not told", untold))
        topic = refusal_of(untold)
        return [*said, *(_remarks(topic, folder, names) if topic else ())]
    if status == RunStatus.OK:
        if seen:
            return [*said, *_remarks(seen[0], folder, names)]
        means = "It went well; `rig report` draws it again."
        if wrongs:
            means = "The program took it for a run that went well, and the plant's truth says no."
        return [*said, Remark("means", means)]
    if status == RunStatus.ABORTED:
        means = "Somebody stopped it, and the rig was made safe."
        again = f"`rig report {folder.name}` draws what there is; the same command runs it anew."
        if not has_moved(folder):
            means = "Somebody stopped it before its first cycle: nothing was moved."
            again = "There is nothing to draw; the same command runs it anew."
        of = _remarks(seen[0], folder, names) if seen else ()
        return [*said, Remark("means", means), *(of or (Remark("next", again),))]
    told = [*_suspected(folder), _cause_in(message or "")]  # what looked longest knows best
    is_plain = _HELD_BACK.search(told[0]) is not None  # and no guess
    if message and (topic := topic_of(_cause_in(message))) is not None and topic.name in _SEEN:
        told = told if is_plain else told[::-1]
    told = [*_messages(folder, _FELL), *told]  # before it fell there was no other fault
    told[:0] = ["may not be safe"] if unsafe else []
    topics = dict.fromkeys(topic for sentence in told if (topic := topic_of(sentence)))
    if not topics:
        known = EXIT_CODES.get(str(code), "")
        means = f"{known} `rig export RUN --format csv` holds every quantity to the last cycle."
        return [*said, Remark("means", means.strip().replace("RUN", folder.name))]
    return [*said, *(remark for topic in topics for remark in _remarks(topic, folder, names))]


def _rig_of(folder: Path) -> str | None:
    """Return the file of a rig, if the run's experiment names one."""
    try:
        text = (folder / "experiment.yaml").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    found = re.search(r"^rig: (\S+)$", text, re.MULTILINE)
    return found[1] if found is not None and is_path(found[1]) else None


def as_given(
    rig: str | None, experiment: str | None, command: Sequence[str]
) -> dict[str, str | None]:
    """Return what a command line names a run's rig and experiment by: files as they were given."""
    if list(command[:2]) == ["rig", "run"]:
        for option, value in pairwise(command):
            if option in ("--rig", "run") and is_path(value):
                rig, experiment = (value, experiment) if option == "--rig" else (rig, value)
    return {"RIG": rig, "EXPERIMENT": experiment}


def _on_option(manifest: Manifest) -> str:
    """Return the option that names what a run was on."""
    command = manifest.get("command", [])
    said = [value for option, value in pairwise(command) if option == "--on"]
    on = said[-1] if said else manifest.get("backend", "hardware")
    return f"--on {shlex.quote(on)}"


def age_since(ended: str | None) -> str:
    """Return how long ago a run ended, if that is so long that another one may be meant."""
    try:
        ago = (datetime.now(UTC) - datetime.fromisoformat(ended or "")).total_seconds()
    except (ValueError, TypeError):  # nobody noted it, or without its zone
        return ""
    if ago < _RECENT:
        return ""
    size, unit = next((size, unit) for size, unit in _UNITS if ago >= size)
    return f", {ago / size:.0f} {unit} ago"


def _evaluation(folder: Path) -> _Foreseen:
    """Return what was known of a run beforehand; nothing of one that never began."""
    try:
        return RunFolder.open(folder).read_json(EVALUATION, _Foreseen)
    except (OSError, ConfigurationError):
        return {}


def _untold(folder: Path) -> str:
    """Return what `rig margins` has said of a run that told no loop; empty of any other."""
    try:
        return str(RunFolder.open(folder).read_json(MARGINS, dict[str, object]).get(UNTOLD, ""))
    except (OSError, ConfigurationError):
        return ""


def _foreseen(folder: Path) -> Iterator[Remark]:
    """Yield what `rig check` warns of, of the motion that was run."""
    for note in _evaluation(folder).get("remarks", ()):
        if note["kind"] in _WARNED:
            yield Remark("foreseen", f"{note['kind']}: {note['message']}")


def _injected(folder: Path) -> Iterator[Remark]:
    """Yield what a simulation broke of itself, and when on the log's clock."""
    for event in read_events(folder):
        if event.get("kind") == _INJECTED:
            t = event.get("t")
            when = "before the log's clock began"
            if t is not None:
                when = f"{t:.3f} s after the run began (the log's clock)"
            yield Remark("injected", f"{event['message']}, {when}")


def _messages(folder: Path, kind: str) -> Iterator[str]:
    return (event["message"] for event in read_events(folder) if event.get("kind") == kind)


def _given(command: Sequence[str]) -> Iterator[Remark]:
    """Yield what the command of a run set otherwise than its files do: look there first."""
    settings = [one for one in _settings(command) if not one.startswith(_BREAKS)]
    if settings:
        told = f"otherwise than the files by this run's command: {'; '.join(settings)}"
        yield Remark("set", f"{told}; taken back by `{_taken_back(command)}`")


def _settings(command: Sequence[str]) -> list[str]:
    return [after for word, after in pairwise(command) if word == "--set"]


def _taken_back(command: Sequence[str]) -> str:
    """Return a command line without its settings, but for those that plant a fault."""
    words, rest = [], iter(command)
    for word in rest:
        setting = next(rest, "") if word == "--set" else None
        if setting is None:
            words.append(word)
        elif setting.startswith(_BREAKS):
            words += [word, setting]
    return shlex.join(words)


def _checked(command: Sequence[str]) -> str:
    """Return `_CHECK` with the law and the settings of a run's command."""
    law = [after for word, after in pairwise(command) if word == "--controller"]
    settings = [*(f"controller={one}" for one in law), *_settings(command)]
    return shlex.join([*_CHECK.split(), *(word for one in settings for word in ("--set", one))])


def _topic_of_event(folder: Path, kind: str) -> FaultTopic | None:
    return topic_of(next(_messages(folder, kind), ""))


def _looked_back(folder: Path) -> list[Remark]:
    events = [(event.get("kind", ""), event) for event in read_events(folder)]
    return [Remark(kind, event["message"]) for kind, event in events if kind in _LOOKED_BACK]


def _cause_in(message: str) -> str:
    """Return a message without what it was before its cause was found: it ends in that."""
    head, found, _ = message.rpartition(" (")
    return head if found and message.endswith(")") and topic_of(head) is not None else message


def _suspected(folder: Path) -> list[str]:
    """Return what a diagnosis suspects, one sentence a cause; each is a kind of its own."""
    events = [event for event in read_events(folder) if event.get("kind") == _DIAGNOSIS]
    causes = [
        cause["sentence"]
        for event in events
        for cause in cast("_Diagnosed", event.get("data", {})).get("causes", ())
    ]
    return causes or [event["message"] for event in events]


def missed_bounds(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the bounds that a run missed: the measure's name and a sentence for each."""
    for row in read_metrics(folder):
        if row.get("pass") is not False:
            continue
        bound, value = row.get("bound"), row["value"]
        reached, limit = format_against(value, bound, row["unit"] or "1")
        wanted = f", {row.get('bound_kind') or 'bound'} {limit}" if limit else ""
        got = "has no value" if value is None else f"is {reached}"
        yield row.get("measure", row["name"]), f"{row['name']} {got}{wanted}"


def _missed(folder: Path) -> Iterator[Remark]:
    for measure, said in missed_bounds(folder):
        yield Remark("missed", f"{said}; `rig explain {measure}` says what it is")


def _after_missing(
    rig: str | None, folder: Path, names: Mapping[str, str | None]
) -> Iterator[Remark]:
    known = _evaluation(folder).get("facts", {})
    missed = [measure for measure, _ in missed_bounds(folder)]
    if missed and all(measure in known for measure in missed):
        yield Remark(
            "next",
            "What was missed is known before anything moves, and no rig changes it: another law, "
            "speed or bound does. `rig check` of the experiment shows what is foreseen.",
        )
        return
    topic = topic_of("a bound missed")
    assert topic is not None
    yield from _remarks(topic, folder, names)
    if rig is not None:
        yield Remark(
            "next",
            f"Is the rig as its profile says? `rig status {rig}` tells what of it is calibrated "
            f"and tuned, and what is next; `rig check {rig} --values` where each number is from.",
        )


def _remarks(topic: FaultTopic, folder: Path, names: Mapping[str, str | None]) -> Iterator[Remark]:
    known = {word: name for word, name in {**names, "RUN": folder.name}.items() if name}
    on = known.get(_ON, _ON)
    for label, written in topic.remarks():
        text = written.replace(_CHECK, known.get(_CHECK, _CHECK))
        if on in _WITHOUT_BUS and _ON in text:
            known[_ON] = _ON
            text += f" That is for the rig: this run was {on[2:]}, where no bus can be asked."
        yield Remark(label, _PLACEHOLDER.sub(lambda found: known.get(found[0], found[0]), text))
