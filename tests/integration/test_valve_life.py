"""What shakes valves is said before it moves: their life is counted in hours then."""

import json

import pytest
from explained import said

from rig.cli.commands import invoke


def warned(capsys, *words):
    assert invoke(["check", *words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["warnings"]
    return [sentence for sentence in told if "each valve" in sentence]


@pytest.mark.parametrize("source", ["joint-fine", "joint-circle-camera"])
def test_a_dither_that_turns_valves_round_is_told_with_what_it_leaves(capsys, source):
    (sentence,) = warned(capsys, source)
    assert sentence.startswith("controllers.cascade.path_dither shakes the setpoints at 52.6 Hz")
    assert "105 times a second" in sentence and "10 million cycles" in sentence
    assert "53 h" in sentence and "rig explain valve_reversals" in sentence
    none = ("--set", "controllers.cascade.path_dither.force=0 N")
    assert warned(capsys, source, *none) == []


def test_a_rig_that_shakes_nothing_is_not_warned_of(capsys):
    assert warned(capsys, "joint") == []


def test_the_measure_says_what_it_costs_and_whom_to_ask(capsys):
    code, out, _ = said(capsys, "valve_reversals")
    told = " ".join(out.split())
    assert code == 0 and "hours of its life" in told and "its maker knows" in told
    assert "turns of the busiest setpoint" in told and "`air_used`" in told
    assert round(10e6 * 2 / 106 / 3600) == 52 and "leave 52 h" in told


@pytest.mark.parametrize(("name", "kind"), [("joint-fine", "rig"), ("cylinder-step", "experiment")])
def test_a_rig_or_an_experiment_leads_to_its_check(capsys, name, kind):
    code, out, _ = said(capsys, name)
    assert code == 0 and out.startswith(f"{name} ({kind}): `rig check {name}`")
