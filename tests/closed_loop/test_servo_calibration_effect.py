"""What calibrations of servos are worth: hand and feet are again where the rig believes them."""

import shutil
import sys

import numpy as np
import pytest

from controllers.gait.kinematics import waist_from_foot
from rig.assembly import REGISTRY, Backend
from rig.calibration.catalogue import procedures
from rig.calibration.session import record
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

ARM = (
    "simulation.seed=4", "simulation.perturbation.joint_zero=2 deg",
    "simulation.perturbation.link_length=2 mm", "simulation.perturbation.joint_reversed=0.3",
    "simulation.perturbation.marker=20 um", "loop.rate=50", "plant.timestep=2 ms",
)  # fmt: skip
LEGS = (
    "simulation.seed=4", "simulation.perturbation.joint_zero=3 deg",
    "simulation.perturbation.joint_scale=0.01",
)  # fmt: skip


@pytest.fixture
def bench(tmp_path):
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")

    def calibrate(rig, names, options, on):
        words = [word for option in options for word in ("--set", option)]
        places = ["--configs", str(configs), "--out", str(tmp_path / "runs")]
        return invoke(["calibrate", rig, *names, "--yes", "--on", on, *words, *places])

    def recorded(rig, procedure, options):
        """Return the log of a procedure's motion, whatever may be calibrated by it."""
        profile = load_profile(rig, REGISTRY, options, find_configs(configs))
        result, folders = record(
            procedures(profile)[procedure], profile, Backend.SIM, tmp_path / "again"
        )
        assert result.exit_code == 0, result.message
        return profile, [read_log(RunFolder.open(folder).log_path) for folder in folders]

    return calibrate, recorded


def hand_error(recorded, rig, options, way="zeros"):
    """Return how far the hand is from where the rig believes it, rms over a way, m."""
    # A joint that turns the wrong way is only safe to move around where it stands ("zeros").
    _, (log,) = recorded(rig, way, options)
    # A reading is one cycle older than the truth in its row: at 50 Hz a hand at 0.3 m/s would seem
    # 6 mm off that no calibration takes away.
    error = [
        log.column(f"truth.hand_{axis}")[:-1] - log.column(f"reading.hand_{axis}")[1:]
        for axis in "xyz"
    ]
    return float(np.sqrt(np.mean(np.sum(np.square(error), axis=0))))


def foot_error(recorded, rig, options):
    """Return how far the feet are from where the rig believes them, rms over the jig, m."""
    profile, logs = recorded(rig, "scale", options)
    geometry, errors = profile.mechanism_settings.geometry, []
    for log in logs:
        names = [c.name for c in log.columns if c.name.startswith("reading.position_")]
        row = np.array([log.column(name)[-1] for name in names])
        waist = np.array([log.column(f"truth.waist_{axis}")[-1] for axis in "xyz"])
        for leg, side in enumerate(("right", "left")):
            place, rotation = waist_from_foot(geometry, leg, tuple(row[6 * leg : 6 * leg + 6]))
            believed = -np.array(rotation).T @ place
            true = [log.column(f"truth.{side}_foot_{axis}")[-1] for axis in "xyz"] - waist
            errors.append(np.sum((believed - true) ** 2))
    return float(np.sqrt(np.mean(errors)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "on"), [("arm", "sim"), ("arm", "virtual"), ("arm-odrive", "virtual")]
)
def test_the_hand_of_an_arm(bench, rig, on, record_property):
    calibrate, recorded = bench
    options = ARM if on == "sim" else [o for o in ARM if not o.startswith("loop")]
    drawn = [option for option in ARM if "perturbation" not in option]
    nominal, before = hand_error(recorded, rig, drawn), hand_error(recorded, rig, ARM)
    assert calibrate(rig, ["zeros", "links"], options, on) == 0
    # Near where it was found, and all over the workspace.
    after = max(hand_error(recorded, rig, ARM, way) for way in ("zeros", "links"))
    record_property("hand error nominal, before, after (m)", (nominal, before, after))
    sys.stdout.write(f"{rig} on {on}: hand error {nominal:.3g}, {before:.3g}, {after:.3g} m\n")
    assert before > 10e-3
    assert after < 0.2e-3
    assert nominal < 10e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "on"), [("legs", "sim"), ("legs", "virtual"), ("legs-can", "virtual")]
)
def test_the_feet_of_legs(bench, rig, on, record_property):
    calibrate, recorded = bench
    nominal, before = foot_error(recorded, rig, LEGS[:1]), foot_error(recorded, rig, LEGS)
    assert calibrate(rig, ["scale"], LEGS, on) == 0
    after = foot_error(recorded, rig, LEGS)
    record_property("foot error nominal, before, after (m)", (nominal, before, after))
    sys.stdout.write(f"{rig} on {on}: foot error {nominal:.3g}, {before:.3g}, {after:.3g} m\n")
    assert before > 5e-3
    # Three joints of 0.1 deg on levers of 0.1 to 0.24 m, and the servos' steps of 0.09 deg.
    assert after < 1e-3
