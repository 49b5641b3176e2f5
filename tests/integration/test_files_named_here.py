"""A command that lacks a name says which files lie here, and where a name is known that is not."""

import random
import shutil
from pathlib import Path

import pytest

from rig.cli import invoke

RIG = "extends: cylinder\ndevices: {regulators: {node: 3}}\n"
EXPERIMENT = "extends: cylinder-sine\nrig: ours.yaml\n"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def refused(capsys, *words):
    assert invoke([*words]) == 2
    return capsys.readouterr().err


def test_files_here_are_named_by_their_kind(capsys):
    for command in ("run", "check", "compare", "status"):
        assert "Here: " not in refused(capsys, command)
    Path("ours.yaml").write_text(RIG)
    Path("sine.yaml").write_text(EXPERIMENT)
    Path("notes.yaml").write_text("a: 1\n")
    assert "Which EXPERIMENT? Here: sine.yaml. There are: " in refused(capsys, "run")
    assert "Which EXPERIMENT? Here: sine.yaml. There are: " in refused(capsys, "compare")
    assert "Which RIG? Here: ours.yaml. There are: " in refused(capsys, "status")
    told = "Missing argument 'PROFILE|EXPERIMENT'. Here: ours.yaml, sine.yaml. `rig list`"
    assert told in refused(capsys, "check")


def test_no_more_files_are_named_than_help(capsys):
    count = random.Random(1).randint(13, 40)
    for number in range(count):
        Path(f"s{number:02}.yaml").write_text(EXPERIMENT)
    told = refused(capsys, "run")
    assert f"s11.yaml and {count - 12} more. There are: " in told


@pytest.mark.parametrize("command", ["report", "export", "rerun", "replay", "diff"])
def test_who_names_no_run_is_told_of_the_newest(capsys, command):
    assert "`latest` is the newest run" in refused(capsys, command)


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_name_that_another_folder_knows_is_told_with_it(capsys, monkeypatch, tmp_path, command):
    folder = Path("their lab") / "configs" / "experiments"
    folder.mkdir(parents=True)
    (folder / "swing.yaml").write_text(EXPERIMENT)
    told = refused(capsys, command, "swing")
    assert "their lab/configs/experiments/swing.yaml is looked for only where its configs" in told
    assert "cd 'their lab'" in told
    deep = tmp_path / "their lab" / "deep" / "er"
    deep.mkdir(parents=True)
    monkeypatch.chdir(deep)
    assert f"cd '{tmp_path / 'their lab'}'" in refused(capsys, command, "swing")
    shutil.rmtree(tmp_path / "their lab" / "configs")
    told = refused(capsys, command, "qzxw")
    assert f"names of your own are looked for in configs, which is not in {deep}" in told


def test_a_slip_is_told_the_nearest_name_alone(capsys):
    assert "looked for" not in refused(capsys, "run", "cylinder-sin")
