"""The singularity-consistent law with bounded accelerations, and the least rates that they leave.

The joints' curve is regular in its own length, through straight knees as well. Along it the law
goes with the least peak of the joints' rates with which the phase still ends in time, when no
joint accelerates by more than its bound.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Gt, Unit
from numpy.typing import NDArray

from controllers.bisection import bisect
from controllers.gait.durations import Need, ShortPhases
from controllers.gait.footsteps import LegsMotion
from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.law import GaitLaw, PaceMaker, TimedPhase
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase
from controllers.gait.plan import GaitPlan
from controllers.gait.time_laws import PaceSummary, TooShort
from controllers.gait.types import GaitModel
from controllers.reachable_speeds import FastestTimings, Rows
from controllers.rounding import ceiling

Array = NDArray[np.float64]

_SAMPLES = 1200
"""Of a phase's curve, denser towards its ends."""
_ROUNDS = 16
"""Halvings of the peak rate that is looked for."""
_TRIES, _OVER = 8, 5e-4
"""Times that a lower bound is tried, and by how much, relative, the bound may be passed."""
_REPEATS = 3
"""Times that a plan is made: a second one knows what the curve's length was to a nanoradian."""
_SHARE = 0.98
"""Of the acceleration that is used: it is met at the samples, not between them."""


@dataclass(frozen=True, slots=True)
class SmoothSettings:
    """Bound of the joints' accelerations.

    Parameters
    ----------
    acceleration : float
        Of each joint, at a motion's speed of 1, rad/s²; it grows with the square of that.

    Notes
    -----
    So a speed only stretches time, as it stretches the ramps of other laws: a motion keeps the
    shape of its timing. A phase that is too short for its accelerations is so at any speed; what
    it needs is said as times of the request.
    """

    acceleration: Annotated[float, Unit("rad/s^2"), Gt(0)] = 2.0


class JointCurve(NamedTuple):
    """The joints along a phase, over the length of their curve.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Length, rad.
    tangent, bend : ndarray, shape (n, 12)
        First and second derivative of the joints by it.
    joints : callable
        Takes lengths, returns the joints there, rad.
    """

    s: Array
    tangent: Array
    bend: Array
    joints: Callable[[Array], Array]

    def hardest(self, lengths: Array, period: float) -> float:
        """Return the greatest acceleration of a joint that goes so far in each cycle, rad/s²."""
        rests = np.concatenate((lengths[:1], lengths, lengths[-1:]))
        return float(np.abs(np.diff(self.joints(rests), 2, axis=0)).max()) / (period * period)


class SmoothPace:
    """A phase on a timing of its joints' curve.

    Parameters
    ----------
    lengths : ndarray, shape (cycles + 1,)
        How far the curve is gone after each cycle, rad.
    """

    def __init__(self, lengths: Array) -> None:
        self.summary = PaceSummary()
        self._steps: list[float] = np.diff(lengths).tolist()
        self.last = self._steps[-1]
        """What the last step is to be, rad."""

    def advance(self, curve: PhaseCurve, cycle: int) -> None:
        """Move on by one period."""
        if cycle >= len(self._steps) - 1:
            curve.finish()
        else:
            curve.follow_joints(self._steps[cycle])


