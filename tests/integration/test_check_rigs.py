"""`rig check` shows every rig that is shipped, whatever its buses are."""

import json
from pathlib import Path

import pytest

from rig.cli import invoke

CONFIGS = Path(__file__).parents[2] / "configs"
RIGS = sorted(path.stem for path in (CONFIGS / "rigs").glob("*.yaml"))


@pytest.mark.parametrize("name", RIGS)
def test_every_rig_is_shown_to_people_and_to_programs(capsys, name):
    assert invoke(["check", name, "--configs", str(CONFIGS)]) == 0
    assert f"rig {name}" in capsys.readouterr().out
    assert invoke(["check", name, "--configs", str(CONFIGS), "--json"]) == 0
    profile = json.loads(capsys.readouterr().out)["profile"]
    assert profile["name"] == name
    for bus in profile["buses"]:
        assert bus["interface"]
        assert bus["channel"]
        assert bus["bitrate"] > 0
        assert 0.0 < bus["load"] <= bus["max_load"]


@pytest.mark.parametrize("name", RIGS)
def test_check_says_what_a_cut_wire_comes_to_and_what_an_alarm_is(capsys, name):
    """Servos have no wires."""
    assert invoke(["check", name, "--configs", str(CONFIGS)]) == 0
    shown = capsys.readouterr().out
    assert invoke(["check", name, "--configs", str(CONFIGS), "--json"]) == 0
    expected = json.loads(capsys.readouterr().out)["profile"]["expected"]
    pneumatic = name.startswith(("cylinder", "joint"))
    assert [item["unit"] for item in expected] == (
        ["m/s", "J", "Pa", "m/s", "J", "Pa", "N s/m", "Pa", "s", "Pa", "1", "Pa"]
        if pneumatic
        else []
    )
    assert ("what to expect if a part breaks" in shown) is pneumatic
    assert all(item["name"] in shown for item in expected)


@pytest.mark.parametrize(
    ("rig", "plant"), [("cylinder", "spherical-joint"), ("arm", "legs"), ("legs", "arm")]
)
def test_the_plant_of_another_mechanism_is_refused_before_anything_runs(capsys, rig, plant):
    of = ["check", rig, "--configs", str(CONFIGS), "--set", f"plant.model={plant}"]
    assert invoke(of) == 2
    assert f"plant.model {plant} is no plant of the mechanism {rig}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("experiment", "known"),
    [("cylinder-ideal-sine", True), ("joint-circle", True), ("arm-elbow-circle", False)],
)
def test_check_says_how_near_a_loop_is_to_instability_where_that_is_known(
    capsys, experiment, known
):
    assert invoke(["check", experiment, "--configs", str(CONFIGS)]) == 0
    shown, said = capsys.readouterr()
    assert ("the loop that" in shown) is known
    assert ("friction only" in said) == ("friction holds it" in shown)
    assert ("`rig tune cylinder" in said) is (experiment == "cylinder-ideal-sine")
    assert invoke(["check", experiment, "--configs", str(CONFIGS), "--json"]) == 0
    loop = json.loads(capsys.readouterr().out)["experiment"]["loop"]
    assert (loop is not None) is known
    if loop is not None:
        assert set(loop) == {"stable", "crossover", "phase", "delay", "sensitivity"}
        assert (loop["phase"] > 0.0) == loop["stable"]
        assert ("friction holds it" in shown) != loop["stable"]
