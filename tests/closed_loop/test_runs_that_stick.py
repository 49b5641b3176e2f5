"""A rig with more friction than its profile says runs to the end of an experiment, and says so."""

import json
from pathlib import Path

import pytest

import rig
from rig.cli.commands import invoke
from rig.experiment.ending import EXIT_FAULT, EXIT_MISSED

CONFIGS = str(Path(rig.__file__).parents[1] / "configs")
UNITS = {
    "cylinder-friction": (
        676733,
        "setpoint_gain: 0.002297, setpoint_offset: 985.6, monitor_gain: 0.003937, "
        "monitor_offset: 684.5, encoder_scale: 1.117e-4, encoder_offset: 1.403e-05, "
        "wire_offset: 9.782e-06, friction: 0.2814, stribeck: 0.08374, joint_zero: 7.345e-4, "
        "joint_scale: 4.327e-4",
    ),
    "joint-circle": (
        692286,
        "setpoint_gain: 0.001064, setpoint_offset: 870.5, monitor_gain: 8.386e-4, "
        "monitor_offset: 664.9, encoder_scale: 9.117e-4, encoder_offset: 8.145e-05, "
        "wire_offset: 4.449e-06, friction: 0.2955, stribeck: 0.1206, joint_zero: 0.001722, "
        "joint_scale: 9.064e-4",
    ),
}
"""Drawn units that quiet hours had stopped, though friction had grown by less than a third."""


def run(tmp_path, experiment, *settings):
    words = [word for setting in settings for word in ("--set", setting)]
    where = ["--configs", CONFIGS, "--out", str(tmp_path)]
    code = invoke(["run", experiment, "--on", "sim", "--no-report", *words, *where])
    (folder,) = tmp_path.iterdir()
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    return code, [event["message"] for event in events if event["kind"] == "sticks"], folder


@pytest.mark.parametrize("experiment", UNITS)
def test_friction_that_has_grown_by_a_third_stops_no_run(tmp_path, experiment):
    seed, bounds = UNITS[experiment]
    unit = f"simulation.seed={seed}", f"simulation.perturbation={{{bounds}}}"
    code, said, folder = run(tmp_path, experiment, *unit)
    assert code == EXIT_MISSED
    if experiment == "cylinder-friction":  # wires of the ring creep on, 1.4 mm behind
        (said,) = said
        assert "sticks and slips at" in said
        assert "`rig calibrate cylinder friction response`" in said
    metrics = json.loads((folder / "metrics.json").read_text())
    assert all(row["value"] is not None for row in metrics["metrics"]), "it was measured to the end"


def test_friction_that_keeps_rods_from_following_stops_it(tmp_path, capsys):
    code, said, _ = run(tmp_path, "joint-circle", "plant.friction_scale=2")
    assert (code, said) == (EXIT_FAULT, [])
    assert "has more friction than the profile says" in capsys.readouterr().err
