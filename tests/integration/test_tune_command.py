"""`rig tune` as a person uses it: from a rig to gains in force, broken off and gone on with."""

import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import load_profile
from rig.config.names import find_configs
from rig.tuning.attempt import last_attempt

QUICK = (
    "--controller", "pid", "--for", "cylinder-step", "--generations", "3",
    "--set", "plant.model=antagonistic-pair", "--set", "reference.dwell=1 s",
    "--set", "reference.rise=0.2 s",
)  # fmt: skip


@pytest.fixture
def place(tmp_path, monkeypatch):
    for folder in find_configs(None):
        shutil.copytree(folder, tmp_path / "configs", dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def start(*more):
    words = [sys.executable, "-m", "rig", "tune", "cylinder", *QUICK, "--configs", "configs", *more]
    return subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )  # fmt: skip


@pytest.mark.slow
def test_gains_are_found_put_in_force_and_the_same_however_often_it_was_broken_off(place):
    whole = start("--out", "whole", "--replace")
    table, said = whole.communicate(timeout=1500)
    assert whole.returncode == 0, said
    file = place / "configs" / "calibration" / "cylinder" / "controllers.pid.yaml"
    found = yaml.safe_load(file.read_text())["values"]
    used = load_profile("cylinder", REGISTRY, (), [place / "configs"]).controllers["pid"]
    assert used.proportional == found["proportional"]
    assert "tuned for cylinder-step: other motions may need other gains" in said
    assert "on every plant of the ensemble, before and now …" in said
    assert re.search(r"^\d+/\d+ plants, \d+ \w+ left$", said, re.MULTILINE), said
    assert "the progress line counts these trials" in said and "shake 20 drawn plants each" in said
    assert ", 0 running" not in said and " 0 left" not in said
    last = said.rstrip().splitlines()[-1]
    assert last.startswith("in short: ") and last.endswith(": put in force"), last
    for word in ("error, step", "reversals", "drawn plants", "proportional"):
        assert word in table
    (figure,) = (place / "whole").glob("*/tuning.png")
    assert figure.stat().st_size > 10_000
    attempt = last_attempt(place / "whole", "cylinder")
    assert attempt is not None and attempt.law == "pid" and attempt.is_put
    shutil.rmtree(place / "configs" / "calibration")

    drawn = random.Random(4242)
    for kill in (signal.SIGINT, signal.SIGKILL):
        broken = start("--out", "broken", "--replace", "--workers", "1")
        journal = None
        wanted = drawn.randrange(3, 30)
        while broken.poll() is None:
            journal = journal or next((place / "broken").glob("*/points.jsonl"), None)
            if journal is not None and journal.read_bytes().count(b"\n") >= wanted:
                break
            time.sleep(0.05)
        broken.send_signal(kill)
        _, said = broken.communicate(timeout=60)
        if kill is signal.SIGINT:
            assert broken.returncode == 130, said
            assert "the same command goes on" in said
        assert not file.exists()
        time.sleep(1.0)  # its workers end with it
    again = start("--out", "broken", "--replace")
    _, said = again.communicate(timeout=1500)
    assert again.returncode == 0, said
    assert yaml.safe_load(file.read_text())["values"] == found


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("tune", "cylindre"), "cylinder"),
        (("tune", "cylinder", "--controller", "pidd"), "it has pid"),
        (("tune", "joint-ideal", "--controller", "joint-cascade"), "has no controller"),
        (("tune", "joint-ideal"), "dither.amplitude and path_dither.force have to be 0"),
        (("tune", "arm", "--controller", "esc"), "tuned"),
        (("tune", "cylinder", "--for", "arm-wrist-hit"), "cylinder"),
        (("tune", "cylinder", "--set", "plant.model=spherical-joint"), "plant"),
        (("tune", "cylinder", "--generations", "0"), "generations"),
    ],
)
def test_what_cannot_be_tuned_is_a_sentence(words, said, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke(list(words)) == 2
    err = capfd.readouterr().err
    assert said in err, err
    assert not re.search("Traceback|bug in rig", err), err
    assert not list(tmp_path.iterdir())
