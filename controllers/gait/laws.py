"""The four laws: one path, one curve of the joints, four ways to pass along it in time.

Each is built from its settings, the robot's model and the loop's period, as `GaitLaw` says.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.gait.law import GaitLaw, PaceMaker, TimedPhase
from controllers.gait.time_laws import (
    ConstantPathPace,
    LimitedNormPace,
    MinimumJerkPace,
    TimeLaw,
    TrapezoidNormPace,
)


@dataclass(frozen=True, slots=True)
class NoSettings:
    """A law that leaves nothing to choose."""


class InverseLaw(GaitLaw[NoSettings]):
    """The plain law: constant speed along the path, by the inverse of the Jacobian.

    Near the straight knee the joint rates are what they are; the servos may not follow.

    References
    ----------
    Kameta et al., eq. (1) and Fig. 4 (a).
    """

    Settings = NoSettings
    name = "inverse"

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        return lambda entry: ConstantPathPace(entry.cycles)


class MinimumJerkLaw(GaitLaw[NoSettings]):
    """The rival: minimum-jerk timing of the path, by the closed-form inverse.

    Does not promise the joints' rates, but where the fastest walk is looked for.
    """

    Settings = NoSettings
    name = "min-jerk"

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        return lambda entry: MinimumJerkPace(entry.cycles)


@dataclass(frozen=True, slots=True)
class LimitedNormSettings:
    """Bound of the joint rates.

    Parameters
    ----------
    norm_rate : float, optional
        Greatest norm of the twelve joint rates, rad/s. None: `norm_factor` times the mean norm
        of the phase that needs most.
    norm_factor : float
        How far above that mean the bound is, where `norm_rate` says none.
    """

    norm_rate: Annotated[float, Unit("rad/s"), Gt(0)] | None = None
    norm_factor: Annotated[float, Gt(1)] = 1.5


class LimitedNormLaw(GaitLaw[LimitedNormSettings]):
    """The singularity-consistent law: constant path speed, with the joints' norm bounded.

    Promises that no joint passes its greatest rate, nor all of them the bound of their norm.

    References
    ----------
    Kameta et al., section 4 and Fig. 4 (b).
    """

    Settings = LimitedNormSettings
    name = "sc"
    keeps_rates = True

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        wanted = self.settings.norm_rate
        bound = wanted if wanted is not None else self._usual_bound(phases)
        # No joint may pass its own limit either, wherever on the curve it has its greatest share.
        most = self.model.geometry.max_rate

        def make(entry: TimedPhase) -> TimeLaw:
            rate = min(bound, most / entry.arcs.steepest)
            return LimitedNormPace(entry.arcs, entry.cycles, self.period, rate)

        return make

    def _usual_bound(self, phases: Sequence[TimedPhase]) -> float:
        means = [entry.arcs.joint_length / (entry.cycles * self.period) for entry in phases]
        return self.settings.norm_factor * max(means)


@dataclass(frozen=True, slots=True)
class TrapezoidNormSettings:
    """The trapezoid's shape.

    Parameters
    ----------
    ramp : float
        Time of rise and of fall at a motion's speed of 1, s; at most half the phase.
    """

    ramp: Annotated[float, Unit("s"), Ge(0)] = 0.5


class TrapezoidNormLaw(GaitLaw[TrapezoidNormSettings]):
    """The singularity-consistent law with a trapezoid of the joints' norm.

    Promises that no joint passes its greatest rate, and that their norm does not jump. Does not
    bound accelerations: where the joints' curve turns round, a joint does within a sample or two.
    See `sc-smooth`.

    References
    ----------
    Kameta et al., section 5 and Fig. 4 (c).
    """

    Settings = TrapezoidNormSettings
    name = "sc-trapezoid"
    keeps_rates = True

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        ramp = self.settings.ramp / speed
        most = self.model.geometry.max_rate

        def make(entry: TimedPhase) -> TimeLaw:
            return TrapezoidNormPace(entry.arcs, entry.cycles, self.period, ramp, most)

        return make
