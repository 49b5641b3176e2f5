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


@pytest.fixture
def own_plant(tmp_path, monkeypatch):
    """A profile in a folder of one's own whose plant no other rig has."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(
        "extends: cylinder\nplant: {cylinder: {bore: 25 mm, rod: 10 mm, stroke: 100 mm}}\n"
    )
    return tmp_path


def test_a_rig_that_nothing_runs_on_may_be_looked_at_in_what_its_mechanism_does(own_plant):
    with pytest.raises(ConfigurationError, match=r"no experiment runs on mine\.yaml"):
        experiments_of("mine.yaml", None)
    assert "cylinder-sine" in experiments_of("mine.yaml", None, any_world=True)
    assert "legs-walk" not in experiments_of("mine.yaml", None, any_world=True)


def test_an_experiment_beside_a_profile_that_names_it_is_its_own(own_plant):
    (own_plant / "track.yaml").write_text("extends: cylinder-sine\nrig: mine.yaml\n")
    (own_plant / "other.yaml").write_text("extends: cylinder-sine\nrig: cylinder\n")
    (own_plant / "broken.yaml").write_text("rig: [\n")
    assert experiments_of("mine.yaml", None) == ("track.yaml",)
    assert experiments_of("./mine.yaml", None) == ("track.yaml",)
