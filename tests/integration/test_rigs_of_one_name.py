"""Two profiles of one name in two folders: neither takes the other's calibrations or record."""

import json
import shutil
from datetime import date

import pytest

from rig.assembly import REGISTRY, Backend
from rig.calibration import store
from rig.calibration.recording import CalibrationRefused
from rig.cli import invoke
from rig.commissioning.permission import verdict_of
from rig.commissioning.record import new_record, write_record
from rig.commissioning.session import CommissioningFacts, begin
from rig.config import find_configs, load_experiment, load_profile
from rig.config.calibration_state import calibration_states
from rig.config.ownership import owner_label
from rig.experiment.permission import check_permitted
from rig.experiment.plan import make_plan
from rig.hal import ConfigurationError, DeviceError

ENCODER = "encoder-agonist"
TODAY = date(2026, 11, 26)


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A folder with two rigs called mine; the encoder of the first is calibrated."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").mkdir()
    (tmp_path / "other").mkdir()
    for path in ("mine.yaml", "other/mine.yaml"):
        (tmp_path / path).write_text("extends: cylinder\ndescription: ours\n")
    keep(load("mine.yaml"), "2026-11-21T10:00:00+00:00")
    return tmp_path


def load(path):
    return load_profile(path, REGISTRY, (), find_configs())


def keep(profile, date, owner=True):
    search = find_configs()
    label = {"profile": owner_label(profile.files, search)} if owner else {}
    provenance = {
        "procedure": "encoders", "date": date, "operator": "me", "backend": "hardware", **label,
    }  # fmt: skip
    content = {"values": {"offset": "1.5 mm"}, "measured": [], "provenance": provenance}
    store.write(search[0], "mine", ENCODER, content)


def offset(path):
    return load(path).devices[ENCODER].settings.offset


def plan_of(path):
    search = find_configs()
    experiment = load_experiment("cylinder-step", REGISTRY, [f"rig={path}"], search)
    return make_plan(experiment, load(path))


def test_only_the_rig_that_was_measured_is_calibrated(lab):
    assert (offset("mine.yaml"), offset("other/mine.yaml")) == (1.5e-3, 0.0)
    (state,) = calibration_states(load("other/mine.yaml"), TODAY)
    assert f"belongs to another rig: {lab / 'mine.yaml'}" in state.sentence
    (own,) = calibration_states(load("mine.yaml"), TODAY)
    assert own.problems == ()


def test_a_calibration_that_says_nothing_is_still_in_force(lab):
    keep(load("mine.yaml"), "2026-11-22T10:00:00+00:00", owner=False)
    assert (offset("mine.yaml"), offset("other/mine.yaml")) == (1.5e-3, 1.5e-3)


def test_a_folder_of_configurations_may_be_moved(lab, monkeypatch):
    (lab / "configs" / "rigs").mkdir()
    shutil.move(lab / "mine.yaml", lab / "configs" / "rigs")
    keep(load("mine"), "2026-11-22T10:00:00+00:00")
    assert offset("mine") == 1.5e-3
    assert offset("other/mine.yaml") == 0.0
    shutil.move(lab / "configs", lab / "elsewhere")
    assert offset("elsewhere/rigs/mine.yaml") == 1.5e-3


def test_simulation_warns_and_hardware_refuses(lab):
    plan = plan_of("other/mine.yaml")
    (doubt,) = check_permitted(plan, Backend.VIRTUAL)
    assert "belongs to another rig" in doubt
    with pytest.raises(DeviceError, match="belongs to another rig"):
        check_permitted(plan, Backend.HARDWARE)


def test_nothing_is_written_over_the_other_ones(lab):
    with pytest.raises(CalibrationRefused, match="belongs to another rig"):
        store.check_ours(load("other/mine.yaml"), [ENCODER])
    store.check_ours(load("mine.yaml"), [ENCODER])


def test_whoever_restores_a_calibration_takes_it_over(lab, capsys):
    restore = ["calibrate", "other/mine.yaml", "--restore", f"{ENCODER}/2026-11-21"]
    assert invoke(restore) == 0
    assert (offset("mine.yaml"), offset("other/mine.yaml")) == (0.0, 1.5e-3)
    assert invoke(["calibrate", "mine.yaml", "--restore", f"{ENCODER}/2026-11-21"]) == 0
    assert offset("mine.yaml") == 1.5e-3


@pytest.mark.parametrize("rig", ["mine", "mine.yaml", "./mine.yaml", "other/mine.yaml"])
def test_what_is_kept_is_found_by_a_name_and_by_a_file(lab, capsys, rig):
    assert invoke(["calibrate", rig, "--history", ENCODER]) == 0
    assert "2026-11-21" in capsys.readouterr().out
    assert invoke(["calibrate", rig, "--restore", ENCODER]) == 0
    assert invoke(["calibrate", rig, "--diff", ENCODER, ENCODER]) == 0


def test_status_says_whose_the_calibration_is(lab, capsys):
    assert invoke(["status", "other/mine.yaml", "--json"]) == 0
    stages = {at["what"]: at["state"] for at in json.loads(capsys.readouterr().out)["stages"]}
    assert f"belongs to another rig: {lab / 'mine.yaml'}" in stages["calibrated: encoders"]


def test_an_acceptance_record_is_of_one_rig(lab):
    search = find_configs()
    mine, other = load("mine.yaml"), load("other/mine.yaml")
    write_record(search[0], new_record(mine, "hardware", "me", "2099-01-01", search))
    assert "lacks" in verdict_of(mine, Backend.HARDWARE).lack
    assert f"another rig: {lab / 'mine.yaml'}" in verdict_of(other, Backend.HARDWARE).lack
    with pytest.raises(ConfigurationError, match="belongs to another rig"):
        begin(other, search, CommissioningFacts("hardware"), anew=False)
    begin(mine, search, CommissioningFacts("hardware"), anew=False)
    begin(other, search, CommissioningFacts("hardware"), anew=True)
