"""A file that an experiment names is found beside it, told of when it is missing, and kept."""

import json
import shutil
from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import load_experiment, load_profile
from rig.config.dump import dump_resolved
from rig.config.names import find_configs
from rig.faults.scenario_file import load_scenario
from rig.sweeping.source import PointSource, freeze_configs, resolve
from rig.sweeping.sweep_file import load_sweep

TABLES = {
    "legs-footsteps": ("steps", "foot, x (mm), y (mm)\nleft, 30, 40\n"),
    "arm-path": ("points", "x (mm), y (mm), z (mm)\n20, 0, 0\n0, 0, 0\n-20, 10, 0\n"),
    "arm-twist": ("rows", "t (s), vx (mm/s), vy (mm/s), vz (mm/s)\n0, 0, 1, 0\n0.3, 0, 0, 0\n"),
}
"""What each kind has instead of a file, and a file for it."""


def lab_with(kind, tmp_path, monkeypatch):
    """Return an experiment and its table in a folder that is not where the user is."""
    lab, away = tmp_path / "lab", tmp_path / "away"
    lab.mkdir(), away.mkdir()
    instead, table = TABLES[kind]
    text = f"extends: {kind}\nreference:\n  {instead}: []\n  file: tables/mine.csv\n"
    (lab / "mine.yaml").write_text(text)
    (lab / "tables").mkdir()
    (lab / "tables" / "mine.csv").write_text(table)
    monkeypatch.chdir(away)
    return lab / "mine.yaml"


def loaded(path, *options):
    return load_experiment(path, REGISTRY, options, find_configs())


@pytest.mark.parametrize("kind", TABLES)
def test_a_file_is_found_from_the_experiment_on(kind, tmp_path, monkeypatch, capsys):
    experiment = lab_with(kind, tmp_path, monkeypatch)
    assert invoke(["check", "../lab/mine.yaml"]) == 0, capsys.readouterr().err
    named = loaded(Path("../lab/mine.yaml")).reference.settings.file
    assert named.is_absolute() and named.samefile(experiment.parent / "tables" / "mine.csv")


@pytest.mark.parametrize("kind", TABLES)
def test_a_missing_file_is_told_with_place_key_and_what_was_looked_for(
    kind, tmp_path, monkeypatch, capsys
):
    experiment = lab_with(kind, tmp_path, monkeypatch)
    table = experiment.parent / "tables" / "mine.csv"
    table.rename(table.with_name("mime.csv"))
    assert invoke(["check", str(experiment)]) == 2
    err = capsys.readouterr().err
    assert f"{experiment}:4:9: reference.file is 'tables/mine.csv'" in err
    assert f"there is no file {table}" in err and "did you mean mime.csv?" in err
    assert "Errno" not in err


def test_what_is_no_file_is_told(tmp_path, monkeypatch, capsys):
    experiment = lab_with("arm-path", tmp_path, monkeypatch)
    for value, said in (
        (".", f"{experiment.parent} is a folder, no file"),
        ("nowhere/mine.csv", f"there is no folder {experiment.parent / 'nowhere'} either"),
        ("3", "file is 3, expected the path of a file"),
        ("3.csv\0".strip("\0"), f"there is no file {experiment.parent / '3.csv'}"),
    ):
        text = f"extends: arm-path\nreference:\n  points: []\n  file: {value}\n"
        experiment.write_text(text)
        assert invoke(["check", str(experiment)]) == 2
        err = capsys.readouterr().err
        assert said in err and f"{experiment}:4:9" in err


def test_an_option_names_a_file_from_where_the_user_is(tmp_path, monkeypatch):
    experiment = lab_with("arm-path", tmp_path, monkeypatch)
    Path("here.csv").write_text(TABLES["arm-path"][1])
    named = loaded(experiment, "reference.file=here.csv").reference.settings.file
    assert named == tmp_path / "away" / "here.csv"


def test_a_list_is_taken_back_by_an_empty_one_as_the_hint_says(tmp_path, monkeypatch, capsys):
    experiment = lab_with("arm-path", tmp_path, monkeypatch)
    experiment.write_text("extends: arm-path\nreference: {file: tables/mine.csv}\n")
    assert invoke(["check", str(experiment)]) == 2
    told = f"to take back what the base gives, add `points: []` beside file in {experiment}:2:13"
    assert told in capsys.readouterr().err


