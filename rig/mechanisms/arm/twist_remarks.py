"""Where a hand that follows twists will stand and why, and what it is slowed down for."""

import math
from typing import Final

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.online.braking import periods_to_rest, slowed_to_rest
from controllers.arm.online.commands import ArmTwists
from controllers.arm.plan import ArmPlan
from rig.hal.motion import Note
from rig.mechanisms.arm.twist_facts import STANDS

_LONG: Final = 0.1
"""s; a hand that turns round stands for less."""
_AT_END: Final = math.radians(1.0)
"""rad: a joint that is so near to the end of its range has come to it."""
_TURNS: Final = 0.2
"""Share of its limit with which a joint turns for which the hand waits."""
_AT_BOUNDARY: Final = 2e-3
"""m: a wrist centre that is so near to the workspace's boundary has come to it."""


def remarks_on_rest(twists: ArmTwists, geometry: ArmGeometry, period: float) -> tuple[Note, ...]:
    """Return how much of their rates the joints may use, if they could not brake in time."""
    rest = periods_to_rest(twists, period)
    slowed = slowed_to_rest(geometry, rest, period).rate_limits
    shares = sorted(now / limit for now, limit in zip(slowed, geometry.rate_limits, strict=True))
    least, most = (f"{share:.2g}" for share in (shares[0], shares[-1]))
    if shares[0] == 1.0:
        return ()
    return (
        Note(
            "rest",
            f"joints keep to {least if least == most else f'{least} to {most}'} of their rates, so "
            f"that the hand is at rest {1e3 * twists.rest:g} ms after the last word "
            "(reference.rest)",
        ),
    )


def remarks_on_standing(plan: ArmPlan, geometry: ArmGeometry) -> tuple[Note, ...]:
    """Return each stretch in which the hand is asked to move and does not, with what holds it."""
    asked = np.abs(plan.command).max(axis=1) > 0.0
    stands = asked & (np.abs(plan.scale[:, 0]) < STANDS)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], stands, [False])).astype(int)))
    return tuple(
        Note(
            "stands",
            f"from {plan.t[first]:.3f} s to {plan.t[last - 1]:.3f} s, though a twist is asked "
            f"for: {_why(plan, geometry, first, last - 1)}",
        )
        for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if plan.t[last - 1] - plan.t[first] >= _LONG
    )


def _why(plan: ArmPlan, geometry: ArmGeometry, first: int, last: int) -> str:
    q = plan.positions[last]
    room = np.minimum(q - np.array(geometry.position_min), np.array(geometry.position_max) - q)
    joint = int(np.argmin(room))
    if room[joint] < _AT_END:
        return f"{AXIS_NAMES[joint]} is at the end of its range, {math.degrees(q[joint]):.4g} deg"
    if abs(plan.inside[last]) < _AT_BOUNDARY:
        return (
            "the hand is at the boundary of the workspace; with reference.boundary: back it "
            "would come back with the elbow on its other side"
        )
    turning = np.abs(plan.velocities[first : last + 1]).max(axis=0) / np.array(geometry.rate_limits)
    fastest = int(np.argmax(turning))
    if turning[fastest] > _TURNS:
        return f"the hand waits while {AXIS_NAMES[fastest]} turns beside a singularity"
    c, s3, s5 = np.abs(plan.indices[first]).tolist()
    return f"{plan.law} holds it there (c = {1e3 * c:.3g} mm, S3 = {s3:.3g}, S5 = {s5:.3g})"
