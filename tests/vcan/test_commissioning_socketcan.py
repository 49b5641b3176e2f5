"""The acceptance test of a rig on SocketCAN: one process simulates it, another one tests it."""

import shutil
import signal

import numpy as np
import pytest
import yaml
from two_processes import ROOT, Program, pause, set_all, simulate

pytestmark = pytest.mark.vcan

RATE = set_all(loop__rate="500 Hz")
PRESSURES = slice(4, 6)
"""Columns of a cylinder's truth."""
PRESSED, VENTED = 5e3, 1e3
"""Gauge pressure of a chamber that was energised, and of one that moves nothing, Pa."""


def commissioning(rig, on, tmp_path, *options):
    """Start the acceptance test with configurations of its own."""
    configs = tmp_path / "configs"
    shutil.copytree(ROOT / "configs", configs, ignore=shutil.ignore_patterns("commissioning"))
    words = ("--on", on, "--out", tmp_path / "runs", "--configs", configs, "--anew", *options)
    return Program("commission", rig, *words)


def record_of(rig, tmp_path):
    kept = tmp_path / "configs" / "commissioning" / f"{rig}.yaml"
    return yaml.safe_load(kept.read_text()) if kept.exists() else None


def commission(rig, on, tmp_path, *options):
    with commissioning(rig, on, tmp_path, *options) as program:
        code = program.end()
    return code, program.talk, record_of(rig, tmp_path)


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


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP], ids=lambda number: number.name)
def test_a_process_that_is_told_to_end_vents_the_rig(number, tmp_path):
    truth = tmp_path / "truth.npz"
    with simulate("cylinder", "vcan0", *RATE, truth=truth) as simulation:
        with commissioning("cylinder", "vcan0", tmp_path, *RATE) as program:
            program.wait_for("At once the chambers are vented")
            pause(0.6)
            program.send(number)
            assert program.end() == 130, program.talk
        pause(0.3)
        assert simulation.stop() == 0, simulation.talk
    assert "kept, go on with: rig commission " in program.talk
    passed = record_of("cylinder", tmp_path)["steps"]
    assert list(passed) == ["bus", "identity", "emergency-stop", "supply"]
    pressures = np.load(truth)["rows"][:, PRESSURES]
    assert pressures.max() > PRESSED
    assert pressures[-1].max() < VENTED
