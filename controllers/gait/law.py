"""What the laws of the legs have in common: a plan offline, and the same motion online.

`prepare` steps through the whole motion with the very code that `update` then runs, so both give
the same.
"""

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from controllers.base import Chosen, PlanningLaw
from controllers.gait.arc_lengths import Arcs, measure
from controllers.gait.balance import from_edge
from controllers.gait.corrections import Corrections
from controllers.gait.durations import (
    Need,
    ShortPhases,
    find_longer,
    name_times,
)
from controllers.gait.fastest import fastest
from controllers.gait.footsteps import FootstepsSettings, LegsMotion, phases_of
from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.motions import WalkSettings
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase
from controllers.gait.plan import GaitPlan, PlannedPhase, judge_balance, way_of
from controllers.gait.slower import TooQuick, name_speed, slower_speed
from controllers.gait.time_laws import TimeLaw, TooShort
from controllers.gait.types import (
    GaitModel,
    Joints,
    LegsCommand,
    LegsReference,
    LegsState,
)
from controllers.motion import InfeasibleMotion, check_length

_JOINTS = len(AXIS_NAMES)
_REST: Joints = (0.0,) * 12
_RATE_SHARE = 1e-3
"""By which a joint may pass its greatest rate, relative: what servos do not resolve."""
_ROUNDING = 1e-9
"""By which a joint may pass its limit, rad."""


class TimedPhase(NamedTuple):
    """A phase on the grid of periods.

    Parameters
    ----------
    phase : GaitPhase
        The path.
    arcs : Arcs
        Its lengths.
    first, last : int
        Cycles of its start and end.
    """

    phase: GaitPhase
    arcs: Arcs
    first: int
    last: int

    @property
    def cycles(self) -> int:
        """How many periods it takes."""
        return self.last - self.first


class _Stretch(NamedTuple):
    curve: PhaseCurve
    pace: TimeLaw
    cycles: int


PaceMaker = Callable[[TimedPhase], TimeLaw]
"""Gives each phase its time law; raises `InfeasibleMotion` with the reason."""


