"""What does not suffice, or no longer holds, at the command line: said, and nothing is changed."""

import json
import os
import signal
import sys
from datetime import UTC, datetime

import click
import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.calibration import store
from rig.calibration.estimates import Estimate
from rig.calibration.procedure import Finding
from rig.calibration.recording import Recording
from rig.cli import invoke
from rig.cli.progress import ProgressLine
from rig.config import find_configs, load_profile
from rig.runtime.phases import Phase

ENCODER = "encoder-agonist"


@pytest.fixture
def configs(tmp_path):
    folder = tmp_path / "configs"
    for kind, name in (("rigs", "cylinder"), ("experiments", "cylinder-step")):
        (folder / kind).mkdir(parents=True)
        text = (find_configs()[-1] / kind / f"{name}.yaml").read_text(encoding="utf-8")
        (folder / kind / f"{name}.yaml").write_text(text, encoding="utf-8")
    return folder


def calibrated(configs, *, now=None, days=365, rms=10e-6):
    """Write a calibration of an encoder with the serial number 7."""
    profile = load_profile("cylinder", REGISTRY, [f"devices.{ENCODER}.serial=7"], [configs])
    estimate = Estimate("offset", 1e-3, "m", 2e-6, 0.996e-3, 1.004e-3)
    residuals = rms * np.array([1.0, -1.0] * 6)
    found = Finding(ENCODER, {"offset": "1 mm"}, (estimate,), residuals, "m", 50e-6, 12, ())
    said = store.Circumstances(
        "me", days * 86_400.0, {}, now or datetime.now(UTC), "hardware", None
    )
    content = store.compose(found, "encoders", profile, Recording([]), said, None)
    content["provenance"]["samples"] = 12
    return store.write(configs, "cylinder", ENCODER, content)


def calibrate(configs, *words):
    out = ["--configs", str(configs), "--out", str(configs.parent / "runs")]
    return invoke(["calibrate", "cylinder", *words, *out])


def runs(configs):
    folder = configs.parent / "runs"
    return sorted(folder.iterdir()) if folder.exists() else []


@pytest.mark.parametrize(
    ("how", "serial", "reason"),
    [
        ({}, 8, "is of serial number 7, the profile's device has 8"),
        ({"now": datetime(2024, 1, 1, tzinfo=UTC), "days": 30}, 7, "expired on 2024-01-31"),
        ({"rms": 60e-6}, 7, "above the bound of 5e-05 m"),
    ],
    ids=["serial", "expired", "residual"],
)
def test_hardware_is_refused_with_what_would_mend_it(configs, capsys, how, serial, reason):
    calibrated(configs, **how)
    words = ["cylinder-step", "--set", f"devices.{ENCODER}.serial={serial}"]
    words += ["--configs", str(configs), "--out", str(configs.parent / "runs")]
    assert invoke(["run", *words, "--on", "hardware"]) == 3
    told = " ".join(capsys.readouterr().err.split())
    assert ENCODER in told
    assert reason in told
    rig = configs / "rigs" / "cylinder.yaml"
    assert f"rig calibrate {rig} encoders --replace --on hardware" in told
    assert runs(configs) == []


def test_who_says_no_has_changed_nothing(configs, monkeypatch, capsys):
    path = calibrated(configs)
    before = path.read_bytes()

    class Terminal:
        def isatty(self):
            return True

    asked = []
    monkeypatch.setattr(sys, "stdin", Terminal())
    monkeypatch.setattr(click, "confirm", lambda text, **how: bool(asked.append(text)))
    assert calibrate(configs, "encoders", "--on", "sim") == 2
    assert asked == ["Go?"]
    assert "to be read: caliper agonist" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert runs(configs) == []


