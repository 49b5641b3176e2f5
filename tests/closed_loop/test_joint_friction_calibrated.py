"""Friction of a joint that is calibrated behind late regulators, which nobody has told it of."""

import shutil

import pytest
import yaml

from drivers.sim.plants.settings import SEALS
from drivers.sim.plants.spherical_joint_settings import CONTACTS
from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.mechanisms.joint.calibration.ball_friction import belief_of

WITHIN = 0.2
"""Of what was drawn, sliding friction at base pressure: slides show up to 18 % more."""

DRAWN = [(1.86, 1.0, 0.0), (1.9, 0.67, 3.0), (0.6, 0.67, 3.0), (0.6, 1.5, -3.0), (1.84, 1.34, -1.5)]
"""Friction and bandwidth of the regulators over the profile's, dead time beyond it in ms."""


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "bandwidth", "late"), DRAWN)
def test_what_a_ring_that_sticks_takes_is_found(tmp_path, scale, bandwidth, late):
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    sets = [
        "simulation.seed=7", f"plant.friction_scale={scale}", "plant.friction_spread=0",
        f"plant.regulator.bandwidth={40.0 * bandwidth}",
        f"plant.regulator.dead_time={5.0 + late} ms",
    ]  # fmt: skip
    options = [word for one in sets for word in ("--set", one)]
    words = ["--configs", str(configs), "--out", str(tmp_path / "runs"), "--on", "sim", "--yes"]
    assert invoke(["calibrate", "joint", "friction", *words, *options]) == 0
    file = configs / "calibration" / "joint" / "joint.yaml"
    found = yaml.safe_load(file.read_text(encoding="utf-8"))["values"]["friction"]
    profile = load_profile("joint", REGISTRY, (), find_configs())
    base, usual = profile.mechanism_settings.base_pressure, belief_of(profile).usual
    seals, ball = SEALS["standard"], CONTACTS["standard"]

    def sliding(seals_take, ring, wire):
        return seals_take + belief_of(profile)._replace(ring=ring, wire=wire).shared * usual

    seals_take = 2.0 * scale * (seals.coulomb + seals.pressure * base)
    true = sliding(seals_take, scale * ball.ring, scale * ball.wire)
    took = sliding(float(found["coulomb"].split()[0]), found["ring"], found["wire"])
    assert took == pytest.approx(true, rel=WITHIN)
