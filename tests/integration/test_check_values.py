"""`rig check --values`: every setting with its value, and the place that says it."""

import json

import yaml

from rig.cli import invoke
from rig.config.calibration import seal

PROVENANCE = {
    "date": "2026-11-21T10:00:00+00:00", "operator": "A", "serial": None, "samples": 40,
    "residual_rms": 1e-6, "residual_max": 3e-6, "backend": "sim", "seed": 1,
}  # fmt: skip


def values(capsys, *words):
    capsys.readouterr()
    assert invoke(["check", *map(str, words), "--json"]) == 0
    return {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)}


def test_each_value_names_who_says_it(tmp_path, capsys):
    rigs = tmp_path / "rigs"
    rigs.mkdir()
    mine = rigs / "mine.yaml"
    mine.write_text(
        "extends: cylinder\ncylinder:\n  bore: 20 mm\nplant:\n  cylinder: {bore: 20 mm}\n"
    )
    folder = tmp_path / "calibration" / "mine"
    folder.mkdir(parents=True)
    content = {"values": {"offset": 1.5e-4}, "measured": {}, "provenance": PROVENANCE}
    overlay = folder / "encoder-agonist.yaml"
    overlay.write_text(seal(yaml.safe_dump(content, sort_keys=False)))
    found = values(capsys, mine, "--values", "--set", "loop.spin=true")
    expected = {
        "cylinder.bore": ("0.02", f"{mine}:3:3"),
        "devices.encoder-agonist.offset": ("0.00015", f"{overlay}:2:3"),
        "loop.spin": ("true", "--set loop.spin=true"),
        "loop.max_missed": ("5", "default"),
        "devices.regulators.channels.agonist.setpoint.voltage": ("0, 10", None),
        "cylinder.rod": ("0.005", None),
    }
    for name, (value, place) in expected.items():
        assert found[name]["value"] == value, name
        if place is None:  # of the file that it extends
            assert "configs/rigs/cylinder.yaml:" in found[name]["place"], name
        else:
            assert found[name]["place"] == place, name


def test_a_part_of_a_name_chooses(capsys):
    found = values(capsys, "joint", "--values", "loop.")
    assert found and all("loop." in name for name in found)
