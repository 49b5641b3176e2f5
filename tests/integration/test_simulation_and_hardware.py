"""What was measured in simulation is never taken for the rig's, and a rig never moves unasked."""

import json
import shutil
import sys
from datetime import UTC, datetime
from pathlib import Path

import click
import numpy as np
import pytest
import yaml

from rig.assembly import REGISTRY
from rig.calibration import store
from rig.calibration.procedure import Estimate, Finding
from rig.calibration.recording import Recording
from rig.cli import invoke
from rig.config import load_profile

CONFIGS = Path(__file__).parents[2] / "configs"
ENCODER = "encoder-agonist"
STOP = ("--set", "cylinder.limits.stop_energy=1 J", "--set", "loop.small_margin=a test")
BRIEF = (
    "--set", "reference.dwell=0.3 s", "--set", "reference.rise=0 s",
    "--set", "reference.size=1 mm", "--set", "approach=0.5 s", "--set", "metrics={}",
)  # fmt: skip
SLOW = ("buses.can0.heartbeat=100 ms", "buses.can0.heartbeat_timeout=300 ms")


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Return what runs a `rig` command in a lab of its own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    shutil.copytree(
        CONFIGS, tmp_path / "configs", ignore=shutil.ignore_patterns("calibration", "commissioning")
    )

    def run(command, *words):
        places = ["--configs", str(tmp_path / "configs")]
        if command != "check":
            places += ["--out", str(tmp_path / "runs")]
        return invoke([command, *words, *places])

    run.configs, run.runs = tmp_path / "configs", tmp_path / "runs"
    return run


def written(lab, backend, seed=None, day=1, name="offset", procedure="encoders"):
    """Write a calibration of an encoder down as a procedure does."""
    profile = load_profile("cylinder", REGISTRY, [], [lab.configs])
    values = {"offset": "1.5 mm", "scale": 1.002}
    estimate = Estimate(name, 1.5e-3, "m", 1e-6, 1.4e-3, 1.6e-3)
    finding = Finding(
        ENCODER, {name: values[name]}, (estimate,), np.full(9, 2e-6), "m", 5e-5, 9, ()
    )
    now = datetime(2026, 11, day, 12, tzinfo=UTC)
    said = store.Circumstances("me", 365 * 86_400.0, {}, now, backend, seed)
    old = store.in_force(profile, [lab.configs], ENCODER)
    content = store.compose(finding, procedure, profile, Recording([]), said, old)
    content["provenance"]["samples"] = 9
    return store.write(lab.configs, "cylinder", ENCODER, content)


REFUSED = [
    ("virtual", 3, "was measured in simulation (virtual, seed 3), not on hardware"),
    ("vcan", None, "was measured in simulation (vcan), not on hardware"),
    ("unknown", None, "does not say whether it was measured on hardware"),
]


@pytest.mark.parametrize(("backend", "seed", "words"), REFUSED)
def test_hardware_refuses_what_was_not_measured_on_it(lab, capsys, backend, seed, words):
    written(lab, backend, seed)
    assert lab("run", "cylinder-step", "--on", "hardware", "--yes", "cylinder") == 3
    said = " ".join(capsys.readouterr().err.split())
    assert f"{ENCODER}: its calibration {words}" in said
    rig = lab.configs / "rigs" / "cylinder.yaml"
    assert f"rig calibrate {rig} encoders --replace --on hardware" in said
    assert not lab.runs.exists()
    assert lab("check", "cylinder") == 0
    assert "refused on hardware" in capsys.readouterr().out
    assert lab("run", "cylinder-step", "--on", "sim", "--no-report", *BRIEF) == 0


def test_a_file_that_does_not_say_where_is_refused(lab, capsys):
    path = written(lab, "hardware")
    content = yaml.safe_load(path.read_text())
    del content["seal"], content["provenance"]["backend"], content["measured"][0]["backend"]
    store.write(lab.configs, "cylinder", ENCODER, content)
    assert lab("run", "cylinder-step", "--on", "hardware", "--yes", "cylinder") == 3
    assert "does not say whether" in capsys.readouterr().err


def test_a_value_from_simulation_stays_one_beside_others(lab):
    written(lab, "virtual", 3, name="offset", procedure="encoders")
    path = written(lab, "hardware", day=2, name="scale", procedure="jig")
    assert store.load(path)["provenance"]["backend"] == "virtual"
    path = written(lab, "hardware", day=3, name="offset", procedure="encoders")
    content = store.load(path)
    assert content["provenance"]["backend"] == "hardware"
    assert {m["backend"] for m in content["measured"]} == {"hardware"}


def test_what_is_recorded_in_simulation_is_stamped_so_whatever_on_says_later(lab):
    """`--from` a simulated run, `--on hardware`: the run's folder knows better."""
    assert lab("calibrate", "cylinder", "response", "--yes", "--on", "sim") == 0
    (run,) = lab.runs.iterdir()
    words = ("--yes", "cylinder", "--on", "hardware", "--from", str(run), "--replace")
    assert lab("calibrate", "cylinder", "response", *words) == 0
    (path,) = (lab.configs / "calibration" / "cylinder").glob("*.yaml")
    assert store.load(path)["provenance"]["backend"] == "sim"
    assert store.load(path)["provenance"].get("seed") == 0
    svg = (run / "figures" / "calibration-response.svg").read_text()
    assert "simulation (sim)" in svg


