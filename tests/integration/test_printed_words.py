"""What the program prints beside names of files is explained, too: statuses, headings, buses."""

import ast
import itertools
import re
from enum import StrEnum
from pathlib import Path

import pytest

import rig
from rig.assembly.rig import Backend
from rig.cli import invoke
from rig.cli.command_table import COMMANDS
from rig.cli.loops import loop_table
from rig.cli.progress import _NAMES
from rig.doctor.look import Fitness
from rig.explaining.exit_codes import EXIT_CODES
from rig.explaining.faults import fault_topics, refusal_topics
from rig.explaining.glossary import glossary
from rig.explaining.report_words import report_word, report_words
from rig.faults.case import Moment
from rig.faults.kind import Must
from rig.run_facts import RunStatus
from rig.run_query import NAMES
from rig.runtime.states import RigState
from rig.sweeping.result import SweepEnd

ROOT = Path(rig.__file__).parents[1]
ENUMERATIONS: tuple[type[StrEnum], ...] = (
    RunStatus, RigState, Backend, SweepEnd, Fitness, Must, Moment,
)  # fmt: skip
PLAIN = {
    "what", "value", "description", "name", "now", "before", "from", "found", "file", "date",
    "said", "of", "greatest", "rms", "rms difference", "how", "quantity", "difference", "state",
    "bytes", "start", "end", "writes", "runs", "hours", "rig", "what happens",
    "what is expected", "value (SI)", "setting", "procedure", "event", "kind", "data",
    "A", "B", "change", "version", "says", "expects", "does", "operator", "valid until",
}  # fmt: skip
"""Headings that mean what they mean in a newspaper, or are said in the title above."""
ABBREVIATIONS = {
    "CAN", "SYNC", "PDO", "RPDO", "TPDO", "SDO", "NMT", "EMCY", "EDS", "CRC", "OPERATIONAL",
    "STOPPED", "BLF", "ASC", "MCAP", "URDF", "MISSED",
}  # fmt: skip
"""Those that messages have, beside placeholders of usage lines and everybody's (YAML, JSON)."""
ASKED = ("t", "aborted", "faulted", "infeasible", "hits", "SYNC", "PDO", "calibration", "rehearsal",
         "overlay", "digest", "calibrated: encoders", "TPDO1", "dead time", "reversal", "ensemble",
         "Stribeck", "told: before", "bears more dead time", "peak speed")  # fmt: skip


def texts(tree):
    """Yield the texts of a module, without its docstrings."""
    docs = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.value


def modules():
    for folder in ("rig", "drivers"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if "templates" not in path.parts:
                yield ast.parse(path.read_text())


def calls(name, position):
    """Yield the texts of an argument of all calls of a function: alone, or in a tuple or list."""
    for tree in modules():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call) or len(node.args) <= position:
                continue
            if getattr(node.func, "id", None) == name:
                argument = node.args[position]
                parts = argument.elts if isinstance(argument, ast.Tuple | ast.List) else [argument]
                for part in parts:
                    first = part.values[0] if isinstance(part, ast.JoinedStr) else part
                    if isinstance(first, ast.Constant) and isinstance(first.value, str):
                        yield first.value.strip()


@pytest.fixture(scope="module")
def known():
    """Return whether `rig explain` knows a word; without the cost of asking it 150 times."""
    names = {name for w in glossary() for name in (w.name, w.name.rpartition(".")[2])}
    topics = {topic.name for topic in (*fault_topics(), *refusal_topics())}
    others = {*names, *topics, *COMMANDS, *EXIT_CODES}
    return lambda word: report_word(word) is not None or word in others


def unknown(known, words):
    return sorted({word for word in words if not known(word)})


def test_every_status_and_phase_is_known(known):
    words = [*itertools.chain(*ENUMERATIONS), *_NAMES.values(), "unreadable", *EXIT_CODES]
    assert len(words) > 40
    assert unknown(known, words) == []


def test_every_heading_of_a_table_is_known(known):
    words = {*calls("Table", 1), *calls("table", 1), *NAMES, "run", "status", "metric"}
    assert len(words) > 40
    assert unknown(known, words - PLAIN) == []


def test_every_milestone_of_status_is_known(known):
    words = set(calls("Milestone", 0))
    assert {"computer", "commissioned", "calibrated:", "loop of"} <= words
    assert unknown(known, words) == []


def test_every_row_of_a_loop_and_of_a_tune_is_known(known):
    """Their names stand in the first column, not in a heading."""
    loop = {"stable": True, "crossover": 20.0, "phase": 0.8, "delay": 0.02, "sensitivity": 1.5}
    rows = {row[0] for row in loop_table("pid", loop).rows}
    source = next(t for t in modules() if "the most on any plant" in {*texts(t)})
    quiet = next(
        node.value for node in ast.walk(source)
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", None) == "quiet"
    )  # fmt: skip
    tuned = {row.elts[0].value for row in quiet.elts}
    assert {"lost plants", "hunting", "cost"} <= tuned and len(rows) == 5
    assert unknown(known, rows | tuned) == []


def test_every_abbreviation_of_buses_is_known(known):
    said = set()
    for tree in modules():
        for text in texts(tree):
            said |= {found[1] for found in re.finditer(r"(?<![\w.{])([A-Z]{3,})\d*(?![\w}])", text)}
    assert said >= ABBREVIATIONS  # each is printed somewhere
    assert unknown(known, ABBREVIATIONS) == []


def test_no_word_explains_itself_with_a_word_that_nobody_explains():
    told = " ".join(report_words().values())
    assert {w for w in re.findall(r"\b[A-Z]{3,}\b", told) if report_word(w) is None} <= {
        "UTC", "XML", "RIG", "RUN", "PRE",
    }  # fmt: skip


@pytest.mark.parametrize("word", ASKED)
def test_explain_says_it(word, capsys):
    assert invoke(["explain", word]) == 0
    told = report_word(word)
    assert capsys.readouterr().out.startswith(f"{told}: {report_words()[told][:20]}")


def test_a_word_that_is_also_a_command_a_fault_or_a_key_has_both(capsys):
    for word, other in (
        ("run", "rig run: "), ("margin", "kind: margin"), ("heartbeat", "buses.NAME.heartbeat"),
    ):  # fmt: skip
        assert invoke(["explain", word]) == 0
        out = capsys.readouterr().out
        assert report_words()[word][:20] in out
        assert other in out


def test_a_wrong_backend_is_told_the_nearest(capsys):
    with pytest.raises(rig.ConfigurationError, match="Did you mean sim"):
        rig.run("cylinder-sine", on="simm")
    assert invoke(["run", "cylinder-sine", "--on", "virtul"]) == 2
    assert capsys.readouterr().err.count("Did you mean virtual") == 1
