"""Encoders of a pair that are calibrated where friction and regulators are not as told yet."""

import random
import shutil

import pytest
import yaml

from rig.cli import invoke
from rig.config import find_configs

SIGMAS = 4.0
"""So many standard uncertainties may a value be off."""
ACCURATE = {"scale": 1e-3, "offset": 20e-6}
"""Standard uncertainty of fifteen levels over two thirds of the way, and of a caliper's zero, m."""

PLANTS = {
    "slow": {"regulator.bandwidth": "26.8 rad/s"},
    "slow, little friction": {"regulator.bandwidth": "26.8 rad/s", "friction_scale": 0.6},
    "late, little friction": {"regulator.dead_time": "10 ms", "friction_scale": 0.6},
    "coarse": {"regulator.hysteresis": 0.01, "regulator.dead_band": 0.005},
    "much friction": {"friction_scale": 1.9},
}
"""What the profile does not say; under the PID's own gains slow and late ones swung."""


def draw():
    """Each plant behind standard seals, and little friction behind low-speed ones."""
    chance = random.Random("encoders")
    for name, plant in PLANTS.items():
        marks = [] if name == "slow, little friction" else [pytest.mark.slow]
        yield pytest.param("cylinder", plant, chance.randrange(1000), id=name, marks=marks)
    little = {"friction_scale": 0.6}
    yield pytest.param("cylinder-low-speed", little, chance.randrange(1000), id="low-speed")


@pytest.mark.parametrize(("rig", "plant", "seed"), list(draw()))
def test_rods_come_to_rest_at_every_level(tmp_path, rig, plant, seed):
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    told = {"simulation.seed": seed, **{f"plant.{name}": value for name, value in plant.items()}}
    options = [word for name, value in told.items() for word in ("--set", f"{name}={value}")]
    words = ["--configs", str(configs), "--out", str(tmp_path / "runs"), "--on", "sim", "--yes"]
    assert invoke(["calibrate", rig, "encoders", *words, *options]) == 0
    for side in ("agonist", "antagonist"):
        file = configs / "calibration" / rig / f"encoder-{side}.yaml"
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
        found = {one["name"]: one for one in content["measured"]}
        for name, true in (("scale", 1.0), ("offset", 0.0)):
            assert found[name]["std"] < ACCURATE[name]
            assert abs(found[name]["value"] - true) < SIGMAS * found[name]["std"]