def test_an_older_calibration_is_put_in_force_again(lab, capsys):
    first = written(lab, "hardware", day=1).read_text()
    path = written(lab, "virtual", day=2)
    latest = path.read_text()
    assert lab("calibrate", "cylinder", "--restore", ENCODER) == 0
    said = capsys.readouterr()
    assert "2026-11-01" in said.out and "2026-11-02" in said.out
    assert "hardware" in said.out and "virtual" in said.out
    assert f"--restore {ENCODER}/DATE" in said.err
    assert path.read_text() == latest
    for wrong in ("2026-11", "2026-12-01"):
        assert lab("calibrate", "cylinder", "--restore", f"{ENCODER}/{wrong}") == 2
    assert path.read_text() == latest
    assert lab("calibrate", "cylinder", "--restore", f"{ENCODER}/2026-11-01") == 0
    in_force = path.read_text()
    restored, written_first = store.load(path), yaml.safe_load(first)
    assert restored["provenance"].pop("profile") == "rigs/cylinder.yaml"  # whose it is from now on
    del written_first["provenance"]["profile"], written_first["seal"], restored["seal"]
    assert restored == written_first
    kept = store.history([lab.configs], "cylinder", ENCODER)
    assert [file.read_text() for file in kept] == [first, latest]
    kept[1].write_text(latest.replace("0.0015", "0.0016"))
    assert lab("calibrate", "cylinder", "--restore", f"{ENCODER}/2026-11-02") == 2
    assert path.read_text() == in_force


@pytest.mark.parametrize("yes", [(), ("--yes", "joint")], ids=["silent", "another"])
@pytest.mark.parametrize("command", ["run", "compare", "calibrate"])
def test_hardware_does_not_move_unless_it_was_named(lab, capsys, command, yes):
    what = ("cylinder", "response") if command == "calibrate" else ("cylinder-step",)
    assert lab(command, *what, "--on", "hardware", *yes, *STOP) == 2
    said = capsys.readouterr().err
    assert ("say --yes cylinder" if not yes else "this is the rig cylinder") in said
    assert not lab.runs.exists()


@pytest.mark.parametrize("typed", ["cylinder", "", "y", "joint"])
def test_the_name_is_typed_by_who_has_read_what_will_move(lab, monkeypatch, capsys, typed):
    class Terminal:
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stdin", Terminal())
    asked = []
    monkeypatch.setattr(click, "prompt", lambda text, **how: asked.append(text) or typed)
    channel = ("--set", "buses.can0.channel=nocan7", *STOP)
    code = lab("run", "cylinder-sine", "--on", "hardware", *channel)
    assert asked == ["Type the rig's name to go on"]
    assert code == (3 if typed == "cylinder" else 2)  # it has no such interface
    said = capsys.readouterr().err
    assert "cylinder-sine moves cylinder for 45.0 s" in said
    assert "position: -8.727 mm … 8.727 mm" in said
    assert "position -20 mm … 20 mm" in said
    assert lab.runs.exists() == (typed == "cylinder")


@pytest.mark.parametrize(
    ("command", "lacks"),
    [(command, "stop") for command in ("run", "compare", "calibrate")]
    + [(command, "quick devices") for command in ("run", "compare")],
)
def test_nobody_is_asked_about_a_rig_that_is_refused_anyway(
    lab, monkeypatch, capsys, command, lacks
):
    monkeypatch.setattr(click, "prompt", lambda *_, **__: pytest.fail("somebody was asked"))
    if lacks == "stop":
        words, options = "limits.stop_energy is not declared", ()
    else:
        words = "keeps its setpoints for 300 ms"
        brisk = "reference.tones=[{frequency: 1 Hz, periods: 3}]"
        late = [*SLOW, brisk, "reference.amplitude=10 mm", "metrics={}"]
        options = (*STOP, *(word for option in late for word in ("--set", option)))
    what = ("cylinder", "response") if command == "calibrate" else ("cylinder-sine",)
    assert lab(command, *what, "--on", "hardware", *options) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert words in said
    assert "--yes" not in said
    assert not lab.runs.exists()


def test_a_page_and_its_figures_say_that_they_are_a_simulation(lab):
    words = ("--set", "simulation.seed=5", "--set", "approach=0.5 s")
    assert lab("run", "cylinder-step", "--on", "sim", *words) == 0
    (run,) = lab.runs.iterdir()
    assert run.name.endswith("-sim")
    assert "cylinder-step on sim, a simulation" in (run / "report.html").read_text()
    figures = sorted((run / "figures").glob("*.svg"))
    assert figures
    for figure in figures:
        assert "simulation (sim, seed 5)" in figure.read_text(), figure.name
    assert json.loads((run / "manifest.json").read_text())["backend"] == "sim"
