"""The pose controllers of the registry: one per law of a pair."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.base import Tunable
from controllers.cylinder.cascade import Cascade
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.feedforward import FeedforwardSettings
from controllers.cylinder.pid import Pid, PidSettings
from controllers.cylinder.pid_friction import PidFriction, PidFrictionSettings
from controllers.cylinder.super_twisting import SuperTwisting, SuperTwistingSettings
from controllers.cylinder.types import PairModel
from controllers.spherical_joint.dither import DitherSettings
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
    """Settings of `joint-cascade`, tuned for standard seals at 1 kHz with encoders of 1 µm.

    Parameters
    ----------
    ball_friction, friction_distance, dither
        As of all pose controllers.
    pair : CascadeSettings
        Of both pairs.
    """

    ball_friction: Annotated[float, Ge(0), Le(2)] = 1.1
    friction_distance: Annotated[float, Unit("m"), Gt(0)] = 13e-6
    dither: DitherSettings = field(
        default_factory=lambda: DitherSettings(amplitude=245e3, frequency=27.5, fade_speed=17e-3)
    )
    pair: CascadeSettings = field(
        default_factory=lambda: CascadeSettings(
            position_rate=195.0,
            velocity_rate=430.0,
            integral=3.0e5,
            hold_integral=1e6,
            observer_bandwidth=3000.0,
            force_trust=0.3,
            lead_bandwidth=490.0,
            disturbance_gain=0.042,
            disturbance_bandwidth=19.0,
            trim_rate=20.0,
            differential_limit=400e3,
            feedforward=FeedforwardSettings(
                gain=0.65, distance=3e-6, learning_rate=14.0, error_rate=11.0
            ),
        )
    )


@dataclass(frozen=True, slots=True)
class JointSuperTwistingSettings(PoseControlSettings):
    """Settings of `joint-super-twisting`.

    Parameters
    ----------
    pair : SuperTwistingSettings
        Of both pairs.
    """

    pair: SuperTwistingSettings = field(default_factory=SuperTwistingSettings)


def _of_pair(tunables: Sequence[Tunable]) -> tuple[Tunable, ...]:
    return tuple(gain._replace(key=f"pair.{gain.key}") for gain in tunables)


_BALL = (Tunable("ball_friction", 0.3, 1.5), Tunable("friction_distance", 3e-6, 300e-6))
"""Of the friction on the ball that is fed forward."""


class JointPid(PoseController[JointPidSettings]):
    """Pose control over a PID per pair: ``joint-pid``."""

    Settings = JointPidSettings
    tunables = _of_pair(Pid.tunables)

    def _pair_law(self, pair: PairModel) -> Pid:
        return Pid(self.settings.pair, pair, self.period)


class JointPidFriction(PoseController[JointPidFrictionSettings]):
    """Pose control over a PID with friction feedforward and dither: ``joint-pid-friction``."""

    Settings = JointPidFrictionSettings
    tunables = (*_BALL, *_of_pair(PidFriction.tunables))

    def _pair_law(self, pair: PairModel) -> PidFriction:
        return PidFriction(self.settings.pair, pair, self.period)


class JointCascade(PoseController[JointCascadeSettings]):
    """Pose control over cascades with observers on the pressures: ``joint-cascade``."""

    Settings = JointCascadeSettings
    tunables = (*_BALL, *_of_pair(Cascade.tunables))
    online = _of_pair(Cascade.online)

    def retune(self, settings: JointCascadeSettings) -> None:
        """See `Law.retune`."""
        for law in self._laws:
            law.retune(settings.pair)
        self.settings = settings

    def _pair_law(self, pair: PairModel) -> Cascade:
        return Cascade(self.settings.pair, pair, self.period)


class JointSuperTwisting(PoseController[JointSuperTwistingSettings]):
    """Pose control over a sliding mode per pair: ``joint-super-twisting``."""

    Settings = JointSuperTwistingSettings
    tunables = (*_BALL, *_of_pair(SuperTwisting.tunables))

    def _pair_law(self, pair: PairModel) -> SuperTwisting:
        return SuperTwisting(self.settings.pair, pair, self.period)
