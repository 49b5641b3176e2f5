"""What an experiment may ask of an arm: paths of its hand.

The laws plan them, so they stand with the laws. A path of another package inherits `ArmPath`.
"""

from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.pose_path import PosePath
from controllers.arm.straight_path import StraightPath
from controllers.arm.trajectory import ArmPath

__all__ = ["ArmPath", "Circle", "DwellLine", "Line", "PosePath", "StraightPath", "TurnBack"]