class SmoothLaw(GaitLaw[SmoothSettings]):
    """The singularity-consistent law with bounded accelerations and the least peak rates.

    Promises that no joint passes its greatest rate, nor accelerates by more than
    `SmoothSettings.acceleration`: a knee that turns round in mid-swing is slowed before it.

    References
    ----------
    Kameta et al., section 5, whose trapezoid bounds no acceleration where the joints' curve bends.
    """

    Settings = SmoothSettings
    name = "sc-smooth"
    keeps_rates = True

    def acceleration(self, speed: float) -> float:
        """Return the bound at a motion's speed, rad/s²."""
        return self.settings.acceleration * speed * speed

    def __init__(self, settings: SmoothSettings, model: GaitModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._stretch: dict[GaitPhase, float] = {}
        self._told: dict[GaitPhase, float] = {}

    def _prepare(self, motion: LegsMotion) -> GaitPlan:
        self._stretch, self._told = {}, {}
        bound = self.acceleration(motion.speed)
        for tries in range(_REPEATS):
            plan = super()._prepare(motion)
            changes = np.abs(np.diff(plan.q_dot, axis=0, append=0.0)) / self.period
            sample, joint = divmod(int(np.argmax(changes)), len(AXIS_NAMES))
            hardest = float(changes[sample, joint])
            if hardest <= (1.0 + 2.0 * _OVER) * bound:
                return plan
            if tries < _REPEATS - 1:
                self._correct(plan, changes.max(axis=1) / bound)
        phase = plan.phases[int(plan.phase_number[sample])]
        lasts = (phase.last - phase.first) * self.period
        raise ShortPhases(
            f"at {plan.t[sample]:.3f} s ({self._name_at(plan, sample)}) {AXIS_NAMES[joint]} would "
            f"accelerate by {hardest:.4g} rad/s^2, beyond the bound of {bound:.4g} rad/s^2 "
            f"(acceleration {self.settings.acceleration:g} rad/s^2 at a speed of 1).",
            [Need(phase.phase, lasts * math.sqrt(hardest / bound))],
        )

    def _correct(self, plan: GaitPlan, over: Array) -> None:
        """Note what a plan was found to miss, for the next one.

        By how much a phase's curve is longer than its samples and the rule's steps say: its last
        step ends it exactly, and makes up a millionth of a radian in one period. And by how much
        accelerations pass the bound at corners of the curve that lie between its samples.
        """
        for planned, stretch in zip(plan.phases, self._schedule, strict=True):
            if not isinstance(stretch.pace, SmoothPace):
                continue
            its, last = planned.phase, planned.last
            left = float(np.linalg.norm(plan.q[last] - plan.q[last - 1]))
            missing = (left - stretch.pace.last) / planned.joint_length
            self._stretch[its] = (1.0 + missing) * self._stretch.get(its, 1.0)
            within = float(np.max(over[planned.first + 2 : last - 2], initial=1.0))
            if within > 1.0 + _OVER:
                self._told[its] = self._told.get(its, 1.0) / within

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        geometry, allowed = self.model.geometry, self.acceleration(speed)

        def pace(entry: TimedPhase, cycles: int) -> SmoothPace:
            shape = entry.phase._replace(duration=0.0)
            curve = _joint_curve(geometry, shape)
            duration = cycles * self.period
            at = self.period * np.arange(cycles + 1, dtype=np.float64)
            told = kept = allowed * self._told.get(entry.phase, 1.0)
            for _ in range(_TRIES):
                t, speeds = _least_peak(geometry, shape, duration, told)
                lengths = _gone(curve.s, t, speeds, at)
                over = curve.hardest(lengths, self.period) / kept
                if over <= 1.0 + _OVER:
                    break
                told /= over  # the path has a corner in its curvature between two samples
            # The curve's own length is a little more than that of its chords.
            longer = entry.arcs.joint_length / float(curve.s[-1])
            return SmoothPace(longer * self._stretch.get(entry.phase, 1.0) * lengths)

        def make(entry: TimedPhase) -> SmoothPace:
            try:
                return pace(entry, entry.cycles)
            except TooShort as error:
                # In that time corners are met that lay elsewhere; how long is enough is tried.
                words, needs = str(error), error.needs
            cycles = entry.cycles
            for _ in range(_TRIES):
                cycles = max(cycles + 1, math.ceil(needs / self.period))
                try:
                    pace(entry, cycles)
                except TooShort as error:
                    needs = error.needs
                else:
                    break
            raise TooShort(words, cycles * self.period)

        return make


@lru_cache(maxsize=256)
def _joint_curve(geometry: LegGeometry, phase: GaitPhase) -> JointCurve:
    """Return the joints' curve of a phase, by the closed-form inverse."""
    from scipy.interpolate import CubicSpline

    curve = PhaseCurve(geometry, phase, 1.0)
    xi = np.sin(np.linspace(0.0, 0.5 * math.pi, _SAMPLES + 1)) ** 2
    joints = np.array([curve.joints_at(x) for x in xi.tolist()])
    steps = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    keep = np.concatenate(([True], steps > 1e-9))
    joints = joints[keep]
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(joints, axis=0), axis=1))))
    spline = CubicSpline(s, joints)
    return JointCurve(s, np.asarray(spline(s, 1)), np.asarray(spline(s, 2)), spline)


@lru_cache(maxsize=256)
def _least_peak(
    geometry: LegGeometry, phase: GaitPhase, duration: float, allowed: float
) -> tuple[Array, Array]:
    """Return instants (s) and speeds (rad/s) of the timing with the least peak of a joint's rate.

    Raises
    ------
    TooShort
        It takes longer than the phase lasts, however fast the joints.
    """
    curve, max_rate = _joint_curve(geometry, phase), geometry.max_rate
    greatest = np.max(np.abs(curve.tangent), axis=1)
    bounds = np.full(curve.tangent.shape[1], _SHARE * allowed)
    timings = FastestTimings(curve.s, Rows.of_accelerations(curve.tangent, curve.bend, bounds))

    def timing(rate: float) -> tuple[Array, Array]:
        speeds = np.sqrt(timings.below((rate / greatest) ** 2))
        mean = 0.5 * (speeds[:-1] + speeds[1:])
        return np.concatenate(([0.0], np.cumsum(np.diff(curve.s) / mean))), speeds

    fastest, _ = timing(max_rate)
    if fastest[-1] > duration:
        raise TooShort(
            f"with no joint faster than {max_rate:.4g} rad/s nor accelerated by more than "
            f"{allowed:.4g} rad/s^2 the phase needs at least "
            f"{ceiling(float(fastest[-1])):.4g} s instead of {duration:.4g} s.",
            float(fastest[-1]),
        )
    # No rate can be less than the farthest joint's way over the time.
    ways = np.abs(curve.tangent[:-1] + curve.tangent[1:]) * np.diff(curve.s)[:, None] / 2.0
    least = float(ways.sum(axis=0).max()) / duration
    rate = bisect(lambda rate: timing(rate)[0][-1] > duration, 0.9 * least, max_rate, _ROUNDS)[1]
    t, speeds = timing(rate)
    slower = duration / float(t[-1])
    return slower * t, speeds / slower


def _gone(s: Array, t: Array, speeds: Array, at: Array) -> Array:
    """Return the length at some instants; the speed's square is linear between the samples."""
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    into = np.minimum(at, t[-1]) - t[k]
    acceleration = (speeds[k + 1] - speeds[k]) / (t[k + 1] - t[k])
    return np.asarray(s[k] + into * (speeds[k] + 0.5 * acceleration * into), dtype=np.float64)
