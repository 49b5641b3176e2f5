"""What moves off when it is released is told, and a run in which it does has not gone well."""

import json

import pytest
from stop_bench import CONFIGS

from rig.cli import invoke
from rig.experiment.ending import EXIT_FAULT, EXIT_MISSED, EXIT_OK
from rig.mechanisms.pneumatic.alarms.missing import UnseenPull

SMOOTH = (
    "cylinder.base_pressure=150 kPa", "plant.friction_scale=0.7", "cylinder.limits.stop_energy=5",
)  # fmt: skip


def run(tmp_path, *settings):
    words = [word for setting in (*SMOOTH, *settings) for word in ("--set", setting)]
    where = ["--configs", str(CONFIGS), "--out", str(tmp_path), "--no-report"]
    code = invoke(["run", "cylinder-step", "--on", "sim", *words, *where])
    (folder,) = tmp_path.iterdir()
    return code, folder, json.loads((folder / "manifest.json").read_text())


@pytest.mark.parametrize("chamber", ["agonist", "antagonist"])
def test_what_no_alarm_has_stopped_is_told_of(tmp_path, capsys, monkeypatch, chamber):
    monkeypatch.setattr(UnseenPull, "lasts", False)
    leak = f"{{device: plant, fault: {chamber}.leak, value: 2.5e-8, at: 18.8 s}}"
    code, folder, manifest = run(tmp_path, f"simulation.faults=[{leak}]")
    assert code == EXIT_MISSED
    assert "moved off by itself" in manifest["message"]
    assert capsys.readouterr().err.count("moved off by itself") == 1
    assert invoke(["explain", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "moved off by itself" in told
    assert "kind: moves_unasked" in told


@pytest.mark.parametrize("chamber", ["agonist", "antagonist"])
def test_a_chamber_that_leaks_while_it_is_vented_is_named(tmp_path, chamber):
    leak = f"{{device: plant, fault: {chamber}.leak, value: 2.5e-8, at: 18.8 s}}"
    code, _, manifest = run(tmp_path, f"simulation.faults=[{leak}]")
    assert code == EXIT_FAULT
    assert f"the chamber of {chamber} leaks behind its tube" in manifest["message"]


def test_a_healthy_one_is_released_well(tmp_path):
    code, _, manifest = run(tmp_path)
    assert (code, manifest["message"]) == (EXIT_OK, None)
