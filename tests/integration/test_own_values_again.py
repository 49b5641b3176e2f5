"""Back to the profile's own values: of one law whose gains were tuned, or of one device."""

import json
from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.calibration import put_back, store
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError

GAINS = "controllers.cascade"


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Tune one law twice and calibrate an encoder, in a folder of one's own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    text = (find_configs()[-1] / "rigs" / "cylinder.yaml").read_text(encoding="utf-8")
    (tmp_path / "configs" / "rigs" / "cylinder.yaml").write_text(text, encoding="utf-8")
    keep(GAINS, {"position_rate": 90.0}, "2026-11-20T10:00:00+00:00")
    keep(GAINS, {"position_rate": 100.0, "feedforward": {"gain": 0.5}}, "2026-11-21T10:00:00+00:00")
    keep("controllers.pid", {"integral": 2e8}, "2026-11-21T11:00:00+00:00")
    keep("encoder-agonist", {"offset": "1.5 mm"}, "2026-11-21T12:00:00+00:00")
    return tmp_path / "configs" / "calibration" / "cylinder"


def keep(target, values, date):
    provenance = {"procedure": "tune", "date": date, "operator": "A", "backend": "hardware"}
    content = {"values": values, "measured": [], "provenance": provenance}
    store.write(find_configs()[0], "cylinder", target, content)


def calibrate(*words):
    return invoke(["calibrate", "cylinder", *words])


def loaded():
    return load_profile("cylinder", REGISTRY, (), find_configs())


def test_the_gains_of_one_law_are_taken_back_and_put_in_force_again(lab, capsys):
    own = load_profile("cylinder", REGISTRY, ["calibration=false"], find_configs())
    assert calibrate("--restore", f"{GAINS}/profile") == 0
    assert "the profile's own values" in capsys.readouterr().err
    assert loaded().controllers["cascade"] == own.controllers["cascade"]
    assert loaded().controllers["pid"].integral == 2e8, "another law keeps its gains"
    assert loaded().devices["encoder-agonist"].settings.offset == 1.5e-3
    assert not (lab / f"{GAINS}.yaml").exists()
    assert calibrate("--restore", f"{GAINS}/2026-11-21") == 0
    assert loaded().controllers["cascade"].position_rate == 100.0


def test_a_device_goes_back_to_what_its_profile_says(lab):
    assert calibrate("--restore", "encoder-agonist/profile") == 0
    assert loaded().devices["encoder-agonist"].settings.offset == 0.0


def test_the_history_ends_with_the_profile_and_says_what_is_in_force(lab, capsys):
    def in_force():
        assert calibrate("--history", GAINS) == 0
        rows = capsys.readouterr().out.strip().splitlines()[2:]
        assert rows[-1].startswith("profile ") and "the profile's own values" in rows[-1]
        return [" yes " in row for row in rows]

    assert in_force() == [False, True, False]
    assert calibrate("--restore", f"{GAINS}/2026-11-20") == 0
    assert in_force() == [True, False, False]
    assert calibrate("--restore", f"{GAINS}/profile") == 0
    assert in_force() == [False, False, True]
    assert calibrate("--history", GAINS, "--json") == 0
    assert [one["in_force"] for one in json.loads(capsys.readouterr().out)] == [False, False]


def test_what_was_tuned_is_compared_with_the_profile(lab, capsys):
    assert calibrate("--diff", GAINS, "profile") == 0
    rows = [row.split() for row in capsys.readouterr().out.splitlines()]
    assert ["position_rate", "100", "rad/s", "114.7", "rad/s"] in rows
    assert ["feedforward.gain", "0.5", "0.7062"] in rows
    assert calibrate("--diff", "profile", f"history/{GAINS}/2026-11-20T100000Z", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["a"] == "profile"
    assert found["quantities"] == [{"name": "position_rate", "a": "114.7 rad/s", "b": "90 rad/s"}]
    assert calibrate("--diff", "encoder-agonist", "profile") == 0
    rows = [row.split() for row in capsys.readouterr().out.splitlines()]
    assert ["offset", "1.5", "mm", "0", "mm"] in rows


def test_what_is_not_kept_elsewhere_is_kept_when_it_is_taken_back(lab):
    """A file that was copied here without its history is not lost."""
    for kept in (lab / "history" / GAINS).iterdir():
        kept.unlink()
    assert calibrate("--restore", f"{GAINS}/profile") == 0
    (kept,) = (lab / "history" / GAINS).iterdir()
    assert store.load(kept)["values"]["position_rate"] == 100.0


def test_nothing_is_taken_back_twice_or_from_a_folder_of_others(lab, capsys):
    assert calibrate("--restore", f"{GAINS}/profile") == 0
    assert calibrate("--restore", f"{GAINS}/profile") == 2
    assert "the profile's own values are" in capsys.readouterr().err
    search = [Path("elsewhere"), lab.parents[1]]
    with pytest.raises(ConfigurationError, match="commands write into elsewhere only"):
        put_back.take_back(search, "cylinder", "controllers.pid")
    assert (lab / "controllers.pid.yaml").exists()