def test_a_run_keeps_the_file_and_runs_again_from_its_folder_alone(tmp_path, monkeypatch, capsys):
    experiment = lab_with("arm-twist", tmp_path, monkeypatch)
    table = (experiment.parent / "tables" / "mine.csv").read_text()
    arguments = ["run", str(experiment), "--on", "sim", "--no-report", "--out", "runs"]
    assert invoke(arguments) in (0, 1), capsys.readouterr().err
    (run,) = Path("runs").iterdir()
    assert (run / "reference" / "file.csv").read_text() == table
    assert "reference/file.csv" in json.loads((run / "manifest.json").read_text())["files"]
    shutil.rmtree(experiment.parent)
    assert invoke(["rerun", str(run), "--no-report", "--out", "again"]) in (0, 1), (
        capsys.readouterr().err
    )
    (again,) = Path("again").iterdir()
    (run / "reference" / "file.csv").write_text("")
    assert (again / "reference" / "file.csv").read_text() == table


def test_runs_with_other_files_of_one_name_differ(tmp_path, monkeypatch, capsys):
    experiment = lab_with("arm-twist", tmp_path, monkeypatch)
    for last in ("0.3", "0.4"):
        table = TABLES["arm-twist"][1].replace("0.3", last)
        (experiment.parent / "tables" / "mine.csv").write_text(table)
        invoke(["run", str(experiment), "--on", "sim", "--no-report", "--out", "runs"])
    capsys.readouterr()
    first, second = sorted(map(str, Path("runs").iterdir()))
    invoke(["diff", first, second])
    assert "reference/file.csv" in capsys.readouterr().out


def test_a_sweep_copies_the_file_and_tells_points_apart_by_it(tmp_path, monkeypatch):
    experiment = lab_with("arm-path", tmp_path, monkeypatch)
    table = experiment.parent / "tables" / "mine.csv"
    names = set()
    for more in ("", "-40, 30, 0\n"):
        table.write_text(TABLES["arm-path"][1] + more)
        name = freeze_configs(str(experiment), None, tmp_path / "frozen")
        found = resolve(PointSource(name, (), None, "sim", "code"), (), tmp_path / "frozen")
        copy = tmp_path / "frozen" / "experiments" / "tables" / "mine.csv"
        assert found.experiment.reference.settings.file == copy
        assert copy.read_text() == table.read_text()
        names.add(found.name)
    assert len(names) == 2


def test_the_path_of_a_rig_is_found_from_the_file_that_says_it_on(tmp_path, monkeypatch, capsys):
    lab, away = tmp_path / "lab", tmp_path / "away"
    (lab / "rigs").mkdir(parents=True), away.mkdir()
    (lab / "rigs" / "own.yaml").write_text("extends: cylinder\ndescription: of the lab\n")
    (lab / "mine.yaml").write_text("extends: cylinder-step\nrig: rigs/own.yaml\n")
    (lab / "sweep.yaml").write_text("experiment: ./mine.yaml\nrig: rigs/own.yaml\nrepeat: 2\n")
    broken = "rig: rigs/own.yaml\nexperiment: ./mine.yaml\nfault: crash\n"
    (lab / "broken.yaml").write_text(broken)
    monkeypatch.chdir(away)
    assert invoke(["check", "../lab/mine.yaml"]) == 0, capsys.readouterr().err
    request = load_sweep(Path("../lab/sweep.yaml"))
    scenario = load_scenario(Path("../lab/broken.yaml")).scenario
    for one in (request, scenario):
        assert Path(one.experiment).samefile(lab / "mine.yaml")
        assert Path(one.rig).samefile(lab / "rigs" / "own.yaml")


def test_a_recording_of_a_camera_is_found_from_the_profile_on(tmp_path, monkeypatch):
    lab = tmp_path / "lab"
    lab.mkdir()
    source = "devices: {camera: {source: {kind: video, path: clip.avi}}}\n"
    (lab / "mine.yaml").write_text(f"extends: joint\n{source}")
    monkeypatch.chdir(tmp_path)
    profile = load_profile("lab/mine.yaml", REGISTRY, (), find_configs())
    assert profile.devices["camera"].settings.source.path == lab / "clip.avi"
    (tmp_path / "resolved.yaml").write_text(dump_resolved(profile))
    again = load_profile(tmp_path / "resolved.yaml", REGISTRY, (), find_configs())
    assert again.devices["camera"].settings.source.path == lab / "clip.avi"
    by_number = "devices.camera.source.kind=uvc", 'devices.camera.source.path="2"'
    camera = load_profile("lab/mine.yaml", REGISTRY, by_number, find_configs()).devices["camera"]
    assert camera.settings.device_path() == "/dev/video2"
