"""What an experiment may ask of the legs: motions in phases.

The laws plan them, so they stand with the laws. A motion of another package inherits
`GaitRequest`.
"""

from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.motions import GaitRequest, SquatSettings, WalkSettings

__all__ = ["FootstepsSettings", "GaitRequest", "SquatSettings", "WalkSettings"]
