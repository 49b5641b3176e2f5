"""The pose controllers of the registry: one per law of a pair."""

from dataclasses import dataclass, field

from controllers.cylinder.cascade import Cascade, CascadeSettings
from controllers.cylinder.pid import Pid, PidSettings
from controllers.cylinder.pid_friction import PidFriction, PidFrictionSettings
from controllers.cylinder.super_twisting import SuperTwisting, SuperTwistingSettings
from controllers.spherical_joint.pose_control import PoseController, PoseControlSettings


@dataclass(frozen=True, slots=True)
class JointPidSettings(PoseControlSettings):
    """Settings of `joint-pid`.

    Parameters
    ----------
    pair : PidSettings
        Of both pairs.
    """

    pair: PidSettings = field(default_factory=PidSettings)


@dataclass(frozen=True, slots=True)
class JointPidFrictionSettings(PoseControlSettings):
    """Settings of `joint-pid-friction`.

    Parameters
    ----------
    pair : PidFrictionSettings
        Of both pairs.
    """

    pair: PidFrictionSettings = field(default_factory=PidFrictionSettings)


@dataclass(frozen=True, slots=True)
class JointCascadeSettings(PoseControlSettings):
    """Settings of `joint-cascade`.

    Parameters
    ----------
    pair : CascadeSettings
        Of both pairs.
    """

    pair: CascadeSettings = field(default_factory=CascadeSettings)


@dataclass(frozen=True, slots=True)
class JointSuperTwistingSettings(PoseControlSettings):
    """Settings of `joint-super-twisting`.

    Parameters
    ----------
    pair : SuperTwistingSettings
        Of both pairs.
    """

    pair: SuperTwistingSettings = field(default_factory=SuperTwistingSettings)


class JointPid(PoseController):
    """Pose control over a PID per pair: ``joint-pid``."""

    Settings = JointPidSettings
    law = Pid


class JointPidFriction(PoseController):
    """Pose control over a PID with friction feedforward and dither: ``joint-pid-friction``."""

    Settings = JointPidFrictionSettings
    law = PidFriction


class JointCascade(PoseController):
    """Pose control over cascades with observers on the pressures: ``joint-cascade``."""

    Settings = JointCascadeSettings
    law = Cascade


class JointSuperTwisting(PoseController):
    """Pose control over a sliding mode per pair: ``joint-super-twisting``."""

    Settings = JointSuperTwistingSettings
    law = SuperTwisting
