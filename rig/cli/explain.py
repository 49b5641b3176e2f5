"""`rig explain`: what a word of a file or a report means, and why a run stopped."""

from __future__ import annotations

import difflib
import re
import shlex
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    complete_rig,
    complete_run,
    configs_option,
    json_option,
    runs_option,
)
from rig.cli.tables import print_data, print_json
from rig.run_names import LATEST, find_run, folder_of_latest

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.explaining.glossary import Word

_MOST = 12
"""More meanings of one word than this are counted, and told by their full names."""
_WIDTH = 96
_LEAST = 3
"""Letters of a part of a word by which a package is known."""
_GROUPS = ("reading", "estimate", "applied", "device", "truth")
"""Of the columns of logs."""


@click.command()
@click.argument("word", default=LATEST, shell_complete=complete_run)
@runs_option
@click.option(
    "--rig", "rig", metavar="PROFILE", shell_complete=complete_rig,
    help="Also the columns of its log, and what the packages of others say that it names.",
)  # fmt: skip
@configs_option
@json_option
def explain(word: str, runs: Path, rig: str | None, configs: Path | None, as_json: bool) -> int:
    """Say what WORD means, or why a run stopped and what to do; default: the newest run.

    WORD is a key of a profile, an experiment, a sweep or a scenario of faults (`loop.rate`, or
    `rate` alone), a measure, a figure, a law, a driver, a kind of motion, a plant, a column of a
    log, a command, an exit code, a kind of fault, a message of this program in quotes, or a run.
    Without WORD, a `rig run` that was refused since the newest run is what is told.
    """
    profile: Profile | None = None
    if rig is not None:
        from rig.assembly import REGISTRY
        from rig.config import find_configs, load_profile

        profile = load_profile(rig, REGISTRY, (), find_configs(configs))
    told = _explain(word, runs, profile, configs)
    if as_json:
        print_json([{"label": label, "text": text} for label, text in told])
    else:
        print_data("\n".join(_line(label, text) for label, text in told))
    return 0


def _line(label: str, text: str) -> str:
    if "\n" in text:  # an error of a file: its caret stands below what it means
        return f"{label}: {text}".replace("\n", "\n  ")
    # A name with hyphens stays whole: it is copied into the next command.
    return textwrap.fill(
        f"{label}: {text}", _WIDTH, subsequent_indent="  ", break_on_hyphens=False,
        break_long_words=False,
    )  # fmt: skip


def _explain(
    word: str, runs: Path, profile: Profile | None, configs: Path | None
) -> Sequence[tuple[str, str]]:
    from rig.explaining.ended_run import explain_run
    from rig.explaining.faults import refusal_of, topic_of
    from rig.hal import ConfigurationError
    from rig.hal.files import is_folder

    if (latest := folder_of_latest(word, runs)) is not None:
        word, runs = LATEST, latest
        from rig.explaining.refused_run import last_refusal

        refusal, newest = last_refusal(runs)
        if refusal is not None:
            return refusal.remarks(newest)
    if word == LATEST or is_folder(runs / word) or _is_path_of_run(word):
        return explain_run(find_run(word, runs))
    known = _known(word) or _known(_OWN_NAME.sub(r"\1.NAME.\2", word))
    if known:
        return known
    from rig.explaining.columns import columns_called

    if columns := columns_called(word, profile, runs):
        return [(_title(column), column.text) for column in columns]
    if of_file := _name_of_file(word, configs):
        return [of_file]
    if " " in word.strip():
        # What `rig` refuses begins with the word; what stops a run may say the same of a motion.
        tellers = (topic_of, refusal_of)[:: -1 if word.lstrip().lower().startswith("error:") else 1]
        for topic in (tell(word) for tell in tellers):
            if topic is not None:
                return topic.remarks()
    if " " not in word.strip() and "/" in word and is_folder(Path(word).parent):
        raise ConfigurationError(f"there is no run {word}; `rig list runs` shows what is kept")
    if word.partition(".")[0] in _GROUPS:
        raise ConfigurationError(
            f"neither a key nor a column of the newest run's log is called {word!r}; --rig PROFILE "
            "knows the columns of that rig, `rig export RUN --format csv` shows those of a run"
        )
    raise ConfigurationError(f"nothing is called {word!r}; {_hint(word, configs, profile)}")


def _name_of_file(word: str, configs: Path | None) -> tuple[str, str] | None:
    """Return what tells of a rig or an experiment that is called so; None: none is."""
    from rig.config import find_configs
    from rig.config.names import list_files

    search = find_configs(configs)
    rigs, experiments = (list_files(kind, search) for kind in ("rigs", "experiments"))
    if word in rigs:
        return f"{word} (rig)", (
            f"`rig check {word}` shows what its profile says, `rig status {word}` how far it has "
            f"come; the file is {rigs[word]}"
        )
    if word in experiments:
        return f"{word} (experiment)", (
            f"`rig check {word}` shows its motion, bounds and loop; the file is {experiments[word]}"
        )
    return None


