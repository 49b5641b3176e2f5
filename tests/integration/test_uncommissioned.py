"""A rig that nobody commissioned is held back on hardware, unless somebody says why not.

The hardware is emulated nodes in virtual time, which the program takes for real ones.
"""

import json
import re
import shutil
import socket
from pathlib import Path

import numpy as np
import pytest

from rig.assembly import REGISTRY, Backend
from rig.cli import invoke
from rig.commissioning.permission import verdict_of
from rig.commissioning.record import load_record, new_record, write_record
from rig.commissioning.session import CommissioningFacts, begin
from rig.config import load_profile
from rig.runtime.log import read_log

COMMISSIONS = True
CONFIGS = Path(__file__).parents[2] / "configs"
GENERATOR = np.random.default_rng(2311)
SHORT = (
    "reference.tones=[{frequency: 1 Hz, periods: 2}]",
    "approach=0.3 s",
    "metrics={}",
    "loop.small_margin=a test",
    "cylinder.limits.stop_energy=1 J",
)


@pytest.fixture
def rig(tmp_path, pretended_hardware):
    """Return what runs an experiment on hardware that is none."""

    def run(*words, settings=SHORT):
        words = (*words, *(word for option in settings for word in ("--set", option)))
        code = invoke([
            "run", "cylinder-sine", "--no-report", "--on", "hardware", "--yes", "cylinder",
            "--configs", str(pretended_hardware), "--out", str(tmp_path / "runs"), *words,
        ])  # fmt: skip
        folders = sorted((tmp_path / "runs").iterdir()) if (tmp_path / "runs").exists() else []
        return code, folders[-1] if folders else None

    run.configs = pretended_hardware
    return run


def said(folder):
    lines = (folder / "events.jsonl").read_text().splitlines()
    return [e["message"] for e in map(json.loads, lines) if e["kind"] == "commissioning"]


def truth(folder):
    """Return the greatest speed that was asked for, and the greatest pressure of a chamber."""
    log = read_log(folder / "log.mcap")
    speed = np.abs(log.column("reference.velocity")).max()
    pressure = max(log.column(f"truth.pressure_{s}").max() for s in ("agonist", "antagonist"))
    return float(speed), float(pressure)


@pytest.fixture(scope="module")
def passed(tmp_path_factory):
    """Return the folder of a record, and its page, of a rig that passed in simulation."""
    folder = tmp_path_factory.mktemp("passed")
    configs = folder / "configs"
    shutil.copytree(CONFIGS, configs, ignore=shutil.ignore_patterns("calibration", "commissioning"))
    words = ["--configs", str(configs), "--out", str(folder / "runs")]
    assert invoke(["commission", "cylinder", *words, "--set", SHORT[-1]]) == 0
    return configs / "commissioning"


@pytest.fixture
def commissioned(rig, passed):
    """Return what writes a record as if the rig had passed on hardware."""

    def write(**changes):
        shutil.copytree(passed, rig.configs / "commissioning", dirs_exist_ok=True)
        record = load_record("cylinder", [rig.configs])
        content = {key: record[key] for key in record if key not in ("seed", "seal")}
        write_record(rig.configs, {**content, "backend": "hardware", **changes})
        return content["digest"]

    return write


def test_it_moves_at_a_quarter_of_its_speed_and_says_what_is_missing(rig, capsys):
    code, whole = rig("--uncommissioned", "the stops were tried yesterday")
    assert code == 0
    assert "the stops were tried yesterday" in said(whole)[0]
    code, slow = rig()
    assert code == 0
    err = " ".join(capsys.readouterr().err.split())
    assert "never commissioned" in err and "first of them bus" in err
    file = rig.configs / "rigs" / "cylinder.yaml"
    assert f"rig commission {file} --on hardware" in said(slow)[0]
    fast_speed, _ = truth(whole)
    speed, pressure = truth(slow)
    assert speed < 0.5 * fast_speed
    assert pressure < 250e3


