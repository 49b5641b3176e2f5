"""A motion that has been worked out and checked, sample by sample."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.gait.balance import (
    from_edge,
    link_centres,
    margin,
    response_samples,
    support_polygon,
    zero_moment_point,
)
from controllers.gait.geometry import KNEES, LegGeometry
from controllers.gait.leg_postures import (
    leg_posture,
    mismatch,
    quantised,
    waist_from_foot,
)
from controllers.gait.phases import GaitPhase
from controllers.gait.pieces import in_pieces, pieces
from controllers.gait.time_laws import PaceSummary
from controllers.gait.types import BalanceSettings, LegsReference
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]

NEAR_SINGULAR = math.radians(5.0)
"""A knee below this angle is near the singularity, rad."""


class PlanSegment(NamedTuple):
    """A stretch of time that metrics look at: one phase, s."""

    name: str
    start: float
    end: float


class PlannedPhase(NamedTuple):
    """A phase as it was planned.

    Parameters
    ----------
    phase : GaitPhase
        As it was asked for.
    first, last : int
        Samples of its start and end.
    path_length : float
        m.
    joint_length : float
        Of the curve of all twelve joints, rad.
    pace : PaceSummary
        What the law has decided.
    """

    phase: GaitPhase
    first: int
    last: int
    path_length: float
    joint_length: float
    pace: PaceSummary


class Way(NamedTuple):
    """Places and directions of waist and feet at each sample.

    Parameters
    ----------
    waist : ndarray, shape (n, 3)
        m.
    yaw : ndarray, shape (n,)
        Heading of the waist, rad.
    feet : ndarray, shape (n, 2, 3)
        Right and left sole under the ankle, m.
    attitudes : ndarray, shape (n, 2, 3)
        Roll, pitch and yaw of the soles, rad.
    """

    waist: Array
    yaw: Array
    feet: Array
    attitudes: Array

    def put(self, k: int, phase: GaitPhase, xi: float) -> None:
        """Note where a phase has all of them at a path parameter, as sample `k`."""
        self.waist[k], self.yaw[k] = phase.waist_at(xi), phase.yaw_at(xi)
        for leg in (0, 1):
            self.feet[k, leg] = phase.foot_at(leg, xi)
            self.attitudes[k, leg] = phase.attitude_at(leg, xi)


def way_of(count: int) -> Way:
    """Return room for so many samples."""
    shapes = ((count, 3), (count,), (count, 2, 3), (count, 2, 3))
    return Way(*(np.zeros(shape) for shape in shapes))


class Balance(NamedTuple):
    """Margins of the robot's balance at each sample.

    Parameters
    ----------
    centre : ndarray, shape (n, 3)
        Of mass, in the ground's frame, m.
    zero_moment : ndarray, shape (n, 2)
        Zero-moment point, m.
    static_margin, margin : ndarray, shape (n,)
        Distance of the one, and of the nearer of both, from the edge of the support, m;
        negative outside.
    """

    centre: Array
    zero_moment: Array
    static_margin: Array
    margin: Array


@dataclass(frozen=True, slots=True, eq=False)
class GaitPlan:
    """A motion of the legs at every period.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    law : str
        That made it.
    period : float
        s.
    phases : tuple of PlannedPhase
        In their order.
    t : ndarray, shape (n,)
        s from the start.
    q, q_dot : ndarray, shape (n, 12)
        Joint angles, rad, and mean rates over the period before, rad/s.
    path : ndarray, shape (n,)
        Path parameter of the phase.
    phase_number : ndarray of int, shape (n,)
        The phase that a sample was reached in.
    waist : ndarray, shape (n, 3)
        In the ground's frame, m.
    feet : ndarray, shape (n, 2, 3)
        Right and left sole under the ankle, m.
    yaw : ndarray, shape (n,)
        Heading of the waist, rad.
    attitudes : ndarray, shape (n, 2, 3)
        Roll, pitch and yaw of right and left sole, rad.
    balance : Balance
        Centre of mass, zero-moment point and margins.
    """

    geometry: LegGeometry
    law: str
    period: float
    phases: tuple[PlannedPhase, ...]
    t: Array
    q: Array
    q_dot: Array
    path: Array
    phase_number: NDArray[np.int64]
    waist: Array
    feet: Array
    yaw: Array
    attitudes: Array
    balance: Balance

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.t[-1])

    @property
    def segments(self) -> tuple[PlanSegment, ...]:
        """One per phase."""
        period = self.period
        return tuple(
            PlanSegment(planned.phase.name, planned.first * period, planned.last * period)
            for planned in self.phases
        )

    def at(self, t: float) -> LegsReference:
        """Return what the legs should do at `t` seconds from the start."""
        sample = min(max(round(t / self.period), 0), len(self.t) - 1)
        return LegsReference(
            tuple(self.q[sample].tolist()), tuple(self.q_dot[sample].tolist()), True
        )

    def stretched(self, share: float, settings: BalanceSettings) -> "GaitPlan":
        """Return the same motion with a share of its speed, and its balance then.

        Parameters
        ----------
        share : float
            Of the speed; there are as many samples, further apart in time.
        settings : BalanceSettings
            As the law has them.

        Raises
        ------
        InfeasibleMotion
            The motion needs its speed: more slowly the robot would fall.
        """
        way = Way(self.waist, self.yaw, self.feet, self.attitudes)
        balance = judge_balance(
            self.geometry, settings, self.period / share, self.phases, self.q, way
        )
        slow = replace(
            self, period=self.period / share, t=self.t / share, q_dot=share * self.q_dot,
            balance=balance,
        )  # fmt: skip
        if slow.margin < settings.min_margin:
            worst = int(np.argmin(balance.margin))
            raise InfeasibleMotion(
                f"with {share:g} of its speed, at {slow.t[worst]:.3f} s "
                f"({self.phases[int(self.phase_number[worst])].phase.name}), the robot would be "
                f"{from_edge(slow.margin)}; the bound is {settings.min_margin * 1e3:g} mm inside."
            )
        return slow

    def mismatch(self, resolution: float = 0.0) -> float:
        """Return by how much the feet at most disagree on where the waist is, m.

        Parameters
        ----------
        resolution : float
            Of the servos, rad; 0 judges the plan as it is.
        """

        def apart(q: Array, feet: Array, attitudes: Array) -> Array:
            q = quantised(q, resolution) if resolution else q
            return mismatch(self.geometry, q, feet, attitudes)

        return float(np.max(in_pieces(apart, self.q, self.feet, self.attitudes)))

    def odometry(self) -> Array:
        """Return where the joints alone put the waist, shape (n, 3), m.

        Forward kinematics from the foot that stands, each foot standing where it landed.
        """

        def from_foot(leg: int) -> Array:
            def waist(q: Array, attitudes: Array) -> Array:
                return waist_from_foot(leg_posture(self.geometry, leg, q), attitudes)

            return in_pieces(waist, self.q, self.attitudes[:, leg])

        seen = [from_foot(leg) for leg in (0, 1)]
        feet = [self.feet[0, leg].copy() for leg in (0, 1)]
        waist = np.empty_like(self.waist)
        for planned in self.phases:
            during = slice(planned.first, planned.last + 1)
            right, left = planned.phase.standing
            stands, other = (0, 1) if right else (1, 0)
            waist[during] = feet[stands] + seen[stands][during]
            if not (right and left):
                feet[other] = waist[planned.last] - seen[other][planned.last]
        return waist

    @property
    def off_path(self) -> float:
        """How far the joints at most leave the waist's or a landing foot's path, m."""
        return float(np.max(np.linalg.norm(self.odometry() - self.waist, axis=1)))

    @property
    def advance(self) -> float:
        """How far the joints carry the waist ahead, m."""
        waist = self.odometry()
        return float(waist[-1, 0] - waist[0, 0])

    @property
    def turns(self) -> bool:
        """Whether the waist or a foot ever turns or tilts."""
        return bool(np.any(self.yaw) or np.any(self.attitudes))

    @property
    def peak_rates(self) -> Array:
        """Greatest rate of each joint, shape (12,), rad/s."""
        rates: Array = np.max(np.abs(self.q_dot), axis=0)
        return rates

    @property
    def peak_knee_rate(self) -> float:
        """Greatest rate of either knee, rad/s."""
        return float(np.max(self.peak_rates[list(KNEES)]))

    @property
    def peak_norm(self) -> float:
        """Greatest norm of the twelve joint rates, rad/s."""
        return float(np.max(np.linalg.norm(self.q_dot, axis=1)))

    @property
    def greatest_jump(self) -> float:
        """Greatest change of a joint's rate from one period to the next, ends included, rad/s."""
        return float(np.max(np.abs(np.diff(self.q_dot, axis=0, append=0.0))))

    @property
    def near_singular_windows(self) -> tuple[tuple[float, float], ...]:
        """Start and end of each stretch in which a knee is nearly straight, s."""
        near = np.min(self.q[:, list(KNEES)], axis=1) < NEAR_SINGULAR
        edges = np.flatnonzero(np.diff(np.concatenate(([False], near, [False])).astype(int)))
        return tuple(
            (float(self.t[first]), float(self.t[after - 1]))
            for first, after in edges.reshape(-1, 2).tolist()
        )

    @property
    def static_margin(self) -> float:
        """Least distance of the centre of mass from the edge of the support, m."""
        return float(np.min(self.balance.static_margin))

    @property
    def margin(self) -> float:
        """The same for the nearer of centre of mass and zero-moment point, m."""
        return float(np.min(self.balance.margin))

    def nearest_stable(self, t: float, bound: float) -> float:
        """Return the instant nearest to `t` at which a robot at rest stands safely, s.

        Parameters
        ----------
        t : float
            s.
        bound : float
            Least distance of the centre of mass from the edge of the support, m.

        Raises
        ------
        ValueError
            There is none.
        """
        stable = np.flatnonzero(self.balance.static_margin >= bound)
        if not len(stable):
            raise ValueError(f"at no instant is the centre of mass {bound * 1e3:g} mm inside.")
        return float(self.t[stable[np.argmin(np.abs(self.t[stable] - t))]])


