"""Which experiments a rig without its own is broken in: those of rigs in the same world."""

from pathlib import Path

import pytest

from rig.faults.survey import experiments_of
from rig.hal import ConfigurationError

CONFIGS = Path(__file__).parents[3] / "configs"


def configs_with(tmp_path, **rigs):
    (tmp_path / "rigs").mkdir()
    for name, text in rigs.items():
        (tmp_path / "rigs" / f"{name}.yaml").write_text(f"name: {name}\n{text}")
    return tmp_path


def test_a_rig_with_its_own_has_no_others():
    own = experiments_of("legs-stairs", CONFIGS)
    assert own == ("legs-stairs",)


@pytest.mark.parametrize(
    ("plant", "shares"), [("", True), ("plant: {terrain: []}\n", False)], ids=["flat", "other"]
)
def test_one_without_has_those_of_the_same_plant(tmp_path, plant, shares):
    legs = CONFIGS / "rigs" / "legs.yaml"
    configs = configs_with(tmp_path, mine=f"extends: {legs}\n{plant}")
    (tmp_path / "experiments").mkdir()
    (tmp_path / "experiments" / "walk.yaml").write_text(
        f"extends: {CONFIGS / 'experiments' / 'legs-walk.yaml'}\nname: walk\nrig: theirs\n"
    )
    (tmp_path / "rigs" / "theirs.yaml").write_text(f"extends: {legs}\nname: theirs\n")
    if shares:
        assert "walk" in experiments_of("mine", configs)
    else:
        with pytest.raises(ConfigurationError, match="no experiment runs on mine"):
            experiments_of("mine", configs)


def test_stairs_are_not_climbed_where_there_are_none():
    assert "legs-walk" in experiments_of("legs-can", CONFIGS)
    assert "legs-stairs" not in experiments_of("legs-can", CONFIGS)
