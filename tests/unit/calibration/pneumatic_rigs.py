"""The pneumatic side of a profile, for tests that hold for both mechanisms."""

from rig.mechanisms.cylinder.calibration.pneumatics import PairPneumatics
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics

_OF = {"cylinder": PairPneumatics, "joint": JointPneumatics}


def pneumatics_of(profile):
    return _OF[profile.mechanism](profile)


def shown_by(profile, k, extension):
    """Return the log's column of a rod, and what stands there for an extension (m)."""
    channel = pneumatics_of(profile).channels[k]
    if profile.mechanism == "cylinder":
        return f"reading.position_{channel}", extension
    settings = profile.mechanism_settings
    return f"reading.rod_{channel}", settings.home + settings.wire_offsets[k] - extension
