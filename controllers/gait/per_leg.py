"""The singularity-consistent law on each leg by itself: the failure that the paper sets out from.

Each leg keeps its own bound and raises its own speed, so in a shift one is ahead of the other on
the way of the waist that both carry: the feet are torn apart, or slip.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from controllers.gait.arc_lengths import Arcs, measure
from controllers.gait.law import GaitLaw, PaceMaker, TimedPhase
from controllers.gait.laws import LimitedNormLaw, LimitedNormSettings
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase
from controllers.gait.time_laws import LimitedNormPace
from controllers.gait.types import GaitModel, Joints, LegsCommand


@dataclass(frozen=True, slots=True)
class PerLegSettings(LimitedNormSettings):
    """Bound of the joint rates, of each leg's six.

    Parameters
    ----------
    norm_rate : float, optional
        Greatest norm of a leg's six joint rates, rad/s. None: `norm_factor` times the mean norm
        of the phase and leg that need most.
    norm_factor : float
        How far above that mean the bound is, where `norm_rate` says none.
    """


class _Leg(NamedTuple):
    """One leg's own curve in a phase and its own way along it."""

    curve: PhaseCurve
    pace: LimitedNormPace


class PerLegLaw(GaitLaw[PerLegSettings]):
    """`sc` on each leg by itself, with nothing that keeps both at one place of the path.

    Promises that no joint passes its greatest rate. Does not promise the path: where both legs
    move they disagree on where the waist is.

    References
    ----------
    Kameta et al., section 4: why eq. (3) has both legs in one system.
    """

    Settings = PerLegSettings
    name = "sc-per-leg"
    keeps_rates = True

    def __init__(self, settings: PerLegSettings, model: GaitModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._own: dict[GaitPhase, tuple[_Leg | None, _Leg | None]] = {}
        self._joints: Joints = ()

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        both = LimitedNormLaw(self.settings, self.model, self.period)
        arcs = [[self._arcs(entry.phase, leg) for leg in (0, 1)] for entry in phases]
        means = [
            its.joint_length / (entry.cycles * self.period)
            for entry, legs in zip(phases, arcs, strict=True)
            for its in legs
        ]
        bound = self.settings.norm_rate or self.settings.norm_factor * max(means)
        self._own = {}
        for entry, legs in zip(phases, arcs, strict=True):
            right, left = (self._leg(entry, leg, its, bound) for leg, its in enumerate(legs))
            self._own[entry.phase] = right, left
        # What is planned for waist and feet is where both legs as one system would be.
        return both._pace_maker(phases, speed)

    def _arcs(self, phase: GaitPhase, leg: int) -> Arcs:
        return measure(self.model.geometry, phase._replace(only=leg))

    def _leg(self, entry: TimedPhase, leg: int, arcs: Arcs, bound: float) -> _Leg | None:
        """Return a leg's own curve and pace; None if it has nothing to do."""
        if arcs.path_length == 0.0:
            return None
        rate = min(bound, self.model.geometry.max_rate / arcs.steepest)
        curve = PhaseCurve(self.model.geometry, entry.phase._replace(only=leg), self.period)
        return _Leg(curve, LimitedNormPace(arcs, entry.cycles, self.period, rate))

    def _restart(self) -> None:
        super()._restart()
        self._joints = self._schedule[0].curve.joints

    def _command(self, curve: PhaseCurve, moved: bool) -> LegsCommand:
        before = self._joints
        if moved:
            self._joints = self._next(curve.phase, self._cycle - 1)
        rate = 1.0 / self.period
        return LegsCommand(
            self._joints, tuple([rate * (b - a) for a, b in zip(before, self._joints, strict=True)])
        )

    def _next(self, phase: GaitPhase, cycle: int) -> Joints:
        joints: list[float] = []
        for leg, own in enumerate(self._own[phase]):
            mine = slice(6 * leg, 6 * leg + 6)
            if own is None:
                joints += self._joints[mine]
                continue
            if cycle == 0:
                own.curve.begin()
            own.pace.advance(own.curve, cycle)
            joints += own.curve.joints[mine]
        return tuple(joints)
