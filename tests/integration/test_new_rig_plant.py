"""A new rig's commented `plant:` has all that its cylinders' dimensions have to agree with."""

from pathlib import Path

import pytest

from rig.cli import invoke


def uncommented(text, key):
    """Return a profile whose section of a key holds: its lines are no comments any more."""
    lines, inside = [], False
    for line in text.splitlines():
        inside = line == f"# {key}:" or (inside and line.startswith("#   "))
        lines.append(line.removeprefix("# ") if inside else line)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("like", ["cylinder", "cylinder-ideal", "cylinder-valves", "joint"])
def test_a_commented_plant_has_the_lengths_that_the_mechanism_has(
    tmp_path, monkeypatch, capsys, like
):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", "rig", "mine", "--like", like]) == 0
    path = Path("mine.yaml")
    path.write_text(uncommented(path.read_text(), "plant"))
    assert "\n  cylinder: {stroke: 60 mm, bore: 16 mm, rod: 5 mm}" in path.read_text()
    capsys.readouterr()
    assert invoke(["check", "mine.yaml", "--values", "plant"]) == 0
    values = capsys.readouterr().out.splitlines()
    for key in ("home", "cylinder.stroke", "cylinder.bore", "cylinder.rod"):
        (line,) = [one for one in values if one.split()[0] == f"plant.{key}"]
        assert "mine.yaml:" in line, "the file itself says it"


def test_a_plant_without_cylinders_gets_none(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", "rig", "mine", "--like", "arm"]) == 0
    assert "cylinder" not in Path("mine.yaml").read_text()
