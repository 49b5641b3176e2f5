"""Nothing of another package runs for a command whose profile does not name it."""

import json
import os
import sys
from pathlib import Path

import pytest
from stranger_lab import ROOT, beside_the_source

from rig.assembly import offered
from rig.cli import invoke
from rig.cli.command_table import COMMANDS

GROUPS = ("rig.mechanisms", "rig.drivers", "rig.protocols", "rig.additions")
PROJECT = {
    "name": "sly",
    "version": "6.6",
    "entry-points": {group: {"sly": "sly.parts:PARTS"} for group in GROUPS},
}
MARK = "sly-was-here"
CODE = """\
import os, pathlib
pathlib.Path(os.environ["SLY_MARK"]).write_text("ran")
"""
PARTS = """\
from rig.hal.parts import Additions
PARTS = Additions(mechanism="cylinder", measures=("sly_more:MEASURES",))
"""
QUICK = (
    "--set", "reference={kind: step, size: 2 mm, dwell: 0.5 s, rise: 0.1 s, repeats: 1}",
    "--set", "approach=0.5 s", "--set", "figures=[timing]",
)  # fmt: skip
COMMAND_LINES = {
    "run": ["run", "cylinder-step", "--on", "sim", "--no-report", *QUICK],
    "check": ["check", "cylinder-step"],
    "compare": ["compare", "cylinder-step", "--on", "sim", "--controllers", "pid,cascade", *QUICK],
    "sweep": ["sweep", "cylinder-step", "--seeds", "0:2", "--workers", "1", *QUICK],
    "diff": ["diff", "latest", "latest"],
    "explain": ["explain", "loop.rate"],
    "export": ["export", "latest", "--format", "csv"],
    "replay": ["replay", "latest"],
    "report": ["report", "latest"],
    "rerun": ["rerun", "latest"],
    "list": ["list"],
    "watch": ["watch", "no-such-run"],
    "stop": ["stop"],
    "faults": ["faults", "list", "cylinder"],
    "doctor": ["doctor", "cylinder"],
    "status": ["status", "cylinder"],
    "calibrate": ["calibrate", "cylinder"],
    "commission": ["commission", "cylinder", "--dry-run"],
    "monitor": ["monitor", "cylinder", "--frames", "latest"],
    "new": ["new", "experiment", "mine", "--rig", "cylinder"],
    "schema": ["schema", "profile"],
    "completion": ["completion", "bash"],
    "reset": ["reset", "cylinder", "--on", "hardware", "--yes", "cylinder"],
    "tune": ["tune", "cylinder", "--for", "no-such-experiment"],
    "margins": ["margins", "arm"],
    "simulate": ["simulate", "cylinder", "--on", "vcan9"],
}


@pytest.fixture
def mark(tmp_path, monkeypatch):
    """Install the package for this process and those that it starts; return what it would write."""
    source = tmp_path / "source"
    (source / "sly").mkdir(parents=True)
    (source / "sly" / "__init__.py").write_text(CODE)
    (source / "sly" / "parts.py").write_text(PARTS)
    (source / "sly_more.py").write_text("MEASURES = {}\n")
    paths = [str(path) for path in beside_the_source(tmp_path / "site", PROJECT, source)]
    for path in paths[1:]:
        monkeypatch.syspath_prepend(path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([*paths, os.environ.get("PYTHONPATH", "")]))
    mark = tmp_path / MARK
    monkeypatch.setenv("SLY_MARK", str(mark))
    monkeypatch.chdir(tmp_path)
    rows = (offered.mechanisms, offered.drivers, offered.protocols, offered.foreign_additions)
    for cache in rows:
        cache.cache_clear()
    yield mark
    for cache in rows:
        cache.cache_clear()
    for name in [name for name in sys.modules if name.partition(".")[0] in ("sly", "sly_more")]:
        del sys.modules[name]


def profile(folder, text):
    (folder / "rigs").mkdir(parents=True, exist_ok=True)
    path = folder / "rigs" / "ours.yaml"
    path.write_text(f"extends: {ROOT}/configs/rigs/cylinder.yaml\n{text}")
    return path


def test_no_command_runs_what_nobody_named(mark, capsys):
    """A profile beside the one that is asked for names it: that is no reason."""
    assert set(COMMAND_LINES) == set(COMMANDS)
    profile(Path("configs"), "additions: [sly]\n")
    for command, words in COMMAND_LINES.items():
        assert invoke(words) != 70, (command, capsys.readouterr().err)
        assert not mark.exists(), command
    for words in (["schema", "experiment"], ["explain", "overshoot"], ["check", "joint"]):
        assert invoke([*words, *(["--rig", "cylinder"] if words[0] == "explain" else [])]) == 0
        assert not mark.exists(), words


