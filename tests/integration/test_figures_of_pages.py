"""A number of the page of figures is written by a command, or stands beside what it comes from."""

import importlib.util
import re
import sys

import pytest
from shown_commands import ROOT

PAGE = ROOT / ".readme" / "figures.md"
_SPEC = importlib.util.spec_from_file_location("figures_of_pages", ROOT / ".readme/figures.py")
FIGURES = importlib.util.module_from_spec(_SPEC)
sys.modules[_SPEC.name] = FIGURES  # where its tuples look for their own module
_SPEC.loader.exec_module(FIGURES)
MARKED = re.compile(r"<!--= [^>]+? -->\d+(?:\.\d+)?")
DECIMAL = re.compile(r"(?<![\w.])\d+\.\d+")
COMMAND = re.compile(r"`(?:rig|python|pytest|test_\w+\.py)\b[^`]*`")
MEASURED = re.compile(r"`rig (?:run|sweep|compare) ")
"""What `figures.py` can make again."""


def claims():
    """Return each command of a marker with what pages say that it makes."""
    found = {}
    for page in FIGURES.PAGES:
        for place, claim in FIGURES.claims(page.read_text()):
            found.setdefault(claim.command, []).append((place["number"], claim))
    return found


def cases():
    """Return the commands; a sweep takes minutes of processor time, a run seconds."""
    for command, said in claims().items():
        lengthy = [pytest.mark.lengthy] if command.startswith("rig sweep") else []
        yield pytest.param(command, said, id=command, marks=lengthy)


@pytest.mark.slow
@pytest.mark.sampled(3)
@pytest.mark.parametrize(("command", "said"), [*cases()])
def test_figures_are_what_their_command_makes(command, said, tmp_path):
    rows = FIGURES.made(command, tmp_path)
    for number, claim in said:
        decimals = len(number.partition(".")[2])
        assert f"{FIGURES.value_of(claim, rows):.{decimals}f}" == number, claim
    ended = {row["variation"]: row["status"] for row in rows if row.get("variation")}
    for name in stopped(command):
        assert ended.get(name, "faulted") == "faulted", name  # rows may be no variations


def stopped(command):
    """Return the variations of a sweep that its table says are stopped."""
    for block, _ in blocks():
        if f"<!--= {command};" in block:
            yield from re.findall(r"^\| (.+?) \| stopped: ", block, re.MULTILINE)


def blocks():
    """Return the paragraphs and tables of the page, each with the paragraph before it."""
    before = ""
    for block in re.split(r"\n\n+", PAGE.read_text()):
        if block.startswith("#"):
            before = ""
        elif not block.startswith("!["):
            yield block, before
            if not block.startswith("|"):
                before = block


def cells(table):
    """Return the cells of a table that say what was measured, each with its row and its head."""
    head, _, *rows = table.splitlines()
    for row in rows:
        for cell in row.strip("|").split("|")[1:]:
            yield MARKED.sub("", cell), row, head


def test_what_a_run_measures_has_a_marker_in_every_table():
    bare = []
    for block, before in blocks():
        if block.startswith("|"):
            for cell, row, head in cells(block):
                beside = [*COMMAND.findall(before), *COMMAND.findall(head), *COMMAND.findall(row)]
                is_made = not beside or MEASURED.match(beside[-1])
                if DECIMAL.search(cell) and is_made:
                    bare.append((cell.strip(), row[:60]))
    assert bare == []


def test_every_paragraph_with_figures_has_what_they_come_from():
    bare = [
        block
        for block, before in blocks()
        if not block.startswith("|")
        and DECIMAL.search(re.sub(r"`[^`]*`", "", MARKED.sub("", block)))
        and not COMMAND.search(block) and not COMMAND.search(before)
    ]  # fmt: skip
    assert bare == []
