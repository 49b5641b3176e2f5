"""`rig.sweep`: what a Python program gives it, prints of it, and catches when it is interrupted."""

import math
import os
import random
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rig
from rig.sweeping.design import make_design
from rig.sweeping.run import check_axes
from rig.sweeping.source import PointSource, freeze_configs, resolve
from rig.sweeping.sweep_file import load_sweep

CONFIGS = Path(__file__).parents[2] / "configs"
pytestmark = pytest.mark.usefixtures("warm_workers")
SHORT = {
    "loop.rate": 200, "approach": "0.2 s", "reference.dwell": "0.3 s", "reference.repeats": 1,
}  # fmt: skip


def sweep(out, vary=None, **more):
    return rig.sweep(
        "cylinder-ideal-step",
        vary,
        **{"on": "sim", "set": SHORT, "out": out, "quiet": True, **more},
    )


def test_a_sweep_prints_as_a_table_of_its_best_points(tmp_path):
    scales = np.linspace(0.9, 1.1, 3)
    found = sweep(tmp_path / "s", {"plant.friction_scale": scales}, seeds=np.arange(2), workers=2)
    assert found.complete and len(found.table) == 6
    head, columns, *rows = repr(found).splitlines()
    assert head == "s: done, 6 of 6 points; best in rise_time:"
    assert columns.split()[:3] == ["plant.friction_scale", "simulation.seed", "status"]
    ordered = sorted(row["rise_time"] for row in found.table)
    assert found.best()["rise_time"] == ordered[0]
    assert rows[0].split()[0] == f"{found.best()['plant.friction_scale']}"
    assert len(rows) == 6
    for row, line in zip(sorted(found.table, key=lambda row: row["rise_time"]), rows, strict=True):
        assert ("never" in line) == math.isinf(row["settling_time"]) and "inf" not in line
    part = sweep(tmp_path / "part", seeds=range(4), budget="1 points", workers=1)
    assert not part.complete and repr(part).startswith("part: budget, 1 of 4 points")


# Python raises an interrupt that came during a file's opening before anybody has the file to close.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupted_sweep_is_an_exception_with_what_is_finished(tmp_path):
    least = random.Random(4).randrange(1, 4)

    def interrupt():
        journal = tmp_path / "points.jsonl"
        while not journal.exists() or journal.read_bytes().count(b"\n") < least:
            time.sleep(0.005)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(rig.SweepInterrupted, match=r"of 200 points.*goes on from there") as caught:
        sweep(tmp_path, seeds=range(200), workers=1)
    thread.join()
    assert isinstance(caught.value, KeyboardInterrupt) and isinstance(caught.value, rig.RigError)
    part = caught.value.sweep
    assert least <= len(part.table) < 200 and not part.complete
    assert repr(part).startswith(f"{tmp_path.name}: interrupted")
    assert len(sweep(tmp_path, seeds=range(least), workers=1).table) == least


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"seeds": range(10**12)}, "seeds: 1,000,000,000,000 values; an axis has 1 to 100,000"),
        ({"seeds": range(10**30)}, "seeds: .* values; an axis has"),
        ({"seeds": "0:1000000000000"}, "1000000000000 seeds; an axis has 1 to 100,000"),
        ({"vary": {"plant.friction_scale": range(10**12)}}, "friction_scale: 1,000,000,000,000 "),
        ({"seeds": 5}, "seeds is 5, and must be a text"),
        ({"seeds": (k for k in range(3))}, "seeds is <generator"),
        ({"seeds": []}, "expected 0:20"),
        ({"vary": ["a=1,2"]}, "vary is .* and must be a mapping"),
        ({"vary": {3: [1]}}, "vary: 3 is no name of a setting"),
        ({"vary": {"plant.friction_scale": 1.0}}, "expected a list of values"),
        ({"vary": {"plant.friction_scale": [object()]}}, "is no value of a setting"),
        ({"set": "loop.rate=200"}, "set is 'loop.rate=200', and must be a mapping"),
        ({"set": {"loop.rate": {1, 2}}}, "is no value of a setting"),
        ({"workers": "two"}, "workers is 'two', and must be a whole number"),
        ({"workers": True}, "workers is True"), ({"workers": 1.5}, "workers is 1.5"),
        ({"keep": None}, "keep is None"), ({"draw_seed": "1"}, "draw_seed is '1'"),
        ({"on": None}, "on is None"), ({"out": 3}, "out is 3, and must be a path"),
        ({"stop_when": 3}, "stop_when is 3"), ({"budget": 30}, "budget is 30"),
        ({"metric": 1}, "metric is 1"), ({"quiet": "yes"}, "quiet is 'yes'"),
        ({"on": "mars"}, "runs on one of sim, virtual; .*not on 'mars'"),
        ({"vary": {"plant.friction_scale": [1.0, "x"]}}, r"^vary={'plant.friction_scale': 'x'}: "),
        ({"vary": {"plant.friction_scale": "1..2"}}, r"^vary={'plant.friction_scale': '1..2'}: no"),
        ({"vary": {"planet.scale": [2]}}, r"^vary={'planet.scale': '2'}: there is no key 'planet'"),
        ({"set": {"loop.rate": "1 furlong"}}, r"^set={'loop.rate': '1 furlong'}: loop.rate: "),
    ],
)  # fmt: skip
def test_what_is_wrong_is_a_sentence_before_anything_runs(wrong, said, tmp_path):
    with pytest.raises(rig.ConfigurationError, match=said):
        sweep(**{"out": tmp_path / "s", "seeds": range(2), **wrong})
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize("file", sorted(CONFIGS.glob("sweeps/*.yaml")), ids=lambda file: file.stem)
def test_the_sweeps_that_we_ship_can_be(file, tmp_path):
    request = replace(load_sweep(file), configs=CONFIGS).checked()
    name = freeze_configs(request.experiment, request.configs, tmp_path)
    source = PointSource(name, request.options, request.rig, request.on, "any code")
    design = make_design(request.axes, request.seeds, request.draw_seed)
    check_axes(source, design, tmp_path)
    assert request.best in resolve(source, design.options(0), tmp_path).experiment.metrics


def test_an_experiment_is_a_name_or_a_path():
    with pytest.raises(rig.ConfigurationError, match="experiment is 3"):
        rig.sweep(3, seeds=range(2))