@pytest.mark.parametrize("command", ["compare", "sweep", "rerun"])
def test_every_command_that_moves_hardware_takes_the_reason(rig, tmp_path, command):
    """A comparison at a quarter of the speed would compare something else."""
    reason = ["--uncommissioned", "the stops were tried yesterday", "--yes", "cylinder"]
    on = ["cylinder-sine", "--on", "hardware", "--configs", str(rig.configs)]
    on += [word for option in SHORT for word in ("--set", option)]
    runs = tmp_path / "others"
    words = {
        "compare": [*on, "--controllers", "cascade", "--out", str(runs)],
        "sweep": [*on, "--serial", "--vary", "approach=0.3s,0.4s", "--keep", "all",
                  "--runs", str(runs)],
    }  # fmt: skip
    if command == "rerun":
        assert rig(*reason[:2])[0] == 0
        words["rerun"] = ["latest", "--runs", str(tmp_path / "runs"), "--out", str(runs)]
    assert invoke([command, *words[command], *reason]) == 0
    told = [said(events.parent) for events in runs.rglob("events.jsonl")]
    assert told
    assert all("the stops were tried yesterday" in sentences[0] for sentences in told)


def test_a_commissioned_rig_has_all_of_it_until_something_changes(rig, commissioned, capsys):
    digest = commissioned()
    assert re.fullmatch("[0-9a-f]{8}", digest)
    code, folder = rig()
    assert code == 0
    assert said(folder) == [f"commissioning {digest}"]
    assert digest in capsys.readouterr().err
    assert digest in (rig.configs / "commissioning" / "cylinder.html").read_text()
    code, folder = rig("--set", f"devices.encoder-agonist.stroke={GENERATOR.integers(61, 70)} mm")
    assert code == 0
    assert "changed since" in said(folder)[1]


def test_a_simulation_says_of_which_profile_the_digest_is(rig, commissioned, capsys):
    digest = commissioned()
    code, folder = rig("--on", "sim")
    assert code == 0
    assert said(folder) == [f"commissioning {digest}"]
    code, folder = rig("--on", "sim", "--set", "devices.encoder-agonist.stroke=65 mm")
    assert code == 0
    told = f"commissioning {digest}, of another profile: this one was changed since"
    assert said(folder) == [told]
    assert told in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"valid_until": "2020-01-01"}, "expired on 2020-01-01"),
        ({"backend": "virtual"}, "not on"),
        ({"host": "lab-of-others"}, "with another computer (lab-of-others; this is"),
    ],
)
def test_what_expired_or_was_simulated_holds_back(rig, commissioned, changes, words):
    commissioned(**changes)
    code, folder = rig()
    assert code == 0
    assert words in said(folder)[-1]


def test_a_record_that_came_along_with_a_copied_folder_is_begun_anew(rig, commissioned):
    """Its wake-ups and its wires were another computer's; one of before does not say whose."""
    commissioned()
    here = CommissioningFacts("hardware")
    mine = load_profile(str(rig.configs / "rigs" / "cylinder.yaml"), REGISTRY, SHORT[-1:])

    def steps():
        return begin(mine, [rig.configs], here, anew=False)["steps"]

    assert steps()
    commissioned(host=socket.gethostname())
    assert steps()
    assert verdict_of(mine, Backend.HARDWARE, [rig.configs]).lack == ""
    commissioned(host="lab-of-others")
    assert steps() == {}
    assert new_record(mine, "hardware", "me", "2099-01-01")["host"] == socket.gethostname()
    assert "host" not in new_record(mine, "virtual", "me", "2099-01-01")


def test_a_step_that_is_missing_is_named(rig, commissioned):
    commissioned()
    content = dict(load_record("cylinder", [rig.configs]))
    lost = str(GENERATOR.choice(list(content["steps"])))
    del content["steps"][lost]
    write_record(rig.configs, content)
    _, folder = rig()
    assert f"lacks {lost}" in said(folder)[-1]


def test_a_record_that_was_changed_by_hand_is_refused(rig, commissioned, capsys):
    commissioned()
    path = rig.configs / "commissioning" / "cylinder.yaml"
    path.write_text(path.read_text().replace("passed: true", "passed: false", 1))
    assert rig()[0] == 2
    assert "changed after it was written" in capsys.readouterr().err
