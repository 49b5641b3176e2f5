"""`rig margins` as a person uses it: after `rig tune`, on the rig."""

import json
import re
import shlex
import shutil
from datetime import UTC, datetime, timedelta

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.calibration.store import write
from rig.cli import invoke
from rig.config import load_profile
from rig.config.names import find_configs
from rig.explaining.faults import refusal_topics

TARGET = "controllers.cascade"
QUICK = ("--on", "sim")


@pytest.fixture
def place(tmp_path, monkeypatch):
    for folder in find_configs(None):
        shutil.copytree(folder, tmp_path / "configs", dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def tuned(place, age, parent=None, **gains):
    """Put gains in force as `rig tune` does, so many days ago, over those of a date."""
    moment = (datetime.now(UTC) - timedelta(days=age)).isoformat(timespec="seconds")
    content = {
        "values": gains,
        "measured": [
            {"name": name, "value": gain, "unit": "", "std": 0.0, "interval": [gain, gain],
             "procedure": "tune"}
            for name, gain in gains.items()
        ],
        "provenance": {
            "procedure": "tune", "date": moment, "operator": "somebody", "backend": "profile",
            "profile": "rigs/cylinder.yaml", **({} if parent is None else {"parent": parent}),
        },
    }  # fmt: skip
    return write(place / "configs", "cylinder", TARGET, content, "tune")


def cascade(place):
    return load_profile("cylinder", REGISTRY, (), [place / "configs"]).controllers["cascade"]


def measured(capfd, *more):
    code = invoke(["margins", "cylinder", *QUICK, "--json", *more])
    out, err = capfd.readouterr()
    return code, json.loads(out) if code in (0, 1) else None, err


def test_a_loop_is_measured_and_kept_with_its_figure(place, capfd):
    code, found, err = measured(capfd)
    assert code == 0, err
    assert "before" not in found and found["put_back"] is None
    low, high = found["now"]["sensitivity"]["interval"]
    assert 1.2 < low < found["now"]["sensitivity"]["measured"] < high < 2.2
    (run,) = (place / "runs").glob("*-cylinder-margins-sim")
    kept = json.loads((run / "margins.json").read_text())
    assert kept["now"]["delay"] == found["now"]["delay"]
    assert (run / "figures" / "margins.png").stat().st_size > 10_000


def test_gains_that_are_worse_on_the_rig_are_taken_back(place, capfd):
    """By those of the profile at first, then by those that were tuned before."""
    own = cascade(place)
    file = tuned(place, 3.0, position_rate=165.0, velocity_rate=150.0)
    assert cascade(place).position_rate == 165.0
    code, found, err = measured(capfd)
    assert code == 1
    assert found["before"]["gains"] == "the profile's own"
    assert found["now"]["sensitivity"]["measured"] > found["before"]["sensitivity"]["measured"]
    assert "the tuned gains are nearer to instability on this rig" in err
    assert cascade(place) == own and not file.exists()

    tuned(place, 2.0, position_rate=100.0, velocity_rate=100.0)  # not over those taken back
    assert measured(capfd)[1]["before"]["gains"] == "the profile's own"
    softer = yaml.safe_load(file.read_text())["provenance"]
    tuned(place, 1.0, softer["date"], position_rate=165.0, velocity_rate=158.0)
    code, found, err = measured(capfd)
    assert code == 1 and found["before"]["gains"] == f"those of {softer['date']}"
    assert cascade(place).position_rate == 100.0
    assert yaml.safe_load(file.read_text())["provenance"]["date"] == softer["date"]


def test_gains_that_are_worse_stay_if_that_is_asked_for(place, capfd):
    tuned(place, 3.0, position_rate=165.0, velocity_rate=150.0)
    code, found, _ = measured(capfd, "--leave")
    assert code == 1 and found["put_back"] is None
    assert cascade(place).position_rate == 165.0


def test_gains_that_are_softer_than_before_stay_in_force(place, capfd):
    tuned(place, 3.0, position_rate=95.0, velocity_rate=95.0)
    code, found, err = measured(capfd)
    assert code == 0, err
    assert found["before"]["gains"] == "the profile's own"
    assert cascade(place).position_rate == 95.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("margins", "legs"), "the loops of legs cannot be measured"),
        (("margins", "cylindre"), "cylinder"),
        (("margins", "cylinder", "--controller", "pidd"), "no controller is called 'pidd'"),
    ],
)
def test_what_cannot_be_measured_is_a_sentence(words, said, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke(list(words)) == 2
    err = capfd.readouterr().err
    assert said in err and "Traceback" not in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("rig", ["arm", "legs"])
def test_nothing_is_advised_that_is_refused_itself(rig, capfd):
    assert invoke(["margins", rig]) == 2
    err = capfd.readouterr().err
    assert "rig tune" not in err and f"`rig compare EXPERIMENT --rig {rig}`" in err


def test_a_run_that_ends_in_a_fault_tells_no_margins(place, capfd):
    code = invoke(["margins", "cylinder", *QUICK, "--set", "plant.regulator.bandwidth=15 rad/s"])
    out, err = capfd.readouterr()
    assert code == 4 and "rig explain" in err and not out


def test_a_loop_that_is_not_told_is_a_bound_missed_with_a_way_on(place, capfd):
    """Glides at 4 mm/s stick: nobody's file or option is wrong."""
    slow = ("--set", "reference.speed=4 mm/s", "--set", "reference.repeats=4")
    assert invoke(["margins", "cylinder", *QUICK, *slow]) == 1
    out, err = capfd.readouterr()
    assert not out and "the loop cannot be told from noise" in err
    words = "rig margins cylinder --controller cascade --on sim --set 'reference.speed=4 mm/s'"
    assert f"{words} --set reference.repeats=4 --set reference.shake=0.15\n" in err
    assert "rig explain unknown_loop" in err

    assert invoke(["explain"]) == 0
    told = capfd.readouterr().out
    assert "not told: " in told and "kind: unknown_loop" in told and "went well" not in told
    assert "`rig margins cylinder --set reference.shake=0.15`" in " ".join(told.split())
    assert invoke(["status", "cylinder"]) in (0, 1)  # what was not told is no measurement
    assert "loop of cascade, measured" not in capfd.readouterr().out


def test_what_was_shaken_otherwise_is_said_with_what_it_told(place, capfd):
    """A pair that turns round while it is shaken tells little: that is no whole loop."""
    assert invoke(["margins", "cylinder", *QUICK, "--set", "reference.shake=0.6"]) == 0
    out, err = capfd.readouterr()
    told = re.search(r"greatest sensitivity from (\S+) Hz to (\S+) Hz alone \(at most 1.7\)", out)
    assert told, out
    assert f"is told from {told[1]} Hz to {told[2]} Hz alone" in err
    assert err.count("--controller cascade --on sim --set reference.shake=0.15\n") == 1
    assert invoke(["status", "cylinder"]) in (0, 1)
    said = " ".join(capfd.readouterr().out.split())
    assert f"from {told[1]} to {told[2]} Hz alone, with reference.shake=0.6" in said


def test_a_loop_that_is_not_told_is_said_to_programs_too(place, capfd):
    slow = ("--set", "reference.speed=4 mm/s", "--set", "reference.repeats=4")
    code, found, err = measured(capfd, *slow, "--set", "reference.shake=0.1")
    assert code == 1 and "cannot be told from noise" in found["untold"]
    assert "reference.shake=0.15" not in err  # it is less already


def test_what_is_advised_for_a_loop_that_is_not_told_runs_on_the_shipped_pair(place, capfd):
    """The topic advised a speed at which the glide of the shipped experiment is too short."""
    topic = next(topic for topic in refusal_topics() if topic.name == "unknown_loop")
    advised = re.findall(r"`rig margins RIG ([^`]+)`", dict(topic.remarks())["mend"])
    assert len(advised) == 2
    for words in advised:
        code, found, err = measured(capfd, *shlex.split(words))
        assert code == 0, err
        assert found["now"]["sensitivity"]["measured"] < 2.0
