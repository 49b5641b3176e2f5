"""Every measure that an experiment may name."""

from rig.experiment.measure import Measure
from rig.mechanisms.arm.measures import ARM_MEASURES
from rig.mechanisms.cylinder.measures import PAIR_MEASURES
from rig.mechanisms.joint.measures.camera import CAMERA_MEASURES
from rig.mechanisms.joint.measures.laps import LAP_MEASURES
from rig.mechanisms.joint.measures.stiffness import STIFFNESS_MEASURES
from rig.mechanisms.joint.measures.tracking import JOINT_MEASURES
from rig.mechanisms.legs.measures import LEGS_MEASURES

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