@pytest.mark.parametrize(
    ("named", "words"),
    [
        ("additions: [sly]", ["check"]),
        ("additions: [sly]", ["schema", "profile"]),
        ("mechanism: sly", ["check"]),
        ("buses: {can0: {protocol: sly}}", ["check"]),
        ("devices: {more: {driver: sly}}", ["check"]),
    ],
)
def test_what_a_profile_names_runs(mark, capsys, named, words):
    path = profile(Path("configs"), f"{named}\n")
    code = invoke([*words, str(path)])
    assert code == (0 if named.startswith("additions") else 2)  # of the others it has no row
    assert mark.exists(), capsys.readouterr().err


def test_a_name_that_is_missing_tells_of_what_is_installed(mark, capsys):
    path = profile(Path("configs"), "controllers: {sly-law: {}}\n")
    assert invoke(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert "no controller is called 'sly-law'" in said
    assert "additions: [NAME] lets a package take part: sly of the package sly" in said
    for words in (["explain", "sly-law"], ["run", "cylinder-sine", "--set", "law=sly-law"]):
        Path("configs/rigs/ours.yaml").unlink(missing_ok=True)
        assert invoke(words) == 2
        assert "lets a package take part: sly of the package sly" in capsys.readouterr().err
    path = profile(Path("configs"), "additions: [slyly]\n")
    assert invoke(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert f"{path}:2:13: no additions are called 'slyly'" in said
    assert "there are sly of the package sly" in said
    assert not mark.exists()


@pytest.mark.parametrize("name", [7, "[a]", "{a: 1}", "null", "1e300", "true"])
def test_what_is_no_name_is_refused_with_its_place(mark, capsys, name):
    path = profile(Path("configs"), f"additions: [{name}]\n")
    assert invoke(["check", str(path)]) == 2
    assert f"{path}:2:13: additions.0 is " in capsys.readouterr().err


def test_two_packages_of_one_name_are_nobodys(mark, capsys, tmp_path, monkeypatch):
    beside_the_source(tmp_path / "other", {**PROJECT, "name": "slyer"})
    monkeypatch.syspath_prepend(tmp_path / "other")
    path = profile(Path("configs"), "additions: [sly]\n")
    assert invoke(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert "the name 'sly' is taken twice" in said
    assert "the package sly " in said and "the package slyer " in said
    assert not mark.exists()


def test_the_manifest_names_what_was_named_and_what_its_row_led_to(mark, capsys):
    path = profile(Path("configs"), "additions: [sly]\n")
    assert invoke([*COMMAND_LINES["run"], "--rig", str(path)]) in (0, 1), capsys.readouterr().err
    (manifest,) = Path("runs").glob("*/manifest.json")
    told = json.loads(manifest.read_text())["plug_ins"]
    assert set(told) == {"sly", "sly_more"}
    assert (told["sly"]["distribution"], told["sly"]["version"]) == ("sly", "6.6")
    assert len(told["sly"]["sha256"]) == len(told["sly_more"]["sha256"]) == 64
    assert "additions:" in (manifest.parent / "profile.yaml").read_text()
    assert json.loads((manifest.parent / "evaluation.json").read_text())["additions"] == ["sly"]
    assert invoke(["check", str(manifest.parent / "profile.yaml")]) == 0


def test_an_option_of_a_profile_names_too(mark, capsys):
    assert invoke(["check", "cylinder-step", "--set", "additions=[sly]"]) == 0
    assert mark.exists(), capsys.readouterr().err


def test_a_word_of_an_own_package_is_asked_for_with_its_profile(mark, capsys):
    Path("ours.yaml").write_text("extends: cylinder\ncontrollers: {sly-law: {}}\n")
    assert invoke(["explain", "sly-law"]) == 2
    assert "rig explain sly-law --rig ours.yaml\n" in capsys.readouterr().err
    Path("ours.yaml").write_text("extends: cylinder\ndevices: {probe: {driver: sly-probe}}\n")
    assert invoke(["explain", "sly-probe"]) == 2
    assert "rig explain sly-probe --rig ours.yaml\n" in capsys.readouterr().err
    assert invoke(["explain", "sly"]) == 2
    assert "rig explain sly --rig PROFILE; " in capsys.readouterr().err
    assert not mark.exists()


@pytest.mark.parametrize("slip", ["trackin_rms", "regulatrs", "controler"])
def test_a_slip_is_not_told_of_packages(mark, capsys, slip):
    assert invoke(["explain", slip]) == 2
    said = capsys.readouterr().err
    assert "did you mean" in said and "package" not in said
