"""What was nearly said, and where what is meant stands."""

import random
import re

import pytest

from rig.cli import invoke
from rig.config.quantities import UnitError, parse_unit
from rig.explaining.glossary import glossary


def told(words, capsys, code=2):
    assert invoke(words) == code
    return capsys.readouterr().err


RIG, EXPERIMENT = "extends: cylinder\nname: {}\n", "extends: cylinder-sine\nname: {}\n"


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("command", "text"), [("check", RIG), ("run", EXPERIMENT)])
def test_the_nearest_file_is_named(command, text, seed, tmp_path, monkeypatch, capsys):
    chance = random.Random(f"{command} {seed}")
    name = "".join(chance.choices("bdfgkpqvwxz", k=7))
    file = tmp_path / f"{name}.yaml"
    file.write_text(text.format(name))
    monkeypatch.chdir(tmp_path)
    place = chance.randrange(1, 6)
    slip = name[:place] + name[place + 1 :]
    for wrong in (f"{slip}.yaml", f"{name}.yam", slip, f"./{slip}.yml"):
        assert f"did you mean the file {file.name}?" in told([command, wrong], capsys)


def test_a_name_that_is_known_is_nearer_than_a_file(tmp_path, monkeypatch, capsys):
    (tmp_path / "cylindrical-thing.yaml").write_text(RIG.format("thing"))
    monkeypatch.chdir(tmp_path)
    assert "did you mean cylinder?" in told(["check", "cylindr"], capsys)


def test_nothing_is_made_up_where_nothing_is_like_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert "cannot read no/where.yaml: No such file" in told(["check", "no/where.yaml"], capsys)


def test_what_an_experiment_refuses_of_a_profile_has_its_place(capsys):
    said = "cylinder.base_pressure=5 kPa"
    err = told(["run", "cylinder-sine", "--on", "sim", "--set", said], capsys)
    assert f"cylinder.base_pressure: --set {said}" in err
    assert re.search(r"cylinder\.limits\.pressure: \S+cylinder\.yaml:\d+:\d+", err)
    assert "metrics." not in err  # a measure of the same name is another thing


def test_where_of_no_runs_says_that_there_are_none(tmp_path, capsys):
    asked = ["list", "runs", "--out", str(tmp_path / "runs")]
    assert told(asked, capsys, 0) == f"there are no runs in {tmp_path / 'runs'}\n"
    err = told([*asked, "--where", "marker_rms < 1 mm"], capsys, 0)
    assert err == f"there are no runs in {tmp_path / 'runs'}, so --where finds none\n"


@pytest.mark.parametrize(("rig", "is_told"), [("cylinder", True), ("arm", False)])
def test_status_names_the_command_that_measures_margins(rig, is_told, tmp_path, capsys):
    assert invoke(["status", rig, "--out", str(tmp_path)]) == 0
    assert (f"rig margins {rig}" in capsys.readouterr().out) is is_told


def test_no_word_is_explained_by_its_unit_alone():
    def is_unit(text):
        try:
            return parse_unit(text.rstrip(".")) is not None
        except UnitError:
            return False

    poor = [f"{word.name}: {word.text}" for word in glossary() if is_unit(word.text)]
    assert poor == []
