"""Friction that is calibrated, on seals of every kind behind late regulators, by their truth."""

import random
import shutil

import pytest
import yaml

from drivers.sim.plants.settings import SEALS
from rig.cli import invoke
from rig.config import find_configs

RIGS = {"cylinder": "standard", "cylinder-low-speed": "low-speed"}
AREA = 181.4e-6
WITHIN = 0.06
"""Share by which wires, the seat and a monitor's error may have friction seem more or less."""


def calibrated(folder, rig, seed, scale):
    """Return the friction that `rig calibrate` writes, and the base pressure, SI."""
    configs = folder / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    words = ["--configs", str(configs), "--out", str(folder / "runs"), "--on", "sim", "--yes"]
    alike = "plant.friction_spread=0"  # what the unit differs by is none of the question
    sets = [f"simulation.seed={seed}", f"plant.friction_scale={scale}", alike]
    options = [word for one in sets for word in ("--set", one)]
    assert invoke(["calibrate", rig, "friction", *words, *options]) == 0
    file = configs / "calibration" / rig / "cylinder.yaml"
    found = yaml.safe_load(file.read_text(encoding="utf-8"))
    profile = yaml.safe_load((configs / "rigs" / f"{rig}.yaml").read_text(encoding="utf-8"))
    base = float(profile["cylinder"]["base_pressure"].split()[0]) * 1e3
    return found["values"]["friction"], base


def draw(count):
    """Each kind of seals as the profile has it, then with more and less friction."""
    for rig in RIGS:
        chance = random.Random(rig)
        for k in range(count):
            scale = 1.0 if k == 0 else round(chance.uniform(0.6, 1.6), 2)
            marks = [pytest.mark.slow] if k else []
            yield pytest.param(rig, chance.randrange(1000), scale, marks=marks)


@pytest.mark.parametrize(("rig", "seed", "scale"), list(draw(4)))
def test_what_the_seals_take_is_found(tmp_path, rig, seed, scale):
    friction, base = calibrated(tmp_path, rig, seed, scale)
    seals = SEALS[RIGS[rig]]
    seat = seals.seat * 2.0 * AREA * base
    for name, dry in (("coulomb", seals.coulomb), ("breakaway", seals.breakaway)):
        true = scale * (2.0 * (dry + seals.pressure * base) + seat)
        assert float(friction[name].split()[0]) == pytest.approx(true, rel=WITHIN)
