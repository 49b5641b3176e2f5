"""The mechanism passes what every mechanism, law, motion, plant and servo bus must."""

from pathlib import Path

from rig.testing.devices import ServoBusSuite
from rig.testing.laws import LawSuite
from rig.testing.mechanisms import MechanismSuite
from rig.testing.motions import MotionSuite
from rig.testing.plants import PlantSuite

CONFIGS = Path(__file__).parents[1] / "configs"


class TestMyRig(MechanismSuite, MotionSuite, PlantSuite):
    """Its view in the loop, its motion and its physics."""

    configs, experiment = CONFIGS, "my-rig-turns"


class TestTrimmed(LawSuite):
    """Its law."""

    configs, experiment = CONFIGS, "my-rig-turns"


class TestDrives(ServoBusSuite):
    """Its drives."""

    configs, rig, device = CONFIGS, "my-rig-rig", "drives"
