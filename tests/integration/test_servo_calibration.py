"""`rig calibrate` of arms and legs from the command line to the file, and into use."""

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import find_configs, load_profile

PERTURBED = ("--set", "simulation.perturbation.joint_zero=2 deg")


@pytest.fixture
def configs(tmp_path):
    rigs = tmp_path / "configs" / "rigs"
    rigs.mkdir(parents=True)
    for name in ("arm", "legs"):
        source = find_configs()[-1] / "rigs" / f"{name}.yaml"
        (rigs / source.name).write_text(source.read_text(encoding="utf-8"))
    return rigs.parent


def calibrate(configs, rig, *words, on="sim"):
    out = ["--configs", str(configs), "--out", str(configs.parent / "runs"), "--yes", "--on", on]
    return invoke(["calibrate", rig, *words, *out])


def test_legs_from_preview_to_use(configs, capsys):
    file = configs / "calibration" / "legs" / "servos.yaml"
    assert calibrate(configs, "legs", "scale", "--dry-run") == 0
    shown = capsys.readouterr().err
    assert "no torque: the joints are moved by hand, and nothing moves by itself" in shown
    assert "first of all: put both legs into the jig's pose 'straight'" in shown
    assert not file.exists()

    assert calibrate(configs, "legs", "zeros", *PERTURBED) == 0
    (run,) = (configs.parent / "runs").iterdir()
    assert (run / "figures" / "calibration-zeros.png").stat().st_size > 10_000
    nominal = load_profile("legs", REGISTRY, ["calibration=false"], find_configs(configs))
    profile = load_profile("legs", REGISTRY, (), find_configs(configs))
    offset = yaml.safe_load(file.read_text())["values"]["joints"]["left_knee"]["offset"]
    assert profile.devices["servos"].settings.joints["left_knee"].offset == float(offset.split()[0])
    assert nominal.devices["servos"].nominal is not None


def test_a_servo_in_a_fault_leaves_everything_as_it_was(configs, capsys):
    fault = "simulation.faults=[{at: 1.5, device: servos, fault: left_knee.drive_fault}]"
    assert calibrate(configs, "legs", "zeros", "--set", fault) == 4
    told = capsys.readouterr().err
    assert "servos joint left_knee: the drive reports a fault" in told
    assert "nothing was changed; what was recorded is kept" in told
    assert not (configs / "calibration").exists()


def test_a_file_of_readings_in_wrong_units_changes_nothing(configs, tmp_path, capsys):
    file = tmp_path / "inclinometer.csv"
    file.write_text("angle left_knee,straight,0.1 mm\n")
    assert calibrate(configs, "legs", "zeros", "--readings", str(file)) == 2
    assert "inclinometer.csv:1:26: " in capsys.readouterr().err
    assert not (configs / "calibration").exists()


@pytest.mark.slow
def test_an_arm_that_was_stopped_goes_on_with_the_poses_that_are_left(configs, capsys):
    few = ("--set", "arm.metrology.poses=10", "--set", "loop.rate=50")
    fault = "simulation.faults=[{at: 40, device: drives, fault: q3.drive_fault}]"
    assert calibrate(configs, "arm", "links", *few, *PERTURBED, "--set", fault) == 4
    assert "drives joint q3: the drive reports a fault" in capsys.readouterr().err
    assert not (configs / "calibration").exists()
    (first,) = (configs.parent / "runs").iterdir()

    assert calibrate(configs, "arm", "links", *few, *PERTURBED, "--from", str(first)) == 0
    told = capsys.readouterr().err
    left = int(told.split(" stretches in ")[0].split()[-1])
    assert 0 < left < 10
    written = sorted(path.name for path in (configs / "calibration" / "arm").glob("*.yaml"))
    assert written == ["arm.yaml", "drives.yaml"]
    # A worse fit: another instrument, twenty times as rough.
    rough = ("--set", "arm.metrology.accuracy=1 mm", *few, *PERTURBED)
    assert calibrate(configs, "arm", "links", *rough) == 1
    assert "a worse fit does not replace a better one" in capsys.readouterr().err
