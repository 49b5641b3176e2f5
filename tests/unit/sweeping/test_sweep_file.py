"""Sweep files: what they say, and all that is wrong with one at once, with its place."""

from pathlib import Path

import pytest

from rig.config.diagnostics import ProfileError
from rig.sweeping.stop_rule import StopRule
from rig.sweeping.sweep_file import load_sweep


def request_of(folder, text):
    path = Path(folder, "mine.yaml")
    path.write_text(text)
    return load_sweep(path)


def test_a_sweep_file_says_what_the_options_say(tmp_path):
    request = request_of(
        tmp_path,
        "experiment: cylinder-step\non: sim\nset: {approach: 1 s, figures: []}\n"
        "perturbation: {friction: 0.3}\nvary: {controller: [pid, cascade]}\nseeds: [3, 5]\n"
        "stop_when: tracking_rms < 0.1 mm\nbudget: 2 min\nkeep: all\nout: there\nrig:\n",
    )
    assert request.experiment == "cylinder-step"
    assert request.on == "sim"
    assert request.rig is None
    assert request.options == (
        "approach=1 s", "figures=[]", "simulation.perturbation.friction=0.3",
    )  # fmt: skip
    (axis,) = request.axes
    assert axis.texts == ("pid", "cascade")
    assert request.seeds.texts == ("3", "5")
    assert request.stop_when == StopRule("tracking_rms", "<", 1e-4, "m")
    assert (request.seconds, request.points) == (120.0, None)
    assert request.keep == -1
    assert request.out == Path("there")


def test_all_that_is_wrong_is_told_with_its_place(tmp_path):
    with pytest.raises(ProfileError) as refused:
        request_of(
            tmp_path,
            "experiment: [cylinder-step]\nseeds: 0..20\nperturbation: {friction: 3}\n"
            "vary: {plant.friction_scale: 1...2}\nworkers: two\nmetrics: tracking_rms\n",
        )
    told = str(refused.value)
    for line, words in {
        1: "experiment is", 2: "expected 0:20", 3: "perturbation.friction is 3, expected at most",
        4: "no such range", 5: "workers is 'two', expected a whole number",
        6: "unknown key 'metrics'",
    }.items():  # fmt: skip
        (message,) = (part for part in told.split("\n") if f"mine.yaml:{line}:" in part)
        assert words in message
    assert "did you mean metric?" in told


@pytest.mark.parametrize("bound", ["nan", "inf", "1e999", "small", "0.1 moles"])
def test_a_bound_that_nothing_keeps_is_refused(tmp_path, bound):
    with pytest.raises(ProfileError, match="stop_when: stop when"):
        request_of(tmp_path, f"experiment: x\nrepeat: 2\nstop_when: tracking_rms < {bound}\n")
