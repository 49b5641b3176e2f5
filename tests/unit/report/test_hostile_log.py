"""Logs whose columns somebody else has named: other programs open what is exported of them."""

import json
import random
import signal
import struct

import pytest

from rig.cli import invoke
from rig.hal import Column
from rig.hal.columns import check_columns
from rig.runtime.log import LogError, LogFile
from rig.runtime.mcap_file import COLUMNS_KEY
from rig.sweeping.table import guarded, unguarded

NAMES = ("=cmd|' /C calc'!A0", "@SUM(1)", "+1", "-1", "../../evil", "/etc/passwd", "a\x1b]0;x\x07",
         "a,b", "A", "a" * 300, "cycle", "a\n", "ä", "a.b.c", "")  # fmt: skip


def renamed(log, change):
    """Write a log's description of its columns anew; its lengths are mended."""
    content = log.read_bytes()
    columns = [list(column) for column in LogFile(log).columns]
    before = json.dumps(columns).encode()
    assert content.count(before) >= 1 and COLUMNS_KEY
    change(columns)
    after = json.dumps(columns).encode()
    place = content.index(before)
    grown = len(after) - len(before)
    head = content[:place]
    starts = [k for k in range(len(head)) if head[k] == 4]  # the Channel record's opcode
    for start in reversed(starts):
        (length,) = struct.unpack_from("<Q", content, start + 1)
        if start + 9 + length > place and length < 1 << 20 and start + 9 < place:
            break
    changed = bytearray(content[:place] + after + content[place + len(before) :])
    struct.pack_into("<Q", changed, start + 1, length + grown)
    (of_text,) = struct.unpack_from("<I", content, place - 4)
    struct.pack_into("<I", changed, place - 4, of_text + grown)
    # The map that holds the text says its length, too.
    for at in range(place - 5, start, -1):
        (size,) = struct.unpack_from("<I", content, at)
        if at + 4 + size == start + 9 + length:
            struct.pack_into("<I", changed, at, size + grown)
            break
    log.write_bytes(changed)


@pytest.mark.parametrize("format", ["csv", "npz", "mat", "parquet", "mcap"])
@pytest.mark.parametrize("name", NAMES)
def test_a_column_that_this_program_would_not_name_so_is_exported_nowhere(
    name, format, make_run, tmp_path, capsys
):
    run = make_run(duration=0.1)

    def change(columns):
        columns[random.Random(name).randrange(len(columns))][0] = name

    renamed(run / "log.mcap", change)
    assert invoke(["export", str(run), "--format", format, "--out", str(tmp_path / "out")]) == 2
    assert "is damaged where its columns are described" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_log_is_read_as_long_as_its_columns_are_ours(make_run):
    run = make_run(duration=0.1)

    def change(columns):
        columns[3][0] = "reading.quite_another_name"

    renamed(run / "log.mcap", change)
    assert LogFile(run / "log.mcap").columns[3].name == "reading.quite_another_name"


@pytest.mark.parametrize("place", [1, 2])
@pytest.mark.parametrize("text", ["\x1b]0;x\x07", "m\x00", "\x9b2J", "\u202em"])
def test_units_and_descriptions_are_lines_of_text(place, text):
    column = ["reading.position", "m", "where it is"]
    column[place] = text
    with pytest.raises(ValueError, match="no line of text"):
        check_columns([Column(*column)])


def test_a_hundred_thousand_columns_are_refused_at_once():
    columns = [Column(f"a{k}", "m", "") for k in range(100_000)]
    signal.setitimer(signal.ITIMER_REAL, 5.0)
    try:
        with pytest.raises(ValueError, match="100000 columns, expected at most"):
            check_columns(columns)
        check_columns(columns[:4096])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


@pytest.mark.parametrize("seed", range(40))
def test_a_damaged_head_of_a_log_is_a_sentence(seed, make_run, capsys):
    run, chance = make_run(duration=0.1), random.Random(seed)
    log = run / "log.mcap"
    content = bytearray(log.read_bytes())
    for _ in range(chance.choice((1, 1, 1, 8))):
        content[chance.randrange(min(len(content), 5000))] ^= 1 << chance.randrange(8)
    log.write_bytes(content)
    code = invoke(["export", str(run), "--format", "csv"])
    assert code in (0, 2) and "Traceback" not in capsys.readouterr().err
    try:
        LogFile(log)
    except LogError:
        assert code == 2


@pytest.mark.parametrize("text", ["=1+1", "+x", "-x", "@x", "\tx", "'=x", "''=x", "x", "", "'x"])
def test_a_cell_is_no_formula_and_comes_back(text):
    cell = guarded(text)
    assert cell[:1] not in ("=", "+", "-", "@", "\t", "\r")
    assert unguarded(cell) == text
    assert guarded(-1.5) == -1.5
