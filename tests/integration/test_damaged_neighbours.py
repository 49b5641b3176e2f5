"""A damaged or hostile file beside a rig's own is said, and stops nothing that does not need it."""

import json
import os
import random
import shutil
from pathlib import Path

import pytest
import yaml

from rig.calibration.store import load
from rig.cli import invoke
from rig.config.calibration import HISTORY, seal
from rig.hal import ConfigurationError
from rig.sweeping.journal import JOURNAL, Journal

COMMISSIONS = True
ROOT = Path(__file__).parents[2]
RECORD = {
    "rig": "cylinder", "valid_until": "2099-01-01", "backend": "hardware", "settings": "x",
    "digest": "12345678", "steps": {},
}  # fmt: skip
QUICK = (
    "--set", "reference={kind: step, size: 2 mm, dwell: 0.5 s, rise: 0.1 s, repeats: 1}",
    "--set", "approach=0.5 s",
)  # fmt: skip
BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{b}: &{b} [*{a}, *{a}, *{a}, *{a}, *{a}, *{a}, *{a}, *{a}, *{a}]\n"
    for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)


def sealed(content):
    return seal(yaml.safe_dump(content)).encode()


def texts(chance):
    """Return what may stand in a file, by what it is."""
    wrong = chance.choice([None, 7, [], "x", {"a": 1}, True, 1e300])
    key = chance.choice(["valid_until", "backend", "settings", "digest", "steps"])
    return {
        "nothing": b"",
        "noise": chance.randbytes(chance.randrange(1, 400)),
        "brackets": b"[" * 100_000,
        "sealed brackets": seal("a: " + "[" * 3000 + "]" * 3000 + "\n").encode(),
        "bomb": BOMB.encode(),
        "sealed bomb": seal(BOMB).encode(),
        "changed by hand": sealed(RECORD).replace(b"2099", b"2098"),
        "of another type": sealed({**RECORD, key: wrong if wrong != "x" or key == "steps" else 3}),
        "without a key": sealed({k: v for k, v in RECORD.items() if k != key}),
        "steps of another type": sealed({**RECORD, "steps": {"rest": wrong}}),
        "escapes": b"rig: \x1b]0;pwned\x07\n",
        "a scalar": seal("just text\n").encode(),
        "long": b"# " + b"x" * (2 << 20),
    }


@pytest.fixture(scope="module")
def configs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab") / "configs"
    shutil.copytree(ROOT / "configs", folder, ignore=shutil.ignore_patterns("commissioning"))
    (folder / "commissioning").mkdir()
    return folder


def put(path, what):
    path.unlink(missing_ok=True)
    if what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        path.symlink_to("/dev/zero")
    elif what == "loose link":
        path.symlink_to("nowhere")
    else:
        path.write_bytes(what)


@pytest.mark.parametrize("what", [*texts(random.Random(0)), "pipe", "device", "loose link"])
def test_a_record_of_commissioning(configs, tmp_path, monkeypatch, capsys, what):
    monkeypatch.chdir(tmp_path)
    path = configs / "commissioning" / "cylinder.yaml"
    put(path, texts(random.Random(what)).get(what, what))
    try:
        words = ["run", "cylinder-step", "--on", "sim", "--no-report", "--configs", str(configs)]
        assert invoke([*words, *QUICK]) in (0, 1), capsys.readouterr().err
        said = capsys.readouterr().err
        (events,) = Path("runs").glob("*/events.jsonl")
        assert "the record of its commissioning cannot be used" in events.read_text() + said
        assert "\x1b" not in said
        assert invoke(["status", "cylinder", "--configs", str(configs)]) == 0
        shown = " ".join(capsys.readouterr().out.split())
        assert "cannot be used" in shown.replace(" │ │ ", " ")
        assert invoke(["commission", "cylinder", "--on", "sim", "--configs", str(configs)]) == 2
    finally:
        path.unlink(missing_ok=True)


@pytest.mark.parametrize("seed", range(3))
def test_a_damaged_calibration_of_before_hides_no_other(configs, capsys, seed):
    chance = random.Random(seed)
    folder = configs / "calibration" / "cylinder" / HISTORY / "cylinder"
    folder.mkdir(parents=True, exist_ok=True)
    origin = {"date": "2026-01-01T00:00:00+00:00", "operator": "me"}
    good = {"target": "cylinder", "values": {}, "provenance": origin, "measured": []}
    try:
        (folder / "20260101.yaml").write_bytes(sealed(good))
        contents = texts(chance)
        for number, what in enumerate(chance.sample(sorted(contents), 3)):
            (folder / f"2025010{number + 1}.yaml").write_bytes(contents[what])
        code = invoke(["calibrate", "cylinder", "--history", "cylinder", "--configs", str(configs)])
        told = capsys.readouterr()
        assert code == 0, told.err
        assert told.err.count("cannot be used") == 3
        assert "20260101" in "".join(told.out.split())
    finally:
        shutil.rmtree(configs / "calibration")


