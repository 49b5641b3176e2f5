"""What commands keep of a shipped rig goes into `configs` where somebody works, and they say so."""

from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.commissioning.permission import configs_of
from rig.config import find_configs, load_profile
from rig.config.names import SHIPPED

BEFORE = sorted(SHIPPED.rglob("*"))


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """Work where there is no folder of configurations, and nothing is written into the program's.

    Another test of this process may write there, never one of these.
    """
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    assert sorted(SHIPPED.rglob("*")) == BEFORE


def test_a_calibration_is_written_here_and_found_again(here, capsys):
    words = ("--on", "sim", "--yes", "cylinder")
    assert invoke(["calibrate", "cylinder", "encoders", *words]) == 0
    said = capsys.readouterr().err
    assert f"in configs, which is made in {here}" in said
    written = here / "configs" / "calibration" / "cylinder" / "encoder-agonist.yaml"
    assert written.exists()
    entry = load_profile("cylinder", REGISTRY, (), find_configs()).devices["encoder-agonist"]
    assert entry.calibration is not None
    assert invoke(["calibrate", "cylinder", "encoders", "--dry-run"]) == 0
    said = capsys.readouterr().err
    assert "calibrations of cylinder in configs\n" in said
    assert "made in" not in said


def test_an_acceptance_record_is_kept_here(here, capsys, monkeypatch):
    places = []

    def commission(site, record, steps, configs, say, operator):
        places.append(configs)
        return "a step"

    monkeypatch.setattr("rig.commissioning.session.commission", commission)
    assert invoke(["commission", "cylinder"]) == 3
    assert places == [Path("configs")]
    assert f"is kept in configs, which is made in {here}" in capsys.readouterr().err


def test_gains_are_put_in_force_here(here, capsys, monkeypatch):
    def run(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("rig.tuning.search.GainSearch.run", run)
    assert invoke(["tune", "cylinder-ideal"]) == 130
    assert f"put in force in configs, which is made in {here}" in capsys.readouterr().err
    (here / "configs").write_text("no folder")
    assert invoke(["tune", "cylinder-ideal"]) == 2  # said before hours of search
    assert "cannot be kept in configs" in capsys.readouterr().err


def test_records_are_looked_for_where_they_are_written(here):
    usual = [Path("configs"), SHIPPED]
    assert list(find_configs()) == usual
    assert configs_of(load_profile("cylinder", REGISTRY, (), find_configs())) == usual

    rigs = here / "lab" / "rigs"
    rigs.mkdir(parents=True)
    for file in (rigs / "mine.yaml", here / "mine.yaml"):
        file.write_text((SHIPPED / "rigs" / "cylinder.yaml").read_text())
    of_a_folder = load_profile("mine", REGISTRY, (), find_configs(here / "lab"))
    assert configs_of(of_a_folder) == [here / "lab", Path("configs")]
    alone = load_profile("mine.yaml", REGISTRY, (), find_configs())
    assert configs_of(alone) == [Path("configs")]


def test_who_works_in_the_checkout_has_one_folder(monkeypatch):
    monkeypatch.chdir(SHIPPED.parent)
    assert find_configs() == (Path("configs"),)
