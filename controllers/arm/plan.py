"""A whole motion before anything moves: its samples, its checks, what figures need of it."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import (
    Dimensions,
    dimensions_of,
    forward,
    hand_twist,
    singularity_indices,
    wrist_in_plane,
)
from controllers.arm.trajectory import where_on
from controllers.arm.types import ArmReference, Joints, Twist, Vector
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]


_RUNS_AWAY = 20.0 * math.tau
"""rad: so far no joint is led but by rates that have no bound."""


class Sample(NamedTuple):
    """One period of a law's motion.

    Parameters
    ----------
    positions, velocities : tuple of float
        Of the joints, rad and rad/s.
    linear, angular : float
        Scales of the commanded velocity and angular velocity: b and b².
    command : Twist
        What the path asks for here.
    """

    positions: Joints
    velocities: Joints
    linear: float
    angular: float
    command: Twist


@dataclass(frozen=True, slots=True)
class ArmPlan:
    """A motion of the arm, sampled at the loop's period; a row per cycle.

    Parameters
    ----------
    law : str
        Whose.
    outcome : str
        ``"done"``, or how it ends before the path does: ``"stalls"``, ``"halts"``.
    period : float
        s.
    duration : float
        To the end of the path, which need not be a whole number of periods, s.
    t : ndarray, shape (n,)
        s.
    positions, velocities : ndarray, shape (n, 6)
        Of the joints, rad and rad/s.
    scale : ndarray, shape (n, 2)
        b of velocity and of angular velocity.
    command : ndarray, shape (n, 6)
        The commanded twist before it is scaled, m/s and rad/s.
    hand : ndarray, shape (n, 3)
        Position of the tool point, m.
    twist : ndarray, shape (n, 6)
        Of the hand, J q', m/s and rad/s.
    indices : ndarray, shape (n, 3)
        c (m), S3, S5.
    inside : ndarray, shape (n,)
        Distance of the wrist centre inside the boundary of the workspace, m.
    path : ndarray, shape (n, 3)
        The place of the path that is nearest to the hand, m.
    marks : dict
        Instants by name, s: ``"region"`` where a region is entered and left.
    notes : tuple of str
        What was chosen, and why.
    """

    law: str
    outcome: str
    period: float
    duration: float
    t: Array
    positions: Array
    velocities: Array
    scale: Array
    command: Array
    hand: Array
    twist: Array
    indices: Array
    inside: Array
    path: Array
    marks: dict[str, tuple[float, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def at(self, t: float) -> ArmReference:
        """Return the reference of the cycle at `t` seconds; before 0 and after the end it rests."""
        k = round(t / self.period)
        following = 0 <= k < len(self.t)
        k = min(max(k, 0), len(self.t) - 1)
        q = tuple(self.positions[k].tolist())
        v = tuple(self.velocities[k].tolist()) if following else (0.0,) * 6
        return ArmReference(q, v, following)

    def stretched(self, share: float) -> "ArmPlan":
        """Return the same motion with a share of its speed: as many rows, further apart in time."""
        return replace(
            self, period=self.period / share, duration=self.duration / share, t=self.t / share,
            velocities=share * self.velocities, command=share * self.command,
            twist=share * self.twist,
            marks={name: tuple(t / share for t in its) for name, its in self.marks.items()},
        )  # fmt: skip

    @property
    def rates(self) -> Array:
        """The greater of each joint's planned and its mean rate to the next row, rad/s."""
        mean = np.diff(self.positions, axis=0, append=self.positions[-1:]) / self.period
        return np.asarray(np.fmax(np.abs(self.velocities), np.abs(mean)), dtype=np.float64)

    @property
    def accelerations(self) -> Array:
        """Change of each joint's velocity from row to row, but for the last, rad/s²."""
        return np.asarray(np.diff(self.velocities[:-1], axis=0) / self.period, dtype=np.float64)

    @property
    def peak_rates(self) -> Array:
        """Greatest speed of each joint, rad/s."""
        return np.asarray(np.abs(self.velocities).max(axis=0), dtype=np.float64)

    @property
    def peak_accelerations(self) -> Array:
        """Greatest change of velocity from row to row, of each joint, rad/s²."""
        return np.asarray(np.abs(self.accelerations).max(axis=0, initial=0.0), dtype=np.float64)

    @property
    def end_accelerations(self) -> Array:
        """What starting from rest and stopping within a period ask of each joint, rad/s²."""
        ends = np.abs(self.velocities[[0, max(len(self.velocities) - 2, 0)]])
        return np.asarray(ends.max(axis=0) / self.period, dtype=np.float64)

    @property
    def deviation(self) -> Array:
        """Distance of the hand from the path, m, shape (n,)."""
        return np.asarray(np.linalg.norm(self.hand - self.path, axis=1), dtype=np.float64)

    @property
    def path_deviation(self) -> float:
        """Greatest distance of the hand from the path, m."""
        return float(self.deviation.max())

    @property
    def twist_residual(self) -> float:
        """Greatest entry of ``J q' - (b v, b^2 w)``."""
        wanted = self.command * np.repeat(self.scale, 3, axis=1)
        return float(np.abs(self.twist - wanted).max())

    @property
    def crossings(self) -> tuple[float, ...]:
        """Instants at which the elbow goes through its singularity, s."""
        return tuple(self._zeros())

    def _zeros(self) -> Iterator[float]:
        from scipy.interpolate import CubicHermiteSpline
        from scipy.optimize import brentq

        s3 = self.indices[:, 1]
        for k in np.flatnonzero(s3[:-1] * s3[1:] < 0.0):
            # Inverse interpolation of the angle by a cubic with the rates as slopes. The angle
            # has its sign on both sides, however flat it is there: at rest, at a path's end.
            y0, y1 = float(np.arcsin(s3[k])), float(np.arcsin(s3[k + 1]))
            h = float(self.t[k + 1] - self.t[k])
            d0, d1 = h * float(self.velocities[k, 2]), h * float(self.velocities[k + 1, 2])
            angle = CubicHermiteSpline((0.0, 1.0), (y0, y1), (d0, d1))
            yield float(self.t[k]) + h * float(brentq(angle, 0.0, 1.0, xtol=1e-15))


