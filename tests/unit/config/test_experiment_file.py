"""Experiment files."""

import pytest
from config_fakes import SineSettings, StepSettings, Tone

from rig.config import MetricSpec, ProfileError, dump_resolved


def test_an_experiment_is_plain_data_in_si(configs):
    experiment = configs.experiment()
    assert (experiment.name, experiment.rig, experiment.controller) == (
        "bench-sine",
        "bench",
        "cascade",
    )
    assert experiment.approach == 1.5
    assert experiment.reference.kind == "sine"
    assert experiment.reference.settings == SineSettings(8e-3, (Tone(0.1), Tone(0.2, 5)))
    assert experiment.metrics == {
        "tracking_rms": MetricSpec(segments="0.2 Hz", max=0.15e-3, unit="m"),
        "hold": MetricSpec(measure="hold_rms", min=0.0, max=30e-6, unit="m"),
        "settling": MetricSpec(),
    }
    assert experiment.figures == ("position", "pressures")


def test_round_trip(configs):
    experiment = configs.experiment()
    path = configs.write("runs/1/experiment.yaml", dump_resolved(experiment))
    assert configs.experiment(path) == experiment


def test_extending_with_another_reference(configs):
    text = "extends: bench-sine\nreference: {kind: step, height: 5 mm}\n"
    configs.write("experiments/step.yaml", text)
    step = configs.experiment("step")
    assert step.reference.settings == StepSettings(5e-3)
    assert step.metrics == configs.experiment().metrics


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("controller: cascade", "controller: cascda", "3:13: no controller is called 'cascda'"),
        ("rig: bench\n", "", "key 'rig' is missing"),
        ("kind: sine", "kind: sinus", "did you mean sine?"),
        ("amplitude: 8 mm", "amplitude: 8 deg", "'8 deg' is not in m"),
        ("frequency: 0.1 Hz", "frequency: -0.1 Hz",
         "tones.0.frequency is '-0.1 Hz', expected at least"),
        ("    - {frequency: 0.1 Hz}\n    - {frequency: 0.2 Hz, periods: 5}", "    []",
         "at least 1"),
        ("max: 0.15 mm", "max: 0.15 furlong", "max: '0.15 furlong': 'furlong' is not a unit"),
        ("max: 30 µm", "max: 30 µm, unit: s", "max is in m, but the unit is 's'"),
        ("min: 0, max", "min: 1, max", "min (1) is above max (3e-05)"),
        ("segments: ", "segmens: ", "did you mean segments?"),
        ("approach: 1500 ms", "approach: 0", "approach is 0, expected at least"),
        ("figures: [position, pressures]", "figures: position", "expected a list"),
        ("reference:\n", "reference: 5\nrefernce:\n", "reference is 5, expected a mapping"),
    ],
)  # fmt: skip
def test_one_error(configs, old, new, expected):
    configs.edit(old, new, "experiments/bench-sine.yaml")
    with pytest.raises(ProfileError) as caught:
        configs.experiment()
    assert expected in str(caught.value)


def test_a_controller_may_be_called_a_law(configs):
    path = configs.write(
        "experiments/law.yaml",
        "name: law\nrig: bench\nlaw: cascade\nreference: {kind: step, height: 5 mm}\n",
    )
    assert configs.experiment(path).controller == "cascade"
    assert configs.experiment("bench-sine", "law=pid").controller == "pid"
    both = configs.write("experiments/both.yaml", "extends: bench-sine\nlaw: pid\n")
    with pytest.raises(ProfileError, match="law and controller name the same thing"):
        configs.experiment(both)
