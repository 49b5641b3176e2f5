"""Twists that are known beforehand, gone through by the law before anything moves."""

import math

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import Dimensions, dimensions_of, forward, hand_twist
from controllers.arm.on_direction.direction import moved_on
from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.commands import twist_at
from controllers.arm.online.follower import TwistFollower
from controllers.arm.online.rivals import turned_into_base
from controllers.arm.online.twist_file import Row
from controllers.arm.plan import ArmPlan, Sample, make_plan
from controllers.arm.types import AT_REST, Twist, Vector
from controllers.arm.vectors import turned
from controllers.motion import InfeasibleMotion, check_length

_STOPPING = 2.0
"""After the last row the hand has to be at rest within this time, s."""


class HandItself:
    """The path of a hand that has none given: wherever it is."""

    def foot(self, position: Vector) -> Vector:
        """Return the place."""
        return position


def asked_in_base(geometry: ArmGeometry, q: Six, twist: Six, frame: str, ahead: float = 0.0) -> Six:
    """Return a twist in the base's axes.

    Parameters
    ----------
    geometry : ArmGeometry
        The arm.
    q : tuple of float
        Joints now, rad.
    twist : tuple of float
        Velocity and angular velocity, m/s and rad/s.
    frame : str
        ``base``, or ``tool``: in the tool's axes.
    ahead : float
        For how long the tool will have done the twist when it is in the middle of its way, s: the
        tool's axes are meant as they are then. A screw is followed with straight steps so.
    """
    if frame == "base":
        return twist
    rotation = forward(dimensions_of(geometry), q).rotation
    vx, vy, vz, wx, wy, wz = turned_into_base(rotation, twist)
    rate = math.hypot(wx, wy, wz)
    if rate * ahead == 0.0:
        return vx, vy, vz, wx, wy, wz
    axis = (wx / rate, wy / rate, wz / rate)
    (vx, *_), (vy, *_), (vz, *_) = turned(axis, rate * ahead, ((vx, 0, 0), (vy, 0, 0), (vz, 0, 0)))
    return vx, vy, vz, wx, wy, wz


def twist_within(arm: Dimensions, q: Six, rates: Six, period: float) -> tuple[float, ...]:
    """Return the hand's twist in the middle of a period that ends at `q`, m/s and rad/s."""
    return hand_twist(arm, moved_on(q, rates, -0.5 * period), rates)


def share_of(asked: Six, done: tuple[float, ...]) -> float:
    """Return how much of a twist is done along it, b; 0 where none is asked for."""
    size = sum(a * a for a in asked)
    return sum(a * b for a, b in zip(asked, done, strict=True)) / size if size > 0.0 else 0.0


def rehearse(
    law: str,
    geometry: ArmGeometry,
    period: float,
    follower: TwistFollower,
    rows: list[Row],
    frame: str,
    longest: float,
) -> ArmPlan:
    """Return what the arm will do; a row per cycle, its joints those at the cycle's end.

    In the first cycle it rests where the approach has brought it, as in the loop.

    Raises
    ------
    InfeasibleMotion
        It takes too long, or the hand does not come to rest.
    """
    end = rows[-1][0]
    check_length(end, longest)
    arm, b = dimensions_of(geometry), 0.0
    samples = [Sample(follower.positions, AT_REST, 0.0, 0.0, Twist(AT_REST[:3], AT_REST[3:]))]
    while True:
        t = len(samples) * period
        half = 0.5 * period * b
        asked = asked_in_base(geometry, follower.positions, twist_at(rows, t), frame, half)
        q, rates = follower.step(asked)
        b = share_of(asked, twist_within(arm, q, rates, period))
        samples.append(Sample(q, rates, b, b, Twist(asked[:3], asked[3:])))
        if t >= end and rates == AT_REST:
            break
        if t > end + _STOPPING:
            raise InfeasibleMotion(f"the hand is not at rest {_STOPPING:g} s after the last row.")
    return make_plan(law, geometry, HandItself(), samples, period, (len(samples) - 1) * period)
