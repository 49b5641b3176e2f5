"""A damaged or hostile file beside a rig's own is said, and stops nothing that does not need it."""

import json
import os
import random
import shutil
from pathlib import Path

import pytest
import yaml

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
    "--set", "reference.repeats=1", "--set", "reference.dwell=0.5 s", "--set", "approach=0.5 s",
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