class Interrupting(ProgressLine):
    """Presses Ctrl-C once, in the middle of the run."""

    pressed = False

    def progressed(self, progress):
        super().progressed(progress)
        if not Interrupting.pressed and progress.phase is Phase.RUN and progress.t > 5.0:
            Interrupting.pressed = True
            os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_recorded_and_the_rest_can_be_recorded_later(
    configs, monkeypatch, capsys
):
    path = calibrated(configs)
    before = path.read_bytes()
    monkeypatch.setattr("rig.cli.progress.ProgressLine", Interrupting)
    code = calibrate(configs, "response", "--yes", "--on", "sim")
    monkeypatch.undo()
    told = capsys.readouterr().err
    assert Interrupting.pressed
    assert code != 0
    (run,) = runs(configs)
    assert "nothing was changed; what was recorded is kept" in told
    assert f"--from {run}" in told
    assert path.read_bytes() == before
    assert calibrate(configs, "response", "--yes", "--on", "sim", "--from", str(run)) == 0
    first, second = (
        json.loads((folder / "manifest.json").read_text())["status"] for folder in runs(configs)
    )
    assert (first, second) != ("ok", "ok")
    assert second == "ok"


@pytest.mark.slow
def test_of_a_log_that_was_cut_short_only_the_rest_is_recorded_again(configs, capsys):
    assert calibrate(configs, "response", "--yes", "--on", "sim") == 0
    (run,) = runs(configs)
    log = run / "log.mcap"
    whole = log.read_bytes()
    count = len(set(Recording.of([run]).names))
    log.write_bytes(whole[: int(0.6 * len(whole))])
    left = set(Recording.of([run]).names)
    assert 0 < len(left) < count
    capsys.readouterr()
    assert calibrate(configs, "response", "--dry-run", "--from", str(run)) == 0
    shown = capsys.readouterr().err
    again = int(shown.split(" stretches")[0].split()[-1])
    assert count - len(left) <= again < count
    assert calibrate(configs, "response", "--yes", "--on", "sim", "--from", str(run)) == 0


@pytest.mark.slow
def test_a_regulator_that_saturates_is_told_and_the_old_calibration_stays(configs, capsys):
    path = calibrated(configs)
    before = path.read_bytes()
    code = calibrate(
        configs, "regulators", "--yes", "--on", "sim", "--set", "loop.rate=100",
        "--set", "plant.regulator.supply_pressure=0.36 MPa",
        "--set", "devices.regulators.following.deviation=400 kPa",
        "--set", "cylinder.alarms.pressure={deviation: 400 kPa, offset: 400 kPa, slow: 100}",
    )  # fmt: skip
    told = capsys.readouterr().err
    assert code == 1
    assert "saturated" in told
    assert "the calibration before stays in force" in told
    assert path.read_bytes() == before
    assert not (configs / "calibration" / "cylinder" / "regulators.yaml").exists()


@pytest.mark.slow
def test_a_rod_that_hardly_moves_is_told(configs, capsys):
    """Seals that jam: the pair does not follow its strokes."""
    code = calibrate(
        configs, "friction", "--yes", "--on", "sim", "--set", "plant.friction_scale=5",
        "--set", "cylinder.limits.pair_force=20 N", "--set", "loop.rate=500",
    )  # fmt: skip
    told = capsys.readouterr().err
    assert code == 1
    assert "a rod is stuck, the supply is shut" in told
    assert not (configs / "calibration" / "cylinder" / "cylinder.yaml").exists()


def test_what_a_rig_lacks_is_said_before_anything_moves_and_keeps_nothing_else(configs, capsys):
    assert calibrate(configs, "leak", "--yes", "--on", "sim") == 3
    told = capsys.readouterr().err
    assert "valve between the two, at the cylinder" in told
    assert "devices.regulators.channels.agonist.lock_bit" in told
    assert runs(configs) == []

    assert calibrate(configs, "--all", "--dry-run") == 0
    told = capsys.readouterr().err
    assert "leak: the air of agonist, antagonist cannot be locked in" in told
    assert "friction: friction of the pair:" in told
