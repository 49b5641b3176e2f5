"""`rig faults run` of a rig of one's own says what it can be broken in; names are located."""

import json
from pathlib import Path

import pytest

from rig.cli import invoke

OTHER_PLANT = (
    "extends: cylinder\ncylinder: {stroke: 80 mm, home: 40 mm}\n"
    "devices: {encoder-agonist: {stroke: 80 mm}, encoder-antagonist: {stroke: 80 mm}}\n"
    "plant: {cylinder: {stroke: 80 mm}, home: 40 mm}\n"
)
NARROW = "extends: cylinder\ncylinder: {limits: {position: [-12 mm, 12 mm]}}\n"
NARROWEST = "extends: cylinder\ncylinder: {limits: {position: [-1 mm, 1 mm]}}\n"
CASE = (
    "rig: cylinder\nexperiment: cylinder-sine\nfault: leak\nwhere: plant agonist\nmagnitude: 2e-8\n"
)


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def refused(capsys, *words):
    assert invoke(["faults", "run", *words]) == 2
    assert not Path("faults").exists()
    return capsys.readouterr().err


def test_who_has_no_experiment_is_told_which_work(capsys):
    Path("mine.yaml").write_text(OTHER_PLANT)
    said = refused(capsys, "mine.yaml")
    assert "say one with --experiment NAME" in said
    (listed,) = [line for line in said.splitlines() if "what can be planned on it: " in line]
    first = listed.partition(": ")[2].split(",")[0]
    assert invoke(["faults", "run", "mine.yaml", "--experiment", first, "--only", "nothing"]) == 0


def test_where_none_fits_the_first_reason_is_told(capsys):
    Path("mine.yaml").write_text(NARROWEST)
    said = refused(capsys, "mine.yaml", "--random", "1")
    assert "no experiment runs on mine.yaml" in said
    assert "outside limits.position" in said


def test_what_does_not_fit_is_left_out_and_told(capsys):
    Path("mine.yaml").write_text(NARROW)
    assert (
        invoke(["faults", "run", "mine.yaml", "--only", "nothing", "--random", "3", "--json"]) == 0
    )
    shown = capsys.readouterr()
    (told,) = [line for line in shown.err.splitlines() if line.startswith("left out")]
    out = told.partition("mine.yaml: ")[2].partition(";")[0].split(", ")
    assert "cylinder-margins" in out
    done = {case["case"]["experiment"] for case in json.loads(shown.out)}
    assert done.isdisjoint(out)


def test_an_experiment_of_another_mechanism_is_told_those_of_this_one(capsys):
    said = refused(capsys, "cylinder", "--experiment", "joint-circle")
    assert "the reference is not one for a pair of cylinders" in said
    assert "what can be planned on it: cylinder-" in said


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("rig: cylinder", "rig: cylindr", "case.yaml:1:6: no rig is called 'cylindr'"),
        ("cylinder-sine", "cylinder-sin", "case.yaml:2:13: no experiment is called"),
        ("cylinder-sine", "./sin.yaml", "case.yaml:2:13: there is no file"),
        ("rig: cylinder", "rig: ./lab.yaml", "case.yaml:1:6: there is no file"),
    ],
)
def test_a_name_of_a_scenario_is_located_with_the_nearest_one(capsys, old, new, told):
    Path("sine.yaml").write_text("extends: cylinder-sine\n")
    Path("case.yaml").write_text(CASE.replace(old, new))
    said = refused(capsys, "case.yaml")
    assert told in said
    assert "did you mean" in said


def test_all_that_is_wrong_with_a_scenario_is_told_at_once(capsys):
    wrong = CASE.replace("cylinder\n", "cylindr\n").replace("-sine", "-sin")
    Path("case.yaml").write_text(wrong.replace("leak", "laek"))
    said = refused(capsys, "case.yaml")
    for place in ("1:6", "2:13", "3:8"):
        assert f"case.yaml:{place}: " in said
