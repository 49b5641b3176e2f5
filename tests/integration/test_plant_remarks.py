"""`rig check` warns of a plant that is another rig than the controllers are told of."""

import re
from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.cli.plant_remarks import plant_remarks
from rig.config import find_configs, load_profile

CONFIGS = Path(__file__).parents[2] / "configs"
RIGS = sorted(path.stem for path in (CONFIGS / "rigs").glob("*.yaml"))


def remarks(rig, *options):
    return list(plant_remarks(load_profile(rig, REGISTRY, options, find_configs(CONFIGS))))


@pytest.mark.parametrize("rig", RIGS)
def test_no_shipped_rig_has_another_plant(rig):
    assert remarks(rig) == []


@pytest.mark.parametrize(
    ("rig", "option", "told"),
    [
        ("cylinder", "cylinder.moving_mass=0.5 kg", "cylinder.moving_mass is 0.5 kg, and"),
        (
            "cylinder",
            "plant.carriage.mass=0.3 kg",
            "plant.cylinder.mass (0.045 kg) together is 0.39 kg",
        ),
        ("cylinder", "plant.carriage.mass=0.3 kg", "plant.carriage.mass (0.3 kg) and twice"),
        ("cylinder", "plant.regulator.full_scale=900 kPa", "full_scale is 900 kPa"),
        ("joint", "plant.regulator.full_scale=900 kPa", "regulators is 500 kPa"),
    ],
)
def test_what_differs_is_told_with_both_numbers(rig, option, told, capsys):
    (said,) = remarks(rig, option)
    assert told in said
    assert invoke(["check", rig, "--set", option]) == 0
    assert f"warning: {said}" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["cylinder.moving_mass=0.145 kg", "plant.friction_scale=1.4"])
def test_what_differs_as_units_do_is_not_told(option):
    assert remarks("cylinder", option) == []


@pytest.mark.parametrize("coulomb", ["3 N", "33 N", "61 N"])
@pytest.mark.parametrize("rig", ["cylinder", "cylinder-low-speed", "joint", "joint-valves"])
def test_friction_that_differs_is_told_with_what_makes_it_alike(rig, coulomb):
    mechanism = rig.partition("-")[0]
    options = (
        f"{mechanism}.friction.coulomb={coulomb}",
        f"{mechanism}.friction.breakaway=70 N",
        f"{mechanism}.base_pressure=250 kPa",
    )
    (said,) = [line for line in remarks(rig, *options) if "friction" in line]
    assert f"{mechanism}.friction.coulomb is {coulomb}" in said
    (scale,) = re.findall(r"plant\.friction_scale: ([0-9.]+) makes", said)
    assert remarks(rig, *options, f"plant.friction_scale={scale}") == []


@pytest.mark.parametrize(
    ("asked", "near"),
    [("controllers.cascad", "controllers.cascade"), ("regulator", "regulators"),
     ("cylindr", "cylinder")],
)  # fmt: skip
@pytest.mark.parametrize("end", ["/profile", "/2026", ""])
def test_a_restore_of_what_a_rig_has_not_says_the_nearest(asked, near, end, capsys):
    assert invoke(["calibrate", "cylinder", "--restore", f"{asked}{end}"]) == 2
    assert f"did you mean {near}?" in capsys.readouterr().err