class GaitLaw(
    PlanningLaw[Chosen, GaitModel, LegsReference, LegsState, LegsCommand, LegsMotion, GaitPlan]
):
    """A law of the legs: phases in their order, one period per update.

    The path parameter belongs to the law, not to the clock: an update moves on by exactly one
    period, so a late cycle holds the motion and loses no distance.
    """

    name: ClassVar[str]
    keeps_rates: ClassVar[bool] = False
    """Whether every plan of it keeps the joints' greatest rate."""

    def __init__(self, settings: Chosen, model: GaitModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._schedule: tuple[_Stretch, ...] = ()
        self._number = 0
        self._cycle = 0
        self._started = False
        self._finer: Self | None = None
        self.corrections = Corrections(model, period)
        """What is added to the plan; nothing, unless the model asks for it."""

    @abstractmethod
    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        """Return what gives each phase of a motion at this speed its time law."""

    def finer(self, period: float) -> Self:
        """Return the same law at a period (s) at which a motion has to be accepted, too.

        A speed that a refusal of either names is then one that both accept.
        """
        other = self.at_period(period)
        self._finer, other._finer = other, self
        return other

    def prepare(self, motion: LegsMotion) -> GaitPlan:
        """Work out a whole motion and check it; nothing moves.

        Raises
        ------
        InfeasibleMotion
            A leg does not reach, a joint would pass a limit, the time does not suffice, or the
            robot would be out of balance; with phase, instant, number and bound.
        """
        try:
            if isinstance(motion, WalkSettings | FootstepsSettings):
                motion = fastest(self._prepare_within_rates, motion)
            return self._prepare(motion)
        except InfeasibleMotion as error:
            words = str(error)
            if isinstance(error, TooQuick):
                words = f"{error}; {name_speed(self._accept, motion, error)}."
            if isinstance(error, ShortPhases):
                words = f"{error} {self._with_time(motion, error)}"
            if isinstance(motion, FootstepsSettings):
                words = motion.with_line(words)
            for law in (self, self._finer):
                if law is not None:
                    law._schedule = ()  # what was refused must not run
            if words == str(error):
                raise
            raise InfeasibleMotion(words) from error

    def _with_time(self, motion: LegsMotion, refused: ShortPhases) -> str:
        """Say which times are long enough for all phases, and whether the motion then fits."""
        geometry = self.model.geometry
        longer, still = find_longer(self._accept, motion, refused, geometry, self.period)
        times = name_times(motion, longer, geometry)
        if not still:
            return f"With {times} the whole motion would fit."
        words = f"With {times} it would be refused, too: {still.rstrip('.')}."
        speed = slower_speed(self._accept, motion) if motion.speed > 1.0 else None
        if speed is None:
            return words
        return f"{words} At a speed of {speed:g} instead of {motion.speed:.4g} it would fit."

    def _accept(self, motion: LegsMotion) -> None:
        """Raise as `prepare` would: what is to be as fast as it can keeps the rates, too."""
        for law in (self, self._finer):
            if law is None:
                continue
            if isinstance(motion, WalkSettings | FootstepsSettings) and motion.fastest:
                law._prepare_within_rates(motion)
            else:
                law._prepare(motion)

    def _prepare_within_rates(self, motion: LegsMotion) -> GaitPlan:
        plan = self._prepare(motion)
        check_rates(plan, motion.speed)
        return plan

    def _prepare(self, motion: LegsMotion) -> GaitPlan:
        geometry = self.model.geometry
        phases = phases_of(motion, geometry, self.model.balance.min_margin)
        check_length(sum(phase.duration for phase in phases), self.longest)
        timed = _on_grid(geometry, phases, self.period)
        make = self._pace_maker(timed, motion.speed)
        paces = _make_paces(make, timed)
        self._schedule = tuple(
            _Stretch(PhaseCurve(geometry, entry.phase, self.period), pace, entry.cycles)
            for entry, pace in zip(timed, paces, strict=True)
        )
        plan = self._sample(timed, paces)
        self._check(plan, motion.speed)
        if self.keeps_rates:
            check_rates(plan, motion.speed)
        self.corrections.prepare(plan)
        self._restart()
        return plan

    def reset(self, state: LegsState) -> None:
        """Go back to the start of the prepared motion."""
        if self._schedule:
            self._restart()

    def update(self, state: LegsState, reference: LegsReference) -> LegsCommand:
        """Return the joints' positions and rates for this period.

        Raises
        ------
        RuntimeError
            The motion is to run and none was prepared.
        """
        if not reference.follow:
            return LegsCommand(reference.positions, reference.velocities)
        if self._started:
            moved = self._advance()
            command = self._command(self._schedule[self._number].curve, moved)
            return self.corrections.apply(command, state)
        if not self._schedule:
            raise RuntimeError(f"the law {self.name} was asked to run before it prepared a motion")
        self._started = True
        return self.corrections.apply(LegsCommand(self._schedule[0].curve.joints, _REST), state)

    def _command(self, curve: PhaseCurve, moved: bool) -> LegsCommand:
        """Return what the joints are told at this point of the curve."""
        return LegsCommand(curve.joints, curve.velocities if moved else _REST)

    def _restart(self) -> None:
        self._number = self._cycle = 0
        self._started = False
        self.corrections.reset()
        self._schedule[0].curve.begin()

    def _advance(self) -> bool:
        """Move on by one period; return whether anything was left to do."""
        curve, pace, cycles = self._schedule[self._number]
        if self._cycle == cycles:
            if self._number == len(self._schedule) - 1:
                return False
            self._number += 1
            self._cycle = 0
            curve, pace, cycles = self._schedule[self._number]
            curve.begin()
        pace.advance(curve, self._cycle)
        self._cycle += 1
        return True

    def _sample(self, timed: Sequence[TimedPhase], paces: Sequence[TimeLaw]) -> GaitPlan:
        self._restart()
        count = timed[-1].last + 1
        q, path, way = np.empty((count, _JOINTS)), np.zeros(count), way_of(count)
        numbers = np.zeros(count, np.int64)
        for k in range(count):
            if k > 0:
                self._advance()
            curve = self._schedule[self._number].curve
            q[k] = self._command(curve, k > 0).positions
            numbers[k], path[k] = self._number, curve.path
            way.put(k, timed[self._number].phase, curve.path)
        planned = tuple(
            PlannedPhase(
                phase=entry.phase,
                first=entry.first,
                last=entry.last,
                path_length=entry.arcs.path_length,
                joint_length=entry.arcs.joint_length,
                pace=pace.summary,
            )
            for entry, pace in zip(timed, paces, strict=True)
        )
        return GaitPlan(
            geometry=self.model.geometry,
            law=self.name,
            period=self.period,
            phases=planned,
            t=np.arange(len(q)) * np.float64(self.period),
            q=q,
            q_dot=np.diff(q, axis=0, prepend=q[:1]) / self.period,
            path=path,
            phase_number=numbers,
            waist=way.waist,
            feet=way.feet,
            yaw=way.yaw,
            attitudes=way.attitudes,
            balance=judge_balance(
                self.model.geometry, self.model.balance, self.period, planned, q, way
            ),
        )

    def _check(self, plan: GaitPlan, speed: float) -> None:
        limits = np.array(plan.geometry.limits)
        beyond = np.maximum(limits[:, 0] - plan.q, plan.q - limits[:, 1])
        worst, joint = divmod(int(np.argmax(beyond)), len(AXIS_NAMES))
        if beyond[worst, joint] > _ROUNDING:
            low, high = np.degrees(limits[joint]).tolist()
            angle = math.degrees(plan.q[worst, joint])
            shown = f"{angle:.3f}"
            if low <= float(shown) <= high:
                shown = f"{angle:.3g}"
            raise InfeasibleMotion(
                f"at {plan.t[worst]:.3f} s ({self._name_at(plan, worst)}) {AXIS_NAMES[joint]} "
                f"would be at {shown} deg, outside {low:g} … {high:g} deg."
            )
        bound = self.model.balance.min_margin
        worst = int(np.argmin(plan.balance.margin))
        if plan.margin < bound:
            static = float(plan.balance.static_margin[worst])
            what = "centre of mass" if static < bound else "zero-moment point"
            words = (
                f"at {plan.t[worst]:.3f} s ({self._name_at(plan, worst)}) the {what} would be "
                f"{from_edge(plan.margin)}; the bound is {bound * 1e3:g} mm inside"
            )
            if static < bound:
                raise InfeasibleMotion(
                    f"{words}, and slower it would be {from_edge(static)} at best."
                )
            # Between the two lies what accelerations do, which go with the square of the speed.
            share = math.sqrt((static - bound) / (static - plan.margin))
            raise TooQuick(words, 0.999 * speed * share)

    @staticmethod
    def _name_at(plan: GaitPlan, sample: int) -> str:
        return plan.phases[int(plan.phase_number[sample])].phase.name


def check_rates(plan: GaitPlan, speed: float) -> None:
    """Raise if a joint passes its greatest rate.

    Raises
    ------
    TooQuick
        With the joint, the instant and the rate.
    """
    limit = plan.geometry.max_rate
    sample, joint = divmod(int(np.argmax(np.abs(plan.q_dot))), len(AXIS_NAMES))
    worst = abs(float(plan.q_dot[sample, joint]))
    if worst > (1.0 + _RATE_SHARE) * limit:
        phase = plan.phases[int(plan.phase_number[sample])].phase.name
        raise TooQuick(
            f"at {plan.t[sample]:.3f} s ({phase}) {AXIS_NAMES[joint]} would need {worst:.4g} "
            f"rad/s, beyond its limit of {limit:.4g} rad/s",
            0.999 * speed * limit / worst,
        )


def _on_grid(
    geometry: LegGeometry, phases: Sequence[GaitPhase], period: float
) -> tuple[TimedPhase, ...]:
    """Put the phases on the grid of periods; each begins at the cycle nearest to its time."""
    timed = []
    elapsed, first = 0.0, 0
    for phase in phases:
        elapsed += phase.duration
        last = round(elapsed / period)
        if last - first < 2:
            raise InfeasibleMotion(
                f"{phase.name} lasts {phase.duration:.4g} s: less than two periods of {period:g} s."
            )
        timed.append(TimedPhase(phase, measure(geometry, phase), first, last))
        first = last
    return tuple(timed)


def _make_paces(make: PaceMaker, timed: Sequence[TimedPhase]) -> list[TimeLaw]:
    """Return the time law of each phase; all that are too short are told at once."""
    paces: list[TimeLaw] = []
    words: list[str] = []
    needs: list[Need] = []
    for entry in timed:
        try:
            paces.append(make(entry))
        except TooShort as error:
            words.append(f"{entry.phase.name}: {error}")
            needs.append(Need(entry.phase, error.needs))
        except InfeasibleMotion as error:
            raise InfeasibleMotion(f"{entry.phase.name}: {error}") from error
    if needs:
        raise ShortPhases(words[0], needs)
    return paces


AnyGaitLaw = GaitLaw[Any]
"""A law of the legs, whatever its settings."""
