"""Twists that are known beforehand, gone through by the law before anything moves."""

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import Dimensions, dimensions_of, forward, hand_twist
from controllers.arm.on_direction.direction import moved_on
from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.commands import Row, twist_at
from controllers.arm.online.follower import TwistFollower
from controllers.arm.online.rivals import turned_into_base
from controllers.arm.plan import ArmPlan, Sample, make_plan
from controllers.arm.types import AT_REST, Twist, Vector
from controllers.motion import InfeasibleMotion, check_length

_STOPPING = 2.0
"""After the last row the hand has to be at rest within this time, s."""


class HandItself:
    """The path of a hand that has none given: wherever it is."""

    def foot(self, position: Vector) -> Vector:
        """Return the place."""
        return position


def asked_in_base(geometry: ArmGeometry, q: Six, twist: Six, frame: str) -> Six:
    """Return a twist in the base's axes."""
    if frame == "base":
        return twist
    return turned_into_base(forward(dimensions_of(geometry), q).rotation, twist)


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

    Raises
    ------
    InfeasibleMotion
        It takes too long, or the hand does not come to rest.
    """
    end = rows[-1][0]
    check_length(end, longest)
    arm, samples = dimensions_of(geometry), list[Sample]()
    while True:
        t = len(samples) * period
        asked = asked_in_base(geometry, follower.positions, twist_at(rows, t), frame)
        q, rates = follower.step(asked)
        b = share_of(asked, twist_within(arm, q, rates, period))
        samples.append(Sample(q, rates, b, b, Twist(asked[:3], asked[3:])))
        if t >= end and rates == AT_REST:
            break
        if t > end + _STOPPING:
            raise InfeasibleMotion(f"the hand is not at rest {_STOPPING:g} s after the last row.")
    return make_plan(law, geometry, HandItself(), samples, period, (len(samples) - 1) * period)
