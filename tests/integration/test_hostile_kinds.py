"""Every kind of file that a rig keeps, spoilt in a drawn way, under every command that reads it.

What holds for all: a sentence or the same as before, soon, in little memory, and nothing is written
or run elsewhere. Each case is a process of its own, so that one that hangs or fills the memory ends
itself.
"""

import contextlib
import io
import json
import os
import random
import shutil
from pathlib import Path

import pytest
import yaml
from attempts import attempt
from hostile_lab import OWN, READERS, make_lab
from mistakes import (
    PLACES,
    as_json,
    as_json_lines,
    as_sealed_yaml,
    replace,
    spoil_bytes,
    spoil_data,
    spoil_lines,
)

SLACK = 2.0  # s of the processor beyond what the healthy file takes
QUICK = (
    "calibration of before", "answers", "readings", "sweep", "journal", "twists", "latch", "urdf",
    "Denavit-Hartenberg", "eds",
)  # fmt: skip
PLANNED_ANEW = {"footprints": 12.0}  # s: other footprints are another walk, and the first is kept


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    lab = tmp_path_factory.mktemp("hostile") / "lab"
    lab.mkdir()
    make_lab(lab)
    return lab


def data_of(path, form):
    """Return what a healthy file says."""
    text = path.read_text()
    if form is as_json_lines:
        return [json.loads(line) for line in text.splitlines()]
    if form is as_json:
        return json.loads(text)
    content = yaml.safe_load(text)
    if form is as_sealed_yaml:
        content.pop("seal")
    return content


def spoil(path, form, chance, secret):
    """Spoil a file in a drawn way; return how, and whether it still bears a seal that fits."""
    kind = chance.choice(["bytes", "lines", "data", "data", "data", "place"])
    if kind == "place":
        what = chance.choice(PLACES)
        replace(path, what, secret)
        return what
    if kind == "data" and form is not None:
        path.write_bytes(form(spoil_data(data_of(path, form), chance)))
    elif kind == "lines":
        path.write_bytes(spoil_lines(path.read_text(errors="replace"), chance))
    else:
        path.write_bytes(spoil_bytes(path.read_bytes(), chance))
    return kind


def environment(folder):
    return {"XDG_STATE_HOME": str(folder / "state"), "XDG_CONFIG_HOME": str(folder / "state"),
            "COLUMNS": "200", "PWD": str(folder)}  # fmt: skip


def tried(call, folder, longest):
    return attempt(OWN.get(call, call), folder, longest, environment(folder))


def name_of(call):
    return call if isinstance(call, str) else " ".join(getattr(call, "words", ("watch",))[:5])


def warm(call, lab):
    """Import what a call imports, which is then no part of what each process does."""
    before, nobody = Path.cwd(), io.StringIO()
    os.chdir(lab)
    with contextlib.redirect_stdout(nobody), contextlib.redirect_stderr(nobody):
        OWN.get(call, call)()
    os.chdir(before)


@pytest.fixture(scope="module")
def healthy(lab, tmp_path_factory):
    """Return what comes of a call while nothing is spoilt; each is asked once."""
    known = {}
    folder = tmp_path_factory.mktemp("healthy") / "lab"

    def ask(call):
        if call not in known:
            for _ in range(2):
                shutil.rmtree(folder, ignore_errors=True)
                shutil.copytree(lab, folder, symlinks=True)
                if not known.get(call):
                    warm(call, folder)
                    known[call] = True
            known[call] = tried(call, folder, 60.0)
            assert known[call].trouble(60.0) is None, name_of(call)
        return known[call]

    return ask


def judge(kind, seed, lab, healthy, tmp_path):
    """Spoil a file and let somebody read it; return what is wrong with how that went."""
    chance = random.Random(f"{kind} {seed}")
    where, form, calls = READERS[kind]
    call = chance.choice(calls)
    before = healthy(call)
    outside = tmp_path / "outside"
    outside.mkdir(exist_ok=True)
    secret = outside / "secret"
    secret.write_text("root:*:20228:swordfish")
    folder = tmp_path / "lab"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(lab, folder, symlinks=True)
    how = spoil(folder / where, form, chance, secret)
    longest = before.spent + SLACK + PLANNED_ANEW.get(kind, 0.0)
    after = tried(call, folder, longest)
    wrong = after.trouble(longest)
    if wrong is None and secret.read_text() != "root:*:20228:swordfish":
        wrong = "a file outside is another"
    if wrong is None and [path.name for path in outside.iterdir()] != ["secret"]:
        wrong = "there is something outside that was not"
    if wrong is None and "swordfish" in after.out + after.err:
        wrong = "a file outside is quoted"
    if wrong is None and list(folder.rglob("PWNED")):
        wrong = "it was obeyed"
    return None if wrong is None else f"{kind}, seed {seed}, {how}: {name_of(call)}: {wrong}"


@pytest.mark.parametrize("kind", QUICK)
def test_a_spoilt_file_is_a_sentence(kind, lab, healthy, tmp_path):
    found = [judge(kind, seed, lab, healthy, tmp_path) for seed in range(2)]
    assert [wrong for wrong in found if wrong is not None] == []


@pytest.mark.slow
@pytest.mark.lengthy
@pytest.mark.parametrize("kind", READERS)
def test_many_spoilt_files_are_sentences(kind, lab, healthy, tmp_path):
    found = [judge(kind, seed, lab, healthy, tmp_path) for seed in range(60)]
    assert [wrong for wrong in found if wrong is not None] == []
