"""Write reference.md: every command, key, law, measure, figure, exit code and kind of fault.

``python .readme/reference.py`` writes it; ``--check`` says whether it is what the code says.
"""

import sys
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

from rig.cli.command_table import COMMANDS
from rig.explaining.faults import fault_topics, refusal_topics
from rig.explaining.glossary import PARTS, Word, glossary

PAGE = Path(__file__).with_name("reference.md")
_ORDER = (
    "exit code", "experiment key", "profile key", "sweep key", "fault scenario key",
    *PARTS, "control law", "measure", "planned measure", "figure",
)  # fmt: skip
_TITLES = {
    "exit code": "Exit codes",
    "experiment key": "Experiment files",
    "profile key": "Profiles",
    "sweep key": "Sweep files",
    "fault scenario key": "Scenarios of `rig faults run FILE`",
    "motion": "Motions: `reference.kind`",
    "driver": "Drivers: `devices.NAME.driver`",
    "mechanism": "Mechanisms",
    "plant": "Plants: `plant.model`",
    "protocol": "Protocols: `buses.NAME.protocol`",
    "control law": "Control laws",
    "measure": "Measures",
    "planned measure": "Planned measures: known before anything moves",
    "figure": "Figures",
}
_INTRODUCTION = """\
# Reference

Made by `python .readme/reference.py` from the code; a test holds it to it. `rig explain WORD` says
the same in a terminal. Numbers in files carry their unit (`35 kPa`); defaults are in SI.

## Commands

`rig COMMAND --help` has the options. Every command takes `--json`: what it found is then all that
is on stdout, as JSON (a line for each frame of `rig monitor`), and words are on stderr; an error is
`{"error": …, "exit": …}` there. The folder
of runs is `--out` or `--runs`, whichever comes to mind; `rig export`, `rerun` and `replay` look for
a run in `--runs`, and write what `--out` says.

Rigs, experiments, calibrations, tuned gains and acceptance records are read from the folder
`configs` where you work, then from the program's own. They are written into the first alone, which
is made if there is none; nothing is written into the program's. `--configs FOLDER` is the only one,
for both. `rig new` writes a rig or an experiment where you work, and every command takes its path.
"""


def page() -> str:
    """Return the whole page."""
    commands = [(f"`rig {name}`", text) for name, (_, text) in COMMANDS.items()]
    parts = [_INTRODUCTION, *_table(("command", "what it does"), commands)]
    words = glossary()
    for kind in _ORDER:
        parts += ["", f"## {_TITLES[kind]}"]
        parts += _sections(kind, [word for word in words if word.kind == kind])
    parts += ["", "## Faults", "", "What a message means; `rig explain RUN` looks it up.", ""]
    rows = [(f"`{t.name}`", t.means, t.causes, t.check, t.mend) for t in fault_topics()]
    parts += _table(("kind", "means", "usual causes", "check", "mend"), rows)
    parts += ["", "## Refusals", "", "Why a command ends with 2 before anything moves.", ""]
    rows = [(f"`{t.name}`", t.means, t.causes, t.check, t.mend) for t in refusal_topics()]
    parts += _table(("kind", "means", "usual causes", "check", "mend"), rows)
    return "\n".join(parts) + "\n"


def _sections(kind: str, words: list[Word]) -> Iterator[str]:
    def place(word: Word) -> tuple[str, str]:
        return word.name.partition(".")[0] if kind.endswith("key") and word.of else "", word.of

    if kind == "exit code":
        yield ""
        yield from _table(("code", "meaning"), [(f"`{w.name}`", w.text) for w in words])
        return
    for (section, of), group in groupby(words, place):
        title = (
            " of ".join(filter(None, (f"`{section}`" if section else "", of))) or "of every file"
        )
        yield from ("", f"### {title}", "") if of or kind not in PARTS else ("",)
        rows = [(f"`{w.name}`", w.text, f"`{w.default}`" if w.default else "") for w in group]
        if any(default for _, _, default in rows):
            yield from _table(("name", "meaning", "default"), rows)
        else:
            yield from _table(("name", "meaning"), [row[:2] for row in rows])


def _table(header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    yield "| " + " | ".join(header) + " |"
    yield "|" + "---|" * len(header)
    for row in rows:
        yield "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) + " |"


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        sys.exit(PAGE.read_text() != page())
    PAGE.write_text(page())
