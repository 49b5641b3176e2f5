"""Time laws: how far along its path, or along its joints' curve, a phase goes in each cycle.

A pace moves a `PhaseCurve` on by one period at a time and ends it exactly after the phase's
cycles. All of them describe the same curve of the joints; they differ in when.
"""

import math
from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol

import numpy as np

from controllers.bisection import bisect
from controllers.gait.arc_lengths import Arcs
from controllers.gait.phase_curve import PhaseCurve
from controllers.minimum_jerk import minimum_jerk
from controllers.motion import InfeasibleMotion
from controllers.rounding import ceiling

_SPARE = 1e-3
"""Of the least time, relative: with none to spare the path's speed would be without bound."""


class TooShort(InfeasibleMotion):
    """A phase that lasts too short for its joints.

    Attributes
    ----------
    needs : float
        What it would have to last at least, s.
    """

    def __init__(self, message: str, needs: float) -> None:
        super().__init__(message)
        self.needs = needs


class PaceSummary(NamedTuple):
    """The bound and the speed of a pace.

    Parameters
    ----------
    norm_rate : float
        Norm of the twelve joint rates that it holds or reaches, rad/s; infinite without a bound.
    raised_by : float
        By what the path's speed is raised to keep the distance; 1 if it is not.
    reach_unraised : float
        Share of the path that would be done in time without that.
    """

    norm_rate: float = math.inf
    raised_by: float = 1.0
    reach_unraised: float = 1.0


class TimeLaw(Protocol):
    """The time law of one phase."""

    summary: PaceSummary

    def advance(self, curve: PhaseCurve, cycle: int) -> None:
        """Move on by one period; `cycle` counts from 0."""


class _PathPace(ABC):
    """Along the path by the closed-form inverse, to where it is at the end of each period.

    Parameters
    ----------
    cycles : int
        Its duration in periods.
    """

    def __init__(self, cycles: int) -> None:
        self.summary = PaceSummary()
        self._cycles = cycles

    def advance(self, curve: PhaseCurve, cycle: int) -> None:
        """Move on by one period."""
        if cycle >= self._cycles - 1:
            curve.finish()
        else:
            curve.place(self._covered(cycle + 1))

    @abstractmethod
    def _covered(self, cycles: int) -> float:
        """Return the share of the path that is covered after so many cycles."""


class ConstantPathPace(_PathPace):
    """Constant speed along the path from the first to the last instant: the plain law.

    Each cycle takes the closed-form inverse, which is the inverse Jacobian integrated exactly.
    """

    def _covered(self, cycles: int) -> float:
        return cycles / self._cycles


class MinimumJerkPace(_PathPace):
    """Minimum jerk along the path from rest to rest, with the closed-form inverse: the rival.

    Near its end the path that is left shrinks with the third power of time, the knee with the
    square root of that: it stops without a jump, too.
    """

    def _covered(self, cycles: int) -> float:
        return minimum_jerk(0.0, 1.0, self._cycles, cycles)[0]


class LimitedNormPace:
    """Constant speed along the path unless the joints' norm forbids; faster before, to be on time.

    ``b`` is the smaller of the two that keep the path's speed and the norm of the joint rates.
    What is lost near the straight knee is made up elsewhere by a higher speed of the path, which
    is solved for.

    Parameters
    ----------
    arcs : Arcs
        Lengths of the phase.
    cycles : int
        Its duration in periods.
    period : float
        s.
    norm_rate : float
        Greatest norm of the twelve joint rates, rad/s.

    Raises
    ------
    TooShort
        The joints' curve is too long for this norm in this time.

    References
    ----------
    Kameta et al., section 4: the total distance is kept by raising the speed before the
    neighbourhood of the singularity.
    """

    def __init__(self, arcs: Arcs, cycles: int, period: float, norm_rate: float) -> None:
        duration = cycles * period
        self._period = period
        self._arcs = arcs
        self._norm_rate = norm_rate
        self._mean_speed = arcs.path_length / duration
        raised_by = self._solve(duration)
        self._speed = self._mean_speed * raised_by
        self.summary = PaceSummary(norm_rate, raised_by, self._reach_unraised(duration))
        self._last = cycles - 1
        self._left = arcs.joint_length

    def advance(self, curve: PhaseCurve, cycle: int) -> None:
        """Move on by one period."""
        if cycle == 0:
            self._left = self._arcs.joint_length
        if cycle >= self._last:
            curve.finish()
            return
        norm, path = curve.rates()
        step = min(self._norm_rate * self._period, max(self._left, 0.0))
        if self._speed * norm < self._norm_rate * path:
            joints, xi = curve.joints, curve.path
            curve.follow_path(self._speed * self._period)
            if math.dist(curve.joints, joints) <= self._norm_rate * self._period:
                norm_after, path_after = curve.rates()
                per_path = 0.5 * (norm / path + norm_after / path_after)
                self._left -= self._speed * self._period * per_path
                return
            # The norm reaches its bound within this period.
            curve.joints, curve.path = joints, xi
        curve.follow_joints(step)
        self._left -= step

    def _reach_unraised(self, duration: float) -> float:
        """Return the share of the path that is done in time (s) if the speed is not raised."""
        times = np.cumsum(self._times(1.0))
        lengths = np.cumsum(self._arcs.path_pieces)
        return float(np.interp(duration, times, lengths) / lengths[-1])

    def _times(self, raised_by: float) -> np.ndarray:
        arcs = self._arcs
        times: np.ndarray = np.maximum(
            arcs.path_pieces / (raised_by * self._mean_speed), arcs.joint_pieces / self._norm_rate
        )
        return times

    def _solve(self, duration: float) -> float:
        least = self._arcs.joint_length / self._norm_rate
        if least >= duration:
            raise TooShort(
                f"the joints' curve of {self._arcs.joint_length:.4g} rad takes {least:.4g} s at a "
                f"norm of {self._norm_rate:.4g} rad/s, but the phase lasts {duration:.4g} s.",
                (1.0 + _SPARE) * least,
            )
        low, high = 1.0, 2.0
        while float(np.sum(self._times(high))) > duration:
            high *= 2.0
        return bisect(lambda raised: float(np.sum(self._times(raised))) > duration, low, high)[1]


