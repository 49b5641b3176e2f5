"""Every measure that an experiment may name."""

from rig.experiment.measures.arm import ARM_MEASURES
from rig.experiment.measures.base import Measure
from rig.experiment.measures.joint import JOINT_MEASURES
from rig.experiment.measures.joint_camera import CAMERA_MEASURES
from rig.experiment.measures.joint_laps import LAP_MEASURES
from rig.experiment.measures.joint_stiffness import STIFFNESS_MEASURES
from rig.experiment.measures.legs import LEGS_MEASURES
from rig.experiment.measures.pair import PAIR_MEASURES

__all__ = ["MEASURES", "Measure"]

MEASURES: dict[str, Measure] = {
    **PAIR_MEASURES,
    **JOINT_MEASURES,
    **CAMERA_MEASURES,
    **LAP_MEASURES,
    **STIFFNESS_MEASURES,
    **LEGS_MEASURES,
    **ARM_MEASURES,
}
