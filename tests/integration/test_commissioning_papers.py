"""The papers of an acceptance test: who took each step, who the devices are, and the seal."""

import random
import re

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.commissioning.page import write_page
from rig.commissioning.record import digest_of, load_record, write_record
from rig.commissioning.session import steps_of
from rig.commissioning.steps.identity import OnTheBus, SettingsReadBack
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError

PROFILE = load_profile("cylinder", REGISTRY, (), find_configs(None))


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Return a folder, and have a cylinder's test end after its first two steps."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").mkdir()
    monkeypatch.setattr("rig.commissioning.session.steps_of", lambda _: steps_of(PROFILE)[:2])
    return tmp_path / "configs"


def commission(*words):
    return invoke(["commission", "cylinder", *words])


def resumed(lab, monkeypatch, first, then):
    """Have one operator be interrupted after the first step, and another one take the second."""
    with monkeypatch.context() as patch:
        patch.setattr(SettingsReadBack, "perform", lambda *_: (_ for _ in ()).throw(_Pressed()))
        assert commission("--operator", first) == 130
    assert commission("--operator", then) == 0
    return load_record("cylinder", [lab])


class _Pressed(KeyboardInterrupt):
    """Ctrl-C."""


def test_each_step_keeps_who_took_it(lab, monkeypatch, capsys):
    record = resumed(lab, monkeypatch, "alice", "bob the <b>builder</b>")
    assert "--operator alice" in capsys.readouterr().err
    assert record["operator"] == "alice"
    assert {name: step["operator"] for name, step in record["steps"].items()} == {
        "bus": "alice", "identity": "bob the <b>builder</b>",
    }  # fmt: skip
    page = (lab / "commissioning/cylinder.html").read_text()
    rows = re.findall(r"<tr>.*?</tr>", page, re.DOTALL)
    [bus] = [row for row in rows if "Every node number" in row]
    [identity] = [row for row in rows if "Each device is reset" in row]
    assert "alice" in bus and "builder" not in bus
    assert "bob the &lt;b&gt;" in identity and "alice" not in identity
    assert "alice, bob the &lt;b&gt;builder" in page


def test_who_did_it_is_no_part_of_the_digest(lab, monkeypatch):
    record = resumed(lab, monkeypatch, "alice", "bob")
    digest = record["digest"]
    assert digest == digest_of(record["settings"], record["steps"])
    for step in record["steps"].values():
        step["operator"] = "carol"
    assert digest == digest_of(record["settings"], record["steps"])
    for step in record["steps"].values():  # as a record of before steps said so
        del step["operator"]
    assert digest == digest_of(record["settings"], record["steps"])
    step["measured"] = []
    assert digest != digest_of(record["settings"], record["steps"])
    page = write_page(lab, record, [OnTheBus(), SettingsReadBack()]).read_text()
    assert page.count("alice") == 3  # the circumstances, and whoever began it for each step


def test_the_page_says_who_the_devices_are_and_what_it_was_done_on(lab):
    assert commission() == 0
    record = load_record("cylinder", [lab])
    page = (lab / "commissioning/cylinder.html").read_text()
    assert "rehearsal in simulation" in page
    assert "virtual: rehearsal in simulation" in page
    chance = random.Random(5)
    serials = {name: chance.randrange(10, 1 << 32) for name in PROFILE.devices}
    said = record["steps"]["identity"]["facts"]["identities"]
    for name, serial in serials.items():
        said[name]["serial"] = serial
    said["chain"] = {"q1 serial": 7, "q1 firmware": 48, "q2 serial": 8}
    record["backend"] = "hardware"
    page = write_page(lab, record, [OnTheBus(), SettingsReadBack()]).read_text()
    assert "rehearsal" not in page
    rows = {
        cells[0]: cells[1:]
        for row in re.findall(r"<tr>.*?</tr>", page, re.DOTALL)
        if (cells := re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL))
    }
    for name, serial in serials.items():
        assert rows[name][2] == f"{serial} (0x{serial:X})"
        assert rows[name][3] == "65536 (0x10000)"
    assert rows["chain.q1"] == ["-", "-", "7", "48 (0x30)"]
    assert rows["chain.q2"][2:] == ["8", "-"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("how", ["cut", "edited"])
def test_a_record_whose_seal_does_not_fit_is_of_rig_commission(lab, capsys, how, seed):
    assert commission() == 0
    path = lab / "commissioning/cylinder.yaml"
    text = path.read_text()
    if how == "cut":
        text = text[: random.Random(seed).randrange(60, len(text) - 70)]
    else:
        text = text.replace("backend: virtual", "backend: hardware")
    path.write_text(text)
    with pytest.raises(ConfigurationError) as caught:
        load_record("cylinder", [lab])
    said = str(caught.value)
    assert "rig commission RIG --anew" in said and "calibrat" not in said
    told = {"cut": "was not written by rig commission", "edited": "it was not tested so"}
    assert told[how] in said
    capsys.readouterr()
    assert commission() == 2
    assert "calibrat" not in capsys.readouterr().err
    assert invoke(["explain", said.splitlines()[0]]) == 0
    assert "The record of an acceptance test" in capsys.readouterr().out
    assert commission("--anew") == 0
    load_record("cylinder", [lab])


def test_a_calibration_that_is_cut_short_is_of_rig_calibrate_still(tmp_path):
    folder = tmp_path / "configs" / "calibration" / "cylinder"
    folder.mkdir(parents=True)
    (folder / "regulators.yaml").write_text("values: {}\nprovenance: {}\n")
    with pytest.raises(ConfigurationError, match="was not written by rig calibrate"):
        load_profile("cylinder", REGISTRY, (), [tmp_path / "configs", *find_configs()])


def test_a_record_is_sealed_as_before(lab):
    assert commission() == 0
    record = load_record("cylinder", [lab])
    write_record(lab, {key: value for key, value in record.items() if key != "seal"})
    assert load_record("cylinder", [lab]) == record