class TrapezoidNormPace:
    """A trapezoid of the norm of the twelve joint rates over the whole phase.

    Its area is the length of the joints' curve, so the distance is kept by construction.

    Parameters
    ----------
    arcs : Arcs
        Lengths of the phase.
    cycles : int
        Its duration in periods.
    period : float
        s.
    ramp : float
        Of the trapezoid's sides, s; at most half the phase.
    max_rate : float
        Greatest rate of a joint, rad/s.

    Raises
    ------
    TooShort
        The trapezoid would be higher than that.

    References
    ----------
    Kameta et al., section 5: trapezoidal interpolation of the joint-rate norm.
    """

    def __init__(
        self, arcs: Arcs, cycles: int, period: float, ramp: float, max_rate: float
    ) -> None:
        duration = cycles * period
        self._ramp = min(ramp, 0.5 * duration)
        self._duration = duration
        self._period = period
        self._cycles = cycles
        self._norm_rate = arcs.joint_length / (duration - self._ramp)
        self.summary = PaceSummary(self._norm_rate)
        if self._norm_rate * arcs.steepest > max_rate and not self._keeps(
            arcs, self._norm_rate, max_rate
        ):
            most = bisect(
                lambda norm: self._keeps(arcs, norm, max_rate),
                max_rate / arcs.steepest,
                self._norm_rate,
            )[0]
            needs = arcs.joint_length / most + self._ramp
            raise TooShort(
                f"the joint rates would reach a norm of {self._norm_rate:.4g} rad/s, at which one "
                f"joint passes its limit ({most:.4g} rad/s); the phase needs at least "
                f"{ceiling(needs):.4g} s instead of {duration:.4g} s.",
                needs,
            )

    def advance(self, curve: PhaseCurve, cycle: int) -> None:
        """Move on by one period."""
        if cycle >= self._cycles - 1:
            curve.finish()
            return
        t = cycle * self._period
        curve.follow_joints(self._covered(t + self._period) - self._covered(t))

    def _keeps(self, arcs: Arcs, norm_rate: float, max_rate: float) -> bool:
        """Return whether no joint passes its rate: its share counts where the norm is that high."""
        gone = np.concatenate(([0.0], np.cumsum(arcs.joint_pieces)))
        left = gone[-1] - gone
        norms = np.full(len(arcs.shares), norm_rate)
        if self._ramp > 0.0:
            farthest = np.minimum(gone[1:], left[:-1])  # of a piece's points from the nearer end
            norms = np.minimum(norms, np.sqrt(2.0 * norm_rate * farthest / self._ramp))
        return bool(np.all(norms * arcs.shares <= max_rate))

    def _covered(self, t: float) -> float:
        ramp, left = self._ramp, self._duration - t
        if t < ramp:
            return 0.5 * self._norm_rate * t * t / ramp
        if left < ramp:
            whole = self._norm_rate * (self._duration - ramp)
            return whole - 0.5 * self._norm_rate * left * left / ramp
        return self._norm_rate * (t - 0.5 * ramp)
