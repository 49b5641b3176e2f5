"""A rig that extends a calibrated one has none of its calibration, and is told so."""

import json

import pytest

from rig.calibration import store
from rig.cli import invoke

QUICK = (
    "--on", "sim", "--no-report", "--set", "reference.tones=[{frequency: 1 Hz, periods: 2}]",
    "--set", "approach=0.3 s", "--set", "metrics={}",
)  # fmt: skip


def keep(configs, rig, *targets):
    """Write calibrations that change nothing."""
    for target in targets:
        provenance = {"procedure": "encoders", "date": "2026-11-21", "operator": "nobody",
                      "backend": "virtual"}  # fmt: skip
        content = {"values": {}, "measured": [], "provenance": provenance}
        store.write(configs, rig, target, content)


@pytest.fixture
def lab(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("extends: bench\n")
    (tmp_path / "bench.yaml").write_text("extends: cylinder\n")
    keep(tmp_path / "configs", "cylinder", "encoder-agonist", "cylinder", "controllers.cascade")
    keep(tmp_path / "configs", "mine", "cylinder")
    return tmp_path


SAID = (
    "mine extends cylinder, and has nothing of its calibration (encoder-agonist, "
    "controllers.cascade): calibrations are of one rig; find its own with: "
    "rig calibrate mine.yaml --all"
)


def test_check_and_status_say_it(lab, capsys):
    assert invoke(["check", "mine.yaml", "--json"]) == 0
    assert SAID in json.loads(capsys.readouterr().out)["warnings"]
    assert invoke(["check", "mine.yaml"]) == 0
    assert f"warning: {SAID}\n" in capsys.readouterr().err
    assert invoke(["status", "mine.yaml"]) == 0
    assert f"note: {SAID}\n" in capsys.readouterr().err
    assert invoke(["status", "mine.yaml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"] == [SAID]


def test_a_run_says_it_first(lab, capsys):
    assert invoke(["run", "cylinder-sine", "--rig", "mine.yaml", *QUICK]) == 0
    assert SAID in " ".join(capsys.readouterr().err.split())
    (run,) = (lab / "runs").iterdir()
    events = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    assert [e["message"] for e in events if e["kind"] == "calibration"] == [SAID]


def test_who_has_its_own_or_wants_none_is_told_nothing(lab, capsys):
    keep(lab / "configs", "bench", "encoder-agonist")  # the nearer base is named
    assert invoke(["check", "mine.yaml"]) == 0
    said = capsys.readouterr().err
    assert "mine extends bench, and has nothing of its calibration (encoder-agonist)" in said
    assert "mine extends cylinder, and has nothing of its calibration (controllers.cascade)" in said
    keep(lab / "configs", "mine", "encoder-agonist", "controllers.cascade")
    (lab / "none.yaml").write_text("extends: bench\ncalibration: false\n")
    for rig in ("mine.yaml", "none.yaml", "cylinder"):
        assert invoke(["check", rig]) == 0
        assert "calibrations are of one rig" not in capsys.readouterr().err