class WithPlaces(Protocol):
    """A path that a hand is held against."""

    def foot(self, position: Vector) -> Vector:
        """Return the place that is nearest to a tool point, base axes, m."""


def make_plan(
    law: str,
    geometry: ArmGeometry,
    trajectory: WithPlaces,
    samples: list[Sample],
    period: float,
    duration: float,
    outcome: str = "done",
    marks: dict[str, tuple[float, ...]] | None = None,
) -> ArmPlan:
    """Return the plan of samples that are a period apart, with what figures need.

    Raises
    ------
    InfeasibleMotion
        A joint would leave its range.
    """
    arm = dimensions_of(geometry)
    t = period * np.arange(len(samples), dtype=np.float64)
    positions = np.array([sample.positions for sample in samples])
    nominal = period * np.cumsum([sample.linear for sample in samples])
    check_joint_limits(geometry, positions, t, lambda k: where_on(trajectory, float(nominal[k])))
    velocities = np.array([sample.velocities for sample in samples])
    hand = np.array([forward(arm, sample.positions).position for sample in samples])
    twist = np.array([hand_twist(arm, sample.positions, sample.velocities) for sample in samples])
    return ArmPlan(
        law=law,
        outcome=outcome,
        period=period,
        duration=duration,
        t=t,
        positions=positions,
        velocities=velocities,
        scale=np.array([(sample.linear, sample.angular) for sample in samples]),
        command=np.array([(*sample.command.linear, *sample.command.angular) for sample in samples]),
        hand=hand,
        twist=twist,
        indices=np.array([singularity_indices(arm, sample.positions) for sample in samples]),
        inside=np.array([inside_boundary(arm, sample.positions) for sample in samples]),
        path=np.array([trajectory.foot(tuple(p)) for p in hand.tolist()]),
        marks=marks or {},
    )


class OutOfRange(InfeasibleMotion):
    """A joint would leave its range.

    Attributes
    ----------
    turns : tuple of float, optional
        Whole turns of each joint, rad, by which the same motion is within all ranges; None: there
        are none.
    """

    def __init__(self, message: str, turns: Joints | None) -> None:
        super().__init__(message)
        self.turns = turns


