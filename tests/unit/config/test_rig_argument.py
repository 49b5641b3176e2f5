"""What names a rig on a command line: it must be found by what is said."""

import shlex

import pytest

from rig.config.names import find_configs, find_file, rig_argument


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    return tmp_path


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("configs/rigs/ours.yaml", "ours"),
        ("configs/rigs/ours.yml", "ours"),
        ("ours.yaml", "ours.yaml"),
        ("labs/two words.yaml", "'labs/two words.yaml'"),
        ("-ours.yaml", "./-ours.yaml"),
        ("../elsewhere.yaml", None),
    ],
)
def test_what_is_said_finds_the_file(here, place, said):
    file = here / place
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch()
    argument = rig_argument("ours", [file])
    assert said is None or argument == said
    words = shlex.split(argument)
    assert len(words) == 1
    found = find_file(words[0], "rigs", find_configs())
    assert found.resolve() == file.resolve()


def test_a_file_whose_name_another_one_takes_is_named_by_its_path(here):
    (here / "configs/rigs/ours.yaml").touch()
    (here / "ours.yaml").touch()
    assert rig_argument("ours", [here / "ours.yaml"]) == "ours.yaml"


def test_a_rig_that_no_file_holds_has_its_name(here):
    assert rig_argument("ours", []) == "ours"
