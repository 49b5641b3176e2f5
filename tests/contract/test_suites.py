"""What our rigs offer passes the suites that every other package's must pass."""

from pathlib import Path

from rig.testing.devices import MarkerCameraSuite, ServoBusSuite
from rig.testing.laws import LawSuite
from rig.testing.mechanisms import MechanismSuite
from rig.testing.motions import MotionSuite
from rig.testing.plants import PlantSuite
from rig.testing.scenes import SceneSuite

CONFIGS = Path(__file__).parents[2] / "configs"


class TestCylinder(MechanismSuite, MotionSuite, PlantSuite, SceneSuite):
    configs, experiment = CONFIGS, "cylinder-sine"


class TestJoint(MechanismSuite, MotionSuite, PlantSuite, SceneSuite):
    configs, experiment = CONFIGS, "joint-poses"


class TestArm(MechanismSuite, MotionSuite, PlantSuite, SceneSuite):
    configs, experiment = CONFIGS, "arm-wrist-near-miss"
    rest = 0.3  # the hand's path begins with its speed, as in the paper


class TestLegs(MechanismSuite, MotionSuite, PlantSuite, SceneSuite):
    configs, experiment = CONFIGS, "legs-squat"


class TestCascade(LawSuite):
    configs, experiment = CONFIGS, "cylinder-sine"


class TestJointLaw(LawSuite):
    configs, experiment = CONFIGS, "joint-poses"
    bump = 0.15  # it starts from the tensions that hold the pose in which the ring is found


class TestArmLaw(LawSuite):
    configs, experiment = CONFIGS, "arm-wrist-near-miss"


class TestLegsLaw(LawSuite):
    configs, experiment = CONFIGS, "legs-squat"


class TestDrivesOfTheArm(ServoBusSuite):
    configs, rig, device = CONFIGS, "arm", "drives"


class TestCamera(MarkerCameraSuite):
    configs, rig, device = CONFIGS, "joint", "camera"
