"""A calibration that came along with a copied folder is another rig's until somebody says not."""

import shutil
import socket
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.calibration import store
from rig.calibration.estimates import Estimate
from rig.calibration.procedure import Finding
from rig.calibration.recording import Recording
from rig.cli import invoke
from rig.config import load_profile

SHIPPED = Path(__file__).parents[2] / "configs"
ENCODER = "encoder-agonist"
STOP = "cylinder.limits.stop_energy=1 J"


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A folder in which a rig was calibrated on a computer of that name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    configs = tmp_path / "configs"
    (configs / "rigs").mkdir(parents=True)
    shutil.copy(SHIPPED / "rigs" / "cylinder.yaml", configs / "rigs")
    own = socket.gethostname()

    def calibrated_on(host, backend="hardware", *options):
        monkeypatch.setattr(socket, "gethostname", lambda: host)
        profile = load_profile("cylinder", REGISTRY, options, [configs])
        estimate = Estimate("offset", 1.5e-3, "m", 1e-6, 1.4e-3, 1.6e-3)
        residuals = np.full(9, 2e-6)
        values = {"offset": "1.5 mm"}
        finding = Finding(ENCODER, values, (estimate,), residuals, "m", 5e-5, 9, ())
        said = store.Circumstances("me", 3e7, {}, datetime.now(UTC), backend, None)
        content = store.compose(finding, "encoders", profile, Recording([]), said, None)
        content["provenance"]["samples"] = 9
        store.write(configs, "cylinder", ENCODER, content)
        monkeypatch.setattr(socket, "gethostname", lambda: own)
        return content["provenance"]

    return calibrated_on


def refusals(capsys, *options):
    """Return what hardware refuses of the encoder, as `rig check` says it."""
    sets = [word for option in (STOP, *options) for word in ("--set", option)]
    assert invoke(["check", "cylinder", *sets]) == 0
    said = capsys.readouterr().err.splitlines()
    return [line for line in said if line.startswith(f"hardware would refuse it: {ENCODER}")]


def test_the_computer_that_measured_it_takes_it(lab, capsys):
    assert lab(socket.gethostname())["host"] == socket.gethostname()
    assert refusals(capsys) == []


def test_another_computer_refuses_it_until_somebody_says_that_it_is_the_same_rig(lab, capsys):
    lab("lab-of-others")
    (said,) = refusals(capsys)
    assert "was measured at the rig of another computer (lab-of-others; this is" in said
    run = ["run", "cylinder-step", "--on", "hardware", "--yes", "cylinder", "--set", STOP]
    assert invoke(run) == 3
    assert "lab-of-others" in capsys.readouterr().err
    command = said.partition("mend it with: rig ")[2].partition(",")[0]
    assert invoke(command.split()) == 0
    capsys.readouterr()
    assert refusals(capsys) == []


@pytest.mark.parametrize(("serial", "refused"), [(7, 0), (8, 1)])
def test_a_serial_number_tells_more_than_a_computer(lab, capsys, serial, refused):
    lab("lab-of-others", "hardware", f"devices.{ENCODER}.serial=7")
    said = refusals(capsys, f"devices.{ENCODER}.serial={serial}")
    assert len(said) == refused
    assert all("serial number of 7" in one or "serial number 7" in one for one in said)


def test_a_calibration_of_before_names_no_computer_and_a_simulation_has_none(lab, capsys):
    assert "host" not in lab("lab-of-others", "virtual")
    (said,) = refusals(capsys)
    assert "measured in simulation" in said
