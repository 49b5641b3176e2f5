"""Friction of pairs of other bores, whose seals, and whose regulators' hysteresis, are greater."""

import random
import shutil

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.assembly.simulated import make_plant
from rig.cli import invoke
from rig.config import find_configs, load_profile

WITHIN = {"coulomb": 0.1, "breakaway": 0.1}
"""Of the truth."""


def drawn():
    """The bore that stopped after 4.7 mm, the one that 30 N did not break away, and drawn ones."""
    yield pytest.param(25, {"regulator.hysteresis": 0.01}, 3, id="25 mm, coarse")
    much = {"friction_scale": 1.4, "tube.bore": "8 mm"}
    yield pytest.param(32, much, 5, id="32 mm, much friction")
    chance = random.Random("bores")
    for _ in range(10):
        plant = {
            "friction_scale": chance.uniform(0.6, 1.6),
            "regulator.bandwidth": f"{40.0 * chance.uniform(0.67, 1.5):.4g} rad/s",
        }
        bore, seed = chance.choice((16, 20, 25, 32)), chance.randrange(1000)
        name = f"{bore} mm, friction x {plant['friction_scale']:.2f}"
        yield pytest.param(bore, plant, seed, id=name, marks=pytest.mark.slow)


@pytest.mark.parametrize(("bore", "plant", "seed"), list(drawn()))
def test_friction_is_found_whatever_the_bore(tmp_path, bore, plant, seed):
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    told = {
        "simulation.seed": seed, "cylinder.bore": f"{bore} mm", "plant.cylinder.bore": f"{bore} mm",
        **{f"plant.{name}": value for name, value in plant.items()},
    }  # fmt: skip
    overrides = tuple(f"{name}={value}" for name, value in told.items())
    options = [word for one in overrides for word in ("--set", one)]
    words = ["--configs", str(configs), "--out", str(tmp_path / "runs"), "--on", "sim", "--yes"]
    assert invoke(["calibrate", "cylinder", "friction", *words, *options]) == 0
    file = configs / "calibration" / "cylinder" / "cylinder.yaml"
    found = {
        one["name"].rpartition(".")[2]: one["value"]
        for one in yaml.safe_load(file.read_text(encoding="utf-8"))["measured"]
    }
    true = truth(load_profile("cylinder", REGISTRY, overrides, find_configs()))
    for name, share in WITHIN.items():
        assert found[name] == pytest.approx(true[name], rel=share)
    # In a large bore the air in the tubes damps as well, more than the seals do.
    assert found["viscous"] > 0.8 * true["viscous"]
    if "tube.bore" in plant:
        assert found["viscous"] == pytest.approx(true["viscous"], rel=0.2)


def truth(profile):
    """Return what the chambers have to overcome: the seals, the seat, and what load adds."""
    plant = make_plant(profile)
    units, seat = plant.parameters, plant.pair_parameters[0]["seat"]
    base, area = profile.mechanism_settings.base_pressure, units["area"][0]
    loaded = units["pressure_friction"].sum() * base + 2.0 * seat * area * base
    share = 1.0 / (1.0 + seat * units["pressure_friction"].mean() / area)
    return {
        "coulomb": share * (units["coulomb"].sum() + loaded),
        "breakaway": share * (units["breakaway"].sum() + loaded),
        "viscous": share * units["viscous"].sum(),
    }
