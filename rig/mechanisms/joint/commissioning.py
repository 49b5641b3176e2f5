"""The acceptance test of the spherical joint."""

import math
from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.motion import FirstMotion
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.references.poses import JointPose, JointPoses
from rig.mechanisms.pneumatic.commissioning.course import pneumatic_course

_TILT = math.radians(2.0)
"""Of the first motion: a wire then goes by about 1 mm."""
_TRAVEL = 1e-3
"""How far the wire goes that goes furthest, m."""


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    upright, tilted = JointPose(0.0), JointPose(_TILT)
    there_and_back = JointPoses(poses=(upright, tilted, upright), rise=2.0, dwell=1.0)
    rods = [f"reading.rod_{channel}" for channel in CHANNELS]
    motion = FirstMotion("joint-poses", there_and_back, rods, _TRAVEL, "m")
    return pneumatic_course(motion)
