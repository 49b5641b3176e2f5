"""The acceptance test of a rig on SocketCAN: one process simulates it, another one tests it."""

import shutil

import pytest
import yaml
from two_processes import ROOT, Program, set_all, simulate

pytestmark = pytest.mark.vcan

RATE = set_all(loop__rate="500 Hz")


def commission(rig, on, tmp_path, *options):
    configs = tmp_path / "configs"
    shutil.copytree(ROOT / "configs", configs, ignore=shutil.ignore_patterns("commissioning"))
    words = ("--on", on, "--out", tmp_path / "runs", "--configs", configs, "--anew", *options)
    with Program("commission", rig, *words) as program:
        code = program.end()
    kept = configs / "commissioning" / f"{rig}.yaml"
    return code, program.talk, yaml.safe_load(kept.read_text()) if kept.exists() else None


@pytest.mark.parametrize(
    ("rig", "on", "rate"),
    [
        ("cylinder", "vcan0", RATE),
        ("joint", "vcan1,vcan2", RATE),
        ("arm", "vcan3", ()),
        ("arm-odrive", "vcan4", ()),
        ("legs-can", "vcan5,vcan6", ()),
    ],
    ids=("cylinder", "joint", "arm", "arm-odrive", "legs-can"),
)
def test_a_healthy_rig_passes_every_step(rig, on, rate, tmp_path):
    with simulate(rig, on, *rate) as simulation:
        code, talk, record = commission(rig, on, tmp_path, *rate)
        assert simulation.stop() == 0, simulation.talk
    assert code == 0, talk
    assert record["backend"] == "vcan"
    assert all(step["passed"] for step in record["steps"].values())
    died = record["steps"]["master"]["measured"]
    assert 0.05 < died[0]["value"] < died[0]["high"]


@pytest.mark.parametrize(
    ("planted", "step", "words"),
    [
        ({"devices__encoder-antagonist__node": "0x25"}, "bus", "does not answer"),
        ({"devices__regulators__stop_active_low": "false"}, "emergency-stop", "normally open"),
        ({"simulation__faults": "[{at: 0 s, device: plant, fault: regulator_stuck, value: 0}]"},
         "supply", "stuck"),
    ],
    ids=["other-number", "normally-open", "stuck"],
)  # fmt: skip
def test_a_planted_defect_is_found_at_its_step(planted, step, words, tmp_path):
    with simulate("cylinder", "vcan0", *RATE, *set_all(**planted)) as simulation:
        code, talk, _ = commission("cylinder", "vcan0", tmp_path, *RATE)
        assert simulation.stop() == 0, simulation.talk
    assert code == 3
    assert f"stopped at {step}: " in talk
    assert words in talk