def judge_balance(
    geometry: LegGeometry,
    settings: BalanceSettings,
    period: float,
    phases: tuple[PlannedPhase, ...],
    q: Array,
    way: Way,
) -> Balance:
    """Return centre of mass, zero-moment point and their margins at every sample.

    Where one phase ends and the next begins the stricter support of both counts. On feet at two
    heights the zero-moment point is taken in the level midway between them.
    """
    centre, zero_moment = np.empty((len(q), 3)), np.empty((len(q), 2))
    ground = np.zeros(len(q))
    for planned in phases:
        bearing = [
            foot[2]
            for foot, on in zip(planned.phase.feet, planned.phase.standing, strict=True)
            if on
        ]
        ground[planned.first : planned.last + 1] = sum(bearing) / len(bearing)
    wide = response_samples(period, settings.response_time)
    for piece in pieces(len(q)):
        seen = slice(max(piece.start - wide, 0), min(piece.stop + wide, len(q)))
        own = slice(piece.start - seen.start, piece.stop - seen.start)
        links = link_centres(geometry, q[seen], way.waist[seen], way.yaw[seen])
        point = zero_moment_point(links, period, settings.response_time, ground[seen])
        centre[piece], zero_moment[piece] = links.centre[own], point[own]
    static = np.full(len(q), math.inf)
    nearer = np.full(len(q), math.inf)
    for planned in phases:
        phase = planned.phase
        polygon = support_polygon(geometry, phase.feet, phase.standing, phase.attitudes)
        during = slice(planned.first, planned.last + 1)
        of_centre = margin(polygon, centre[during, :2])
        of_both = np.minimum(of_centre, margin(polygon, zero_moment[during]))
        static[during] = np.minimum(static[during], of_centre)
        nearer[during] = np.minimum(nearer[during], of_both)
    return Balance(centre, zero_moment, static, nearer)
