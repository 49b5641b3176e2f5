"""What a full calibration of a joint is worth: its marker is where that of an exact joint is."""

import json
import shutil

import pytest

from rig.cli import invoke
from rig.config import find_configs

# Everything that a profile cannot know is off.
OFF = {
    "setpoint_gain": "0.02", "setpoint_offset": "3 kPa", "monitor_gain": "0.01",
    "monitor_offset": "2 kPa", "encoder_scale": "0.01", "encoder_offset": "2 mm",
    "wire_offset": "2 mm", "geometry": "0.02", "friction": "0.3", "camera_position": "2 mm",
    "camera_angle": "2 deg",
}  # fmt: skip
SEEDS = (3, 5, 41)
"""Friction is 20 % below the profile's, 29 % below it and 30 % above it."""

PERTURBED = tuple(
    word for name, bound in OFF.items()
    for word in ("--set", f"simulation.perturbation.{name}={bound}")
)  # fmt: skip
WORTH = 1.2
"""Marker error of the calibrated joint over that of one that is as its profile says."""

SLIPS = 4e-3
"""What the seals' slips leave of a circle on regulators that can be bought, m: its bound."""

METRICS = ("marker_rms", "marker_rms_0.2hz", "marker_rms_0.5hz")


@pytest.fixture
def bench(tmp_path):
    configs = tmp_path / "configs"
    for kind in ("rigs", "experiments"):
        shutil.copytree(find_configs()[-1] / kind, configs / kind)
    return ["--configs", str(configs), "--out", str(tmp_path / "runs")]


def marker_errors(bench, capsys, seed, *options, experiment="joint-ideal-circle"):
    """Return the marker's rms error of a circle at each frequency, m."""
    capsys.readouterr()
    words = [experiment, "--on", "sim", "--no-report", "--json", *seed, *options, *bench]
    assert invoke(["run", *words]) in (0, 1)  # a bound that is missed is not the question here
    metrics = json.loads(capsys.readouterr().out)["metrics"]
    found = {metric["name"]: metric["value"] for metric in metrics}
    return [found[name] for name in METRICS]


@pytest.mark.slow
@pytest.mark.parametrize("number", SEEDS)
def test_a_calibrated_joint_is_as_good_as_an_exact_one(number, bench, capsys, record_property):
    seed = ("--set", f"simulation.seed={number}")
    exact = marker_errors(bench, capsys, seed, "--set", "calibration=false")
    assert invoke(["calibrate", "joint-ideal", "--all", "--yes", "--on", "sim", *seed, *PERTURBED,
                   *bench]) == 0  # fmt: skip
    calibrated = marker_errors(bench, capsys, seed, *PERTURBED)
    for name, before, after in zip(METRICS, exact, calibrated, strict=True):
        record_property(name, f"{1e3 * before:.3f} mm, calibrated {1e3 * after:.3f} mm")
    assert [after <= WORTH * before for before, after in zip(exact, calibrated, strict=True)] == (
        [True] * len(METRICS)
    ), (exact, calibrated)


@pytest.mark.slow
@pytest.mark.parametrize("number", SEEDS[:2])
def test_a_joint_that_sticks_and_slips_on_late_regulators_is_calibrated_whole(
    number, bench, capsys, record_property
):
    seed = ("--set", f"simulation.seed={number}")
    assert invoke(["calibrate", "joint", "--all", "--yes", "--on", "sim", *seed, *PERTURBED,
                   *bench]) == 0  # fmt: skip
    found = marker_errors(bench, capsys, seed, *PERTURBED, experiment="joint-circle")
    record_property("marker", " / ".join(f"{1e3 * error:.2f} mm" for error in found))
    assert max(found) < SLIPS
