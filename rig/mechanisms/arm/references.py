"""What an experiment may ask of an arm: paths of its hand, and twists from outside.

The laws plan or follow them, so they stand with the laws. A path of another package inherits
`ArmPath`, what says twists while the arm moves `ArmTwists`.
"""

from controllers.arm.online.commands import ArmTwists, TwistRows
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.pose_path import PosePath
from controllers.arm.straight_path import StraightPath
from controllers.arm.trajectory import ArmPath
from controllers.arm.turn_path import TurnPath
from rig.mechanisms.arm.gamepad import GamepadTwists

__all__ = [
    "ArmPath",
    "ArmTwists",
    "Circle",
    "DwellLine",
    "GamepadTwists",
    "Line",
    "PosePath",
    "StraightPath",
    "TurnBack",
    "TurnPath",
    "TwistRows",
]