def _hint(word: str, configs: Path | None, profile: Profile | None) -> str:
    """Return where a word may be known, or which one is like it.

    What is like a known word is a slip, unless a package that no profile has named is called so.
    """
    from rig.assembly import REGISTRY
    from rig.config import find_configs
    from rig.config.law_hint import profiles_with_law

    search = find_configs(configs)
    profiles = () if profile is not None else profiles_with_law(word, search)
    if profiles := profiles or (() if profile is not None else _files_with(word, search)):
        what = f"{shlex.quote(word)} --rig {shlex.quote(profiles[0])}"
        return f"a profile has a law or a driver of that name: rig explain {what}"
    near = difflib.get_close_matches(word, _names(), n=3)
    unnamed = () if profile is not None else REGISTRY.unnamed()
    parts = [part for part in re.split(r"[-_.]", word.lower()) if len(part) >= _LEAST]
    if near and not any(part in name.lower() for name in unnamed for part in parts):
        return f"did you mean {' or '.join(near)}?"
    if unnamed:
        return (
            f"what packages of others call so is told by: rig explain {shlex.quote(word)} --rig "
            f"PROFILE; a profile's additions: [NAME] lets a package take part: {', '.join(unnamed)}"
        )
    return "`rig explain --help` says what it knows"


def _files_with(word: str, search: Sequence[Path]) -> tuple[str, ...]:
    """Return the profiles in the working folder with a law or a driver of a name; no code runs."""
    from rig.cli.files_here import files_here
    from rig.config.document import plain_under

    found = []
    for file in files_here(["rigs"], search):
        laws, devices = (
            plain_under(k, Path(file), "rigs", search) for k in ("controllers", "devices")
        )
        entries = devices.values() if isinstance(devices, dict) else ()
        drivers = [entry.get("driver") for entry in entries if isinstance(entry, dict)]
        if (isinstance(laws, dict) and word in laws) or word in drivers:
            found.append(file)
    return tuple(found)


def _is_path_of_run(word: str) -> bool:
    """Return whether a word is a path; a folder here that has the name of a key is no run."""
    from rig.hal.files import is_file, is_folder
    from rig.run_facts import MANIFEST

    path = Path(word)
    return is_folder(path) and ("/" in word or is_file(path / MANIFEST))


_OWN_NAME = re.compile(r"^(devices|buses|controllers|metrics)\.[^.]+\.(.+)$")
"""A key as `--set` and `rig check --values` have it, by the name that somebody gave."""
_LOWER = ".min"
"""Behind the name of a metric: its lower bound."""


def _known(word: str) -> Sequence[tuple[str, str]]:
    """Return what is known of a word: its own meanings, or those of the keys that end with it."""
    from rig.cli.command_table import COMMANDS
    from rig.explaining.exit_codes import EXIT_CODES
    from rig.explaining.faults import fault_topics, refusal_topics
    from rig.explaining.report_words import report_word, report_words

    if word.endswith(_LOWER):  # of a metric with both bounds
        return _known(word.removesuffix(_LOWER))
    told = report_word(word)
    said = [] if told is None else [(told, report_words()[told])]
    for topic in (*fault_topics(), *refusal_topics()):
        if topic.name == word:
            from rig.explaining.glossary import without_keys

            measures = [w for w in without_keys() if w.name == word]
            return [*topic.remarks(), *said, *((_title(w), w.text) for w in measures)]
    if word in COMMANDS:
        return [(f"rig {word}", f"{COMMANDS[word][1]} `rig {word} --help` says more."), *said]
    if word in EXIT_CODES:
        return [(f"exit code {word}", EXIT_CODES[word])]
    return [*said, *_names_of_code(word, is_told=told is not None)]


def _names_of_code(word: str, *, is_told: bool) -> Sequence[tuple[str, str]]:
    """Return the keys, parts, laws, measures and figures of a name, or those that end with it."""
    from rig.explaining.glossary import (  # imports every law and measure
        glossary,
        without_keys,
    )

    found = [w for w in without_keys() if w.name == word]
    if not found or _is_part(word):
        words = glossary()
        found = [w for w in words if w.name == word]
        if not any(w.kind.endswith("key") for w in found):  # parts and figures hide no key
            found += [w for w in words if w.name.endswith(f".{word}")]
        found = found or ([] if is_told else _metric(word, words))
    if len(found) > _MOST:
        names = sorted({w.name for w in found})
        return [(word, f"{len(names)} keys end so; say which: {', '.join(names)}")]
    return [(_title(w), w.text + (f" Default: {w.default}." if w.default else "")) for w in found]


def _is_part(word: str) -> bool:
    from rig.assembly import REGISTRY
    from rig.explaining.glossary import PARTS

    return any(word in REGISTRY.imported(kind) for kind, _ in PARTS.values())


def _metric(word: str, words: Sequence[Word]) -> list[Word]:
    """Return the measure of a metric that an experiment names after it: `tracking_rms_0.1hz`."""
    base = word
    while "_" in base:
        base = base.rpartition("_")[0]
        found = [w for w in words if w.name == base and w.kind.endswith("measure")]
        if found:
            part = word.removeprefix(f"{base}_")
            return [
                w._replace(text=f"{w.text}; here of the stretch {part!r}, as the experiment says")
                for w in found
            ]
    return []


def _title(word: Word) -> str:
    return f"{word.name} ({word.kind}{f' of {word.of}' if word.of else ''})"


def _names() -> list[str]:
    from rig.cli.command_table import COMMANDS
    from rig.explaining.faults import fault_topics, refusal_topics
    from rig.explaining.glossary import glossary
    from rig.explaining.report_words import report_words

    names = {name for w in glossary() for name in (w.name, w.name.rpartition(".")[2])}
    topics = (*fault_topics(), *refusal_topics())
    return sorted({*names, *COMMANDS, *report_words(), *(topic.name for topic in topics)})