@pytest.mark.parametrize("seed", range(12))
def test_a_journal_of_a_sweep(tmp_path, seed):
    chance = random.Random(seed)
    wrong = chance.choice([7, None, [], {}, "not hexadecimal", "0", True])
    key = chance.choice(["point", "status", "reason", "metrics"])
    good = {"point": "ab" * 16, "status": "ok", "reason": "", "metrics": []}
    line = chance.choice([
        json.dumps({**good, "point": wrong if key != "point" else "zz"}),
        json.dumps({**good, key: 1.5}), "[" * 100_000, "{}", "[]", '{"point": "\\ud800"}',
        chance.randbytes(30).hex(),
    ])  # fmt: skip
    (tmp_path / JOURNAL).write_text(line + "\n")
    with pytest.raises(ConfigurationError, match="is no journal of a sweep"):
        Journal(tmp_path)


@pytest.mark.parametrize("name", [JOURNAL, ".lock", ".spare"])
@pytest.mark.parametrize("what", ["link", "pipe", "device", "folder"])
def test_a_sweep_writes_into_no_file_of_others(tmp_path, name, what):
    """A torn line is cut off, and so would be all of a file without a line's end."""
    (tmp_path / "swept").mkdir()
    secret, there = tmp_path / "secret", tmp_path / "swept" / name
    secret.write_text("what is mine")
    if what == "folder":
        there.mkdir()
    elif what == "link":
        there.symlink_to(secret)
    else:
        put(there, what)
    with pytest.raises(ConfigurationError, match="swept"):
        Journal(tmp_path / "swept")
    assert secret.read_text() == "what is mine"


def test_a_journal_without_an_end_is_refused(tmp_path):
    with (tmp_path / JOURNAL).open("wb") as stream:
        stream.truncate(1 << 32)
    with pytest.raises(ConfigurationError, match="has more than 1048576 bytes"):
        Journal(tmp_path)


@pytest.mark.parametrize("what", ["pipe", "device", "loose link", "folder"])
def test_what_stands_in_the_place_of_a_calibration_is_no_missing_one(configs, capsys, what):
    path = configs / "calibration" / "cylinder" / "encoder-agonist.yaml"
    path.parent.mkdir(parents=True)
    try:
        path.mkdir() if what == "folder" else put(path, what)
        assert invoke(["check", "cylinder", "--configs", str(configs)]) == 2
        assert str(path) in capsys.readouterr().err
    finally:
        shutil.rmtree(configs / "calibration")


@pytest.mark.parametrize("seed", range(4))
def test_the_measurements_of_before_are_as_they_are_read_later(tmp_path, seed):
    chance = random.Random(seed)
    one = {"name": "scale", "value": 1.0, "std": 0.1, "unit": "1", "procedure": "encoders"}
    origin = {"date": "2026-01-01T00:00:00+00:00", "operator": "me", "residual_rms": 1e-6}
    key = chance.choice([*one, "residual_rms", "valid_until", "backend", "blocks"])
    wrong = chance.choice([[], {}, True, "x" if key in ("value", "std", "blocks") else 3.5])
    spoilt = dict(origin) if key in ("residual_rms", "blocks") else dict(one)
    spoilt[key] = [] if key in ("blocks", "value", "std", "residual_rms") else wrong
    content = {"values": {}, "measured": [one], "provenance": origin}
    place = "provenance" if key in ("residual_rms", "blocks") else "measured"
    content[place] = spoilt if place == "provenance" else [one, spoilt]
    path = tmp_path / "encoder.yaml"
    path.write_bytes(sealed(content))
    with pytest.raises(ConfigurationError, match=f"encoder.yaml: {place}.*{key} is "):
        load(path)


@pytest.mark.parametrize("kind", ["check", "calibration", "loop", "path"])
def test_no_link_has_an_error_quote_another_file(configs, tmp_path, capsys, kind):
    secret = tmp_path / "secret"
    secret.write_text("root:*:20228:swordfish\n")
    folder = configs / "calibration" / "cylinder"
    path = tmp_path / "mine.yaml"
    words = ["check", str(path), "--configs", str(configs)]
    if kind == "calibration":
        folder.mkdir(parents=True)
        path, words[1] = folder / "encoder-agonist.yaml", "cylinder"
    if kind == "path":
        content = yaml.safe_load((configs / "experiments" / "arm-path.yaml").read_text())
        reference = {"kind": "arm-path", "file": str(tmp_path / "places.csv")}
        path.write_text(yaml.safe_dump({**content, "reference": reference}))
        (tmp_path / "places.csv").symlink_to(secret)
    else:
        path.symlink_to(path.name if kind == "loop" else secret)
    try:
        assert invoke(words) == 2
        said = capsys.readouterr().err
        assert "swordfish" not in said
        assert (path.name if kind != "path" else "places.csv") in said, said
    finally:
        shutil.rmtree(configs / "calibration", ignore_errors=True)


@pytest.mark.parametrize("key", ["procedure", "backend"])
def test_a_history_of_other_types_is_no_traceback(configs, capsys, key):
    folder = configs / "calibration" / "cylinder" / HISTORY / "cylinder"
    folder.mkdir(parents=True)
    origin = {"date": "2026-01-01T00:00:00+00:00", "operator": "me", key: ["x"]}
    (folder / "20260101.yaml").write_bytes(sealed({"values": {}, "provenance": origin}))
    try:
        words = ["calibrate", "cylinder", "--history", "cylinder", "--configs", str(configs)]
        assert invoke(words) == 0
        assert f"{key} is ['x']" in capsys.readouterr().err
    finally:
        shutil.rmtree(configs / "calibration")
