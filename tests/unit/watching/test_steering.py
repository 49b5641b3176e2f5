"""What a page may ask of gains: within bounds, asked again where the loop would lack margin."""

import subprocess
import sys

import pytest

from rig.config import dump_resolved
from rig.experiment.plan import load_plan
from rig.run_folder import RunFolder
from rig.steering.mailbox import Mailbox
from rig.watching.steering import Steering


@pytest.fixture(scope="module")
def profile():
    return dump_resolved(load_plan("cylinder-ideal-sine").profile)


@pytest.fixture
def folder(tmp_path, profile):
    inputs = {"profile.yaml": profile}
    return RunFolder.create(tmp_path, "sine", "sim", inputs=inputs, law="cascade")


def gain(key, value, *, sure=False, ramp=1.0):
    return {"type": "gain", "key": key, "value": value, "ramp": ramp, "sure": sure}


def test_a_change_that_lacks_margin_is_asked_again(folder):
    steering = Steering(folder.path)
    with Mailbox(folder.path, create=True) as box:
        first = box.newest()
        # The shipped gains are stable by friction only, as `rig check` says of them.
        assert steering.answer(gain("position_rate", 110.0)).endswith("?")
        assert box.newest() == first
        assert "asked for" in steering.answer(gain("position_rate", 110.0, sure=True))
        assert box.read()[1:] == (0, 110.0, 1.0)


def test_gains_with_margin_are_not_asked_again(folder):
    steering = Steering(folder.path)
    with Mailbox(folder.path, create=True) as box:
        calm = {
            "position_rate": 30.0, "velocity_rate": 39.0, "disturbance_gain": 0.0,
            "integral": 130.0, "hold_integral": 10.0,
        }  # fmt: skip
        for key, value in calm.items():
            folder.record_event(1.0, "tuning", "", key=key, old=0.0, new=value, accepted=True)
        told = {one["key"]: one["value"] for one in steering.described()}
        assert told.items() >= calm.items()  # as the run's events say, not as the profile
        assert "asked for" in steering.answer(gain("position_rate", 28.0))
        assert box.read().value == 28.0


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("position_rate", 251.0, "has to be 2 … 250"),
        ("position_rate", -1.0, "has to be"),
        ("observer_bandwidth", 900.0, "no gain that may be changed"),
        ("__class__", 1.0, "no gain that may be changed"),
    ],
)
def test_what_may_not_be_never_reaches_the_box(folder, key, value, why):
    steering = Steering(folder.path)
    with Mailbox(folder.path, create=True) as box:
        assert why in steering.answer(gain(key, value, sure=True))
        assert box.newest() == 0


def test_without_a_box_nothing_is_steered(folder):
    said = Steering(folder.path).answer(gain("position_rate", 50.0, sure=True))
    assert said == "this run was not started with --steer"
    assert not (folder.path / "steering.box").exists()


def test_holding_on_is_counted(folder):
    steering = Steering(folder.path)
    with Mailbox(folder.path, create=True) as box:
        for _ in range(3):
            assert steering.answer({"type": "hold"}) is None
        assert box.beats() == 3


LOOK = """
import sys
from pathlib import Path
from rig.watching.steering import Steering

steering = Steering(Path(sys.argv[1]))
key, value = sys.argv[2], float(sys.argv[3])
print(steering.answer({"type": "gain", "key": key, "value": value, "ramp": 1.0, "sure": False}))
print(*{name.partition(".")[0] for name in sys.modules})
"""


@pytest.mark.parametrize(
    ("experiment", "key"),
    [("cylinder-ideal-sine", "position_rate"), ("joint-circle-camera", "pair.position_rate")],
)
def test_who_asks_for_margins_needs_no_compiler(tmp_path, experiment, key):
    """Which would take the page's server beyond the memory that it may have."""
    plan = load_plan(experiment)
    inputs = {"profile.yaml": dump_resolved(plan.profile)}
    law = plan.experiment.controller
    folder = RunFolder.create(tmp_path, "gains", "sim", inputs=inputs, law=law)
    with Mailbox(folder.path, create=True):
        command = [sys.executable, "-c", LOOK, str(folder.path), key, "110.0"]
        said, modules = subprocess.run(
            command, capture_output=True, text=True, check=True
        ).stdout.splitlines()
    assert said.endswith("?")
    assert not {"numba", "llvmlite", "filterpy", "matplotlib"} & set(modules.split())


def test_one_may_go_back_to_a_gain_that_is_beyond_the_usual_bounds(tmp_path):
    overrides = ("controllers.cascade.position_rate=260",)
    inputs = {"profile.yaml": dump_resolved(load_plan("cylinder-ideal-sine", overrides).profile)}
    folder = RunFolder.create(tmp_path, "gains", "sim", inputs=inputs, law="cascade")
    steering = Steering(folder.path)
    (described,) = [one for one in steering.described() if one["key"] == "position_rate"]
    assert (described["value"], described["low"], described["high"]) == (260.0, 2.0, 260.0)
    with Mailbox(folder.path, create=True) as box:
        assert "asked for" in steering.answer(gain("position_rate", 260.0, sure=True))
        assert box.read().value == 260.0
        assert "2 … 260" in steering.answer(gain("position_rate", 260.1, sure=True))
