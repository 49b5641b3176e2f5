"""Who works in another folder than a rig was calibrated in is told where its records are."""

import json
import shutil

import pytest

from rig.assembly import REGISTRY
from rig.calibration import store
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.config.calibration import seal
from rig.config.records import sentences_of_records

RIGS = (find_configs()[-1] / "rigs").resolve()


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A profile with records beside it, made where somebody worked, and another place to work."""
    folder = tmp_path / "lab"
    folder.mkdir()
    text = (RIGS / "cylinder.yaml").read_text(encoding="utf-8")
    (folder / "mine.yaml").write_text(text.replace("name: cylinder", "name: mine"))
    keep(folder / "configs", "encoder-agonist", {"offset": "1.5 mm"}, folder / "mine.yaml")
    keep(folder / "configs", "controllers.pid", {"integral": 2e8}, folder / "mine.yaml")
    record = f"profile: {folder / 'mine.yaml'}\n"
    (folder / "configs" / "commissioning").mkdir()
    (folder / "configs" / "commissioning" / "mine.yaml").write_text(seal(record))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    return folder


def keep(configs, target, values, owner):
    provenance = {
        "procedure": "encoders", "date": "2026-11-21T10:00:00+00:00", "operator": "A",
        "backend": "hardware", "profile": str(owner),
    }  # fmt: skip
    entry = {"name": "x", "value": 1.0, "std": 0.1, "unit": "1", "procedure": "encoders",
             "date": "2026-11-21", "backend": "hardware", "valid_until": "9999-01-01"}  # fmt: skip
    content = {"values": values, "measured": [entry], "provenance": provenance}
    store.write(configs, "mine", target, content)


def told(lab):
    return (
        f"{lab / 'configs'} has calibrations (encoder-agonist), gains (pid), an acceptance record "
        f"of this rig, not in force here; use them with: cd {lab}"
    )


def sentences(path="../lab/mine.yaml"):
    profile = load_profile(path, REGISTRY, (), find_configs())
    return sentences_of_records(profile)


def test_status_check_and_run_say_where_they_are(lab, capsys):
    assert invoke(["status", "../lab/mine.yaml"]) == 0
    assert f"note: {told(lab)}\n" in capsys.readouterr().err
    assert invoke(["check", "../lab/mine.yaml", "--json"]) == 0
    assert told(lab) in json.loads(capsys.readouterr().out)["warnings"]
    words = (
        "--on",
        "sim",
        "--no-report",
        "--set",
        "reference.dwell=1 s",
        "--set",
        "reference.rise=0.2 s",
    )
    code = invoke(["run", "cylinder-step", "--rig", "../lab/mine.yaml", *words])
    assert code in (0, 1), capsys.readouterr().err
    (events,) = lab.parent.glob("elsewhere/runs/*/events.jsonl")
    assert told(lab) in events.read_text()


def test_nothing_is_said_where_they_are_in_force(lab, monkeypatch):
    monkeypatch.chdir(lab)
    assert sentences("mine.yaml") == []


def test_what_was_found_anew_here_is_not_missed(lab):
    here = find_configs()[0]
    keep(here, "encoder-agonist", {"offset": "1 mm"}, lab / "mine.yaml")
    (here / "commissioning").mkdir()
    shutil.copy(lab / "configs" / "commissioning" / "mine.yaml", here / "commissioning")
    (said,) = sentences()
    assert " has gains (pid) of this rig, not in force here" in said


def test_records_of_another_rig_of_that_name_are_not_offered(lab):
    for path in (lab / "configs").rglob("*.yaml"):
        path.write_text(path.read_text().replace("lab/mine.yaml", "lab/yours.yaml"))
    assert sentences() == []


def test_status_and_calibration_see_what_is_in_force_beside_a_profile_of_a_folder(lab, capsys):
    """A profile below `rigs` finds its calibrations from everywhere: every command sees them."""
    (lab / "configs" / "rigs").mkdir()
    rig = lab / "configs" / "rigs" / "mine.yaml"
    shutil.move(lab / "mine.yaml", rig)
    for target in ("encoder-agonist", "encoder-antagonist"):
        keep(lab / "configs", target, {"offset": "1.5 mm"}, rig)
    assert invoke(["status", str(rig), "--json"]) == 0
    stages = {one["what"]: one["state"] for one in json.loads(capsys.readouterr().out)["stages"]}
    assert stages["calibrated: encoders"] == "2026-11-21, on hardware, until 9999-01-01"
    profile = load_profile(rig, REGISTRY, (), find_configs())
    assert store.in_force(profile, find_configs(), "encoder-agonist")["values"]


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (("status", "cylinder"), "rigs/cylinder.yaml"),
        (("check", "cylinder-step"), "experiments/cylinder-step.yaml"),
        (("run", "cylinder-step"), "experiments/cylinder-step.yaml"),
        (("check", "../lab/extends.yaml"), "rigs/cylinder.yaml"),
        (("check", "../lab/step.yaml"), "rigs/cylinder.yaml"),
    ],
)
def test_a_folder_of_configurations_without_the_name_is_one_error(lab, words, kind, capsys):
    (lab / "empty").mkdir()
    # Keys that only make sense together with the base: none of them is an error of its own.
    (lab / "extends.yaml").write_text(
        "extends: cylinder\nplant: {encoder_noise: 1 um}\ndevices:\n"
        "  encoder-agonist: {max_speed: 2 m/s}\ncontrollers:\n  cascade: {integral: 1}\n"
    )
    shutil.copy(RIGS.parent / "experiments" / "cylinder-step.yaml", lab / "step.yaml")
    assert invoke([*words, "--configs", str(lab / "empty")]) == 2
    said = capsys.readouterr().err
    assert f"{lab / 'empty'} alone is looked in, by --configs; without that it is" in said
    assert kind in said and "errors" not in said and "missing" not in said
