"""What a file extends: a file beside it, an installed one, and what is said if there is neither."""

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import load_profile
from rig.config.names import find_configs


def lab_of(tmp_path, monkeypatch, **files):
    """Write files to a folder that is not where the user is."""
    lab, away = tmp_path / "lab", tmp_path / "away"
    lab.mkdir(), away.mkdir()
    for written, text in files.items():
        name, _, suffix = written.partition("__")
        (lab / f"{name}.{suffix or 'yaml'}").write_text(text)
    monkeypatch.chdir(away)
    return lab


def description_of(path):
    return load_profile(path, REGISTRY, (), find_configs()).description


@pytest.mark.parametrize("base", ["cylinder", "bench", "bench__yml"])
def test_the_file_beside_is_the_base(base, tmp_path, monkeypatch):
    name = base.partition("__")[0]
    mine = f"extends: {name}\ncylinder: {{stroke: 150 mm}}\n"
    base_of = {base: "extends: cylinder\nloop: {rate: 400 Hz}\n"}
    lab = lab_of(tmp_path, monkeypatch, mine=mine, **base_of)
    assert load_profile(lab / "mine.yaml", REGISTRY, (), find_configs()).loop.rate == 400.0


def test_a_file_may_have_the_name_of_the_installed_one_that_it_extends(tmp_path, monkeypatch):
    lab = lab_of(tmp_path, monkeypatch, cylinder="extends: cylinder\ndescription: of the lab\n")
    assert description_of(lab / "cylinder.yaml") == "of the lab"
    (tmp_path / "away" / "configs" / "rigs").mkdir(parents=True)
    (lab / "cylinder.yaml").rename(tmp_path / "away" / "configs" / "rigs" / "cylinder.yaml")
    assert description_of("cylinder") == "of the lab"


@pytest.mark.parametrize(
    ("extends", "said"),
    [
        ("benhc", "no rig is called 'benhc'; did you mean bench?"),
        ("cylindr", "no rig is called 'cylindr'; did you mean cylinder?"),
        ("./bench", "bench; did you mean ./bench.yaml?"),
        ("mine", "no other rig is called 'mine'"),
    ],
)
def test_a_wrong_base_is_told_alone_with_the_right_name(
    extends, said, tmp_path, monkeypatch, capsys
):
    files = {"mine": f"extends: {extends}\n", "bench": "extends: cylinder\n"}
    lab = lab_of(tmp_path, monkeypatch, **files)
    assert invoke(["check", str(lab / "mine.yaml")]) == 2
    err = capsys.readouterr().err
    assert f"{lab / 'mine.yaml'}:1:10: extends: " in err and said in err
    assert "is missing" not in err  # it may stand in the base


def test_an_experiment_is_told_how_to_name_a_rig_beside_it(tmp_path, monkeypatch, capsys):
    files = {"mine": "extends: cylinder-step\nrig: bench\n", "bench": "extends: cylinder\n"}
    lab = lab_of(tmp_path, monkeypatch, **files)
    assert invoke(["check", str(lab / "mine.yaml")]) == 2
    err = capsys.readouterr().err
    assert f"for {lab / 'bench.yaml'} write rig: bench.yaml" in err
    (lab / "mine.yaml").write_text("extends: cylinder-step\nrig: bench.yaml\n")
    assert invoke(["check", str(lab / "mine.yaml")]) == 0


@pytest.mark.parametrize("words", [["calibrate"], ["status"], ["check"], ["faults", "list"]])
def test_a_rig_is_offered_for_the_name_of_a_file_that_is_not_here(
    words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    (tmp_path / "configs" / "rigs" / "bench.yaml").write_text("extends: cylinder\n")
    assert invoke([*words, "bench.yaml"]) == 2
    err = capsys.readouterr().err
    assert "no file bench.yaml here; did you mean the rig bench, configs/rigs/bench.yaml?" in err


@pytest.mark.parametrize(
    "words",
    [
        ["run", "cylinder-step", "--on", "sim", "--rig", "bench"],
        ["compare", "cylinder-step", "--on", "sim", "--rig", "bench"],
        ["sweep", "cylinder-step", "--on", "sim", "--rig", "bench", "--seeds", "0:2"],
        ["check", "bench"],
        ["run", "cylinder-step", "--on", "sim", "--set", "rig=bench"],
    ],
)
def test_a_file_here_is_offered_for_the_name_of_a_rig(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.yaml").write_text("extends: cylinder\n")
    assert invoke(words) == 2
    err = capsys.readouterr().err
    assert "did you mean the file bench.yaml?" in err and "there are" not in err
    if "--rig" in words:
        assert "--rig bench: no rig is called 'bench'" in err and "--set" not in err