class RangeWatch:
    """The joints of a motion so far; raises as soon as no whole turns keep them in their ranges.

    Parameters
    ----------
    geometry : ArmGeometry
        Whose ranges count.
    """

    def __init__(self, geometry: ArmGeometry) -> None:
        self._ranges = tuple(zip(geometry.position_min, geometry.position_max, strict=True))
        self._low = [math.inf] * len(self._ranges)
        self._high = [-math.inf] * len(self._ranges)

    def __call__(self, q: Joints) -> None:
        """Look at further joints, rad.

        Raises
        ------
        OutOfRange
            With the joint and how far it goes.
        """
        for j, angle in enumerate(q):
            if self._low[j] <= angle <= self._high[j]:
                continue
            low = self._low[j] = min(self._low[j], angle)
            high = self._high[j] = max(self._high[j], angle)
            lower, upper = self._ranges[j]
            if math.ceil((lower - low) / math.tau) > math.floor((upper - high) / math.tau):
                raise OutOfRange(
                    f"{AXIS_NAMES[j]} would go from {math.degrees(low):.2f} to "
                    f"{math.degrees(high):.2f} deg, which its range of {math.degrees(lower):.2f} "
                    f"to {math.degrees(upper):.2f} deg does not hold.",
                    None,
                )


def check_joint_limits(
    geometry: ArmGeometry,
    positions: Array,
    t: Array,
    where: Callable[[int], str] = lambda sample: "",
) -> None:
    """Raise if a joint leaves its range.

    Parameters
    ----------
    geometry : ArmGeometry
        With the ranges.
    positions : ndarray, shape (n, 6)
        rad.
    t : ndarray, shape (n,)
        s.
    where : callable
        Takes a sample's number, returns in words where it is.

    Raises
    ------
    OutOfRange
        With the joint, the first instant, the angle and the bound.
    """
    lower, upper = np.array(geometry.position_min), np.array(geometry.position_max)
    outside = (positions < lower) | (positions > upper)
    if not outside.any():
        return
    k = int(np.flatnonzero(outside.any(axis=1))[0])
    j = int(np.flatnonzero(outside[k])[0])
    least = np.ceil((lower - positions.min(axis=0)) / math.tau)
    most = np.floor((upper - positions.max(axis=0)) / math.tau)
    turns = (
        tuple((math.tau * np.clip(0.0, least, most)).tolist()) if (least <= most).all() else None
    )
    beyond = np.maximum(lower[j] - positions[:, j], positions[:, j] - upper[j])
    worst = int(np.argmax(beyond))
    bound = lower[j] if positions[k, j] < lower[j] else upper[j]
    words = (
        f"after {t[k]:.3f} s{where(k)} {AXIS_NAMES[j]} would be at "
        f"{_beside(positions[k, j], bound)}, outside its range of {math.degrees(lower[j]):.2f} to "
        f"{math.degrees(upper[j]):.2f} deg."
    )
    if beyond[worst] > 1.1 * beyond[k]:
        words += (
            f" It would be farthest outside after {t[worst]:.3f} s{where(worst)}, at "
            f"{_beside(positions[worst, j], bound)}."
        )
    raise OutOfRange(words, turns)


def _beside(angle: float, bound: float) -> str:
    """Return an angle in as many digits as tell it from a bound, or that it runs away."""
    if abs(angle) > _RUNS_AWAY:
        return f"more than {_RUNS_AWAY / math.tau:.0f} turns, as at a singularity"
    own, its = math.degrees(angle), math.degrees(bound)
    return next(f"{own:.{n}f} deg" for n in range(2, 17) if f"{own:.{n}f}" != f"{its:.{n}f}")


def inside_boundary(arm: Dimensions, q: Joints) -> float:
    """Return how far the wrist centre is inside the boundary of the workspace, m."""
    c, z = wrist_in_plane(arm, q[1], q[2])
    return arm.a2 + arm.a3 - math.hypot(c - arm.a1, z)
