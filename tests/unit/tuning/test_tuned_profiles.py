"""Gains that were found, laid over a profile: who wins, and what a file of a stranger does."""

import shutil
from datetime import UTC, date, datetime

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.calibration.store import write
from rig.cli import invoke
from rig.config import ProfileError, dump_resolved, load_profile
from rig.config.calibration_state import calibration_states
from rig.config.names import find_configs

PROVENANCE = {
    "procedure": "tune", "operator": "somebody", "backend": "profile", "seed": 0,
    "date": datetime(2026, 11, 1, tzinfo=UTC).isoformat(timespec="seconds"),
}  # fmt: skip


@pytest.fixture
def configs(tmp_path):
    for folder in find_configs(None):
        shutil.copytree(folder, tmp_path / "configs", dirs_exist_ok=True)
    return tmp_path / "configs"


def put(configs, values, law="cascade", **provenance):
    content = {"values": values, "measured": [], "provenance": {**PROVENANCE, **provenance}}
    return write(configs, "cylinder", f"controllers.{law}", content, "tune")


def load(configs, *options, rig="cylinder"):
    return load_profile(rig, REGISTRY, options, [configs])


def test_gains_that_were_found_win_over_the_profile_and_lose_to_options(configs):
    before = load(configs).controllers["cascade"]
    put(configs, {"position_rate": 17.25, "feedforward": {"gain": 0.625}})
    now = load(configs).controllers["cascade"]
    assert (now.position_rate, now.feedforward.gain) == (17.25, 0.625)
    assert now.velocity_rate == before.velocity_rate
    assert now.feedforward.distance == before.feedforward.distance
    said = load(configs, "controllers.cascade.position_rate=9").controllers["cascade"]
    assert (said.position_rate, said.feedforward.gain) == (9.0, 0.625)
    assert load(configs, "calibration=false").controllers["cascade"] == before


def test_gains_of_one_law_and_rig_change_no_other(configs):
    others = load(configs).controllers["pid"], load(configs, rig="cylinder-low-speed").controllers
    put(configs, {"position_rate": 17.25})
    assert load(configs).controllers["pid"] == others[0]
    assert load(configs, rig="cylinder-low-speed").controllers == others[1]


def test_a_resolved_profile_has_the_gains_that_were_in_force_and_takes_no_others(configs):
    put(configs, {"position_rate": 17.25})
    (configs / "rigs" / "kept.yaml").write_text(dump_resolved(load(configs)))
    put(configs, {"position_rate": 99.0})
    kept = load(configs, rig=configs / "rigs" / "kept.yaml")
    assert kept.controllers["cascade"].position_rate == 17.25
    assert kept.tunings == {}


def test_a_wish_for_a_calibration_is_no_wish_for_gains(configs):
    with pytest.raises(ProfileError) as caught:
        load(configs, "calibration=true")
    assert "controllers." not in str(caught.value)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"position_rate": -3.0}, "position_rate"),
        ({"positon_rate": 3.0}, "positon_rate"),
        ({"feedforward": {"gain": "much"}}, "gain"),
        ({"observer_bandwidth": 1e9}, "observer_bandwidth"),
    ],
)
def test_a_gain_that_cannot_be_is_refused_where_it_stands(configs, values, said):
    path = put(configs, values)
    with pytest.raises(ProfileError) as caught:
        load(configs)
    assert path.name in str(caught.value)
    assert said in str(caught.value)


def test_gains_that_somebody_changed_by_hand_are_refused(configs):
    path = put(configs, {"position_rate": 17.25})
    path.write_text(path.read_text().replace("17.25", "117.25"))
    with pytest.raises(ProfileError, match="changed after it was written"):
        load(configs)


def test_check_shows_the_gains_in_force_and_calibrate_their_history(configs, capsys):
    put(configs, {"position_rate": 17.25})
    put(configs, {"position_rate": 18.0}, date="2026-11-05T00:00:00+00:00")
    assert invoke(["check", "cylinder", "--configs", str(configs)]) == 0
    assert "controllers.cascade" in capsys.readouterr().out
    of = ["calibrate", "cylinder", "--configs", str(configs)]
    assert invoke([*of, "--history", "controllers.cascade"]) == 0
    assert capsys.readouterr().out.count("tune") == 2
    assert invoke([*of, "--restore", "controllers.cascade/2026-11-01"]) == 0
    assert load(configs).controllers["cascade"].position_rate == 17.25


@pytest.mark.parametrize(
    ("backend", "fit"), [("profile", True), ("hardware", True), ("virtual", False), (None, False)]
)
def test_hardware_refuses_gains_that_rest_on_a_simulated_calibration(configs, backend, fit):
    path = put(configs, {"position_rate": 17.25}, backend=backend)
    assert yaml.safe_load(path.read_text())["provenance"]["backend"] == backend
    (state,) = calibration_states(load(configs), date(2026, 11, 2), on_hardware=True)
    assert (state.problems == ()) == fit
    rig = configs / "rigs" / "cylinder.yaml"
    assert f"rig tune {rig} --controller cascade" in state.remedy
