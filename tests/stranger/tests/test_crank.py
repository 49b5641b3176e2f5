"""The crank passes what every mechanism, law, motion and plant must."""

from pathlib import Path

import crank_rig

from rig.testing.devices import ServoBusSuite
from rig.testing.laws import LawSuite
from rig.testing.mechanisms import MechanismSuite
from rig.testing.motions import MotionSuite
from rig.testing.plants import PlantSuite
from rig.testing.scenes import SceneSuite

CONFIGS = Path(crank_rig.__file__).parent / "configs"


class TestCrank(MechanismSuite, MotionSuite, PlantSuite, SceneSuite):
    configs, experiment = CONFIGS, "crank-turns"


class TestCrossCoupled(LawSuite):
    configs, experiment = CONFIGS, "crank-turns"


class TestIndependent(LawSuite):
    configs, experiment = CONFIGS, "crank-turns"
    options = ("controller=independent",)


class TestDrivesOnTheCrank(ServoBusSuite):
    configs, rig, device = CONFIGS, "crank", "drives"
