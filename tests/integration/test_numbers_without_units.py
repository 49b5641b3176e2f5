"""A number without its unit is read as SI, and `rig check` says so where it may be a slip."""

import random
import re

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.config.names import list_files

RIGS = list_files("rigs", find_configs())
KEYS = [
    ("cylinder.base_pressure", "Pa", 1.5e5),
    ("cylinder.limits.reading_age", "s", 0.02), ("cylinder.moving_mass", "kg", 0.2),
    ("cylinder.limits.speed", "m/s", 0.5), ("devices.encoder-agonist.stroke", "m", 0.06),
    ("buses.can0.heartbeat_timeout", "s", 0.03), ("plant.regulator.supply_pressure", "Pa", 7e5),
]  # fmt: skip


def nested(key, value):
    *sections, last = key.split(".")
    lines = [f"{'  ' * depth}{section}:" for depth, section in enumerate(sections)]
    return "\n".join([*lines, f"{'  ' * len(sections)}{last}: {value}"]) + "\n"


@pytest.mark.parametrize("name", RIGS)
def test_shipped_profiles_say_their_units(name):
    assert load_profile(name, REGISTRY, (), find_configs()).unitless == ()


@pytest.mark.parametrize("seed", range(4))
def test_check_says_how_a_number_was_read(seed, tmp_path, capsys):
    key, unit, value = random.Random(seed).choice(KEYS)
    file = tmp_path / "mine.yaml"
    file.write_text(f"extends: cylinder\nname: mine\n{nested(key, value)}")
    assert invoke(["check", str(file)]) == 0
    told = capsys.readouterr()
    number = f"{value:g}"
    said = f"{key}: {number} has no unit and is read as {number} {unit} ({file}:"
    assert (told.err + told.out).count(said) == 1
    file.write_text(f"extends: cylinder\nname: mine\n{nested(key, f'{value} {unit}')}")
    assert invoke(["check", str(file)]) == 0
    told = capsys.readouterr()
    assert "has no unit" not in told.err + told.out


def test_lists_options_and_zero(tmp_path, capsys):
    said = "cylinder.limits.pressure=[0, 500000]"
    assert invoke(["check", "cylinder", "--set", said]) == 0
    told = capsys.readouterr()
    found = re.findall(r"\S+: \S+ has no unit and is read as \S+ Pa", told.err + told.out)
    assert found == ["cylinder.limits.pressure: 500000 has no unit and is read as 500000 Pa"]


def test_gains_have_no_second_unit():
    said = ("controllers.pid.proportional=1e8",)
    assert load_profile("cylinder", REGISTRY, said, find_configs()).unitless == ()


def test_a_file_that_a_program_wrote_is_told_of_once(tmp_path, capsys):
    assert invoke(["run", "cylinder-step", "--on", "sim", "--out", str(tmp_path)]) == 0
    capsys.readouterr()
    (profile,) = tmp_path.glob("*-sim/profile.yaml")
    assert invoke(["check", str(profile)]) == 0
    told = capsys.readouterr()
    text = told.err + told.out
    assert text.count("no unit") == 1
    assert "as programs write them" in text
