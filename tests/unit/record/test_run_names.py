"""Runs by name: the word for the newest one, alone or behind a folder of runs."""

import pytest

from rig.hal import ConfigurationError
from rig.run_names import MANIFEST, find_run, folder_of_latest


@pytest.fixture
def runs(tmp_path, monkeypatch):
    """Make two folders with runs, and be above them; return the first."""
    monkeypatch.chdir(tmp_path)
    for folder, days in {"runs": ("03", "07"), "others": ("09",)}.items():
        for day in days:
            run = tmp_path / folder / f"2026-11-{day}T100000Z-a-sim"
            run.mkdir(parents=True)
            (run / MANIFEST).touch()
    return tmp_path / "runs"


@pytest.mark.parametrize(
    ("word", "day"),
    [("latest", "07"), ("runs/latest", "07"), ("others/latest", "09"), ("./runs/latest", "07")],
)
def test_the_newest_run_is_found_by_its_word(runs, word, day):
    assert find_run(word).name == f"2026-11-{day}T100000Z-a-sim"


def test_the_word_is_no_file_and_hides_none(runs):
    """A folder that is called so is what its path says."""
    (runs / "latest").mkdir()
    assert folder_of_latest("runs/latest") is None
    assert find_run("runs/latest").name == "latest"
    assert find_run("latest").name == "2026-11-07T100000Z-a-sim"


@pytest.mark.parametrize("word", ["nowhere/latest", "runs/latests", "latest/x"])
def test_what_is_no_run_is_none(runs, word):
    with pytest.raises(ConfigurationError, match="no run is called"):
        find_run(word)


def test_a_folder_without_runs_has_no_newest_one(runs, tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ConfigurationError, match="there is no run in empty yet"):
        find_run("empty/latest")
