"""What the planner says of a motion: where singularities lie, what branch it takes and why."""

import numpy as np

from controllers.arm.choice import branch_words
from controllers.arm.geometry import AXIS_NAMES
from controllers.arm.inverse import branch_of
from controllers.arm.kinematics import Dimensions
from controllers.arm.plan import ArmPlan
from controllers.arm.singular_places import singular_places
from rig.hal.motion import Note

_AT_REST = 1.001
"""Share of an acceleration limit up to which a motion begins and ends at rest."""


def remarks_of_plan(
    plan: ArmPlan, arm: Dimensions, acceleration_limits: tuple[float, ...]
) -> tuple[Note, ...]:
    """Return the branch and a step of speed at the start, what was chosen, and each singularity.

    `acceleration_limits` are the joints', rad/s².
    """
    first = branch_of(arm, tuple(plan.positions[0].tolist()))
    steps = np.linalg.norm(np.diff(plan.hand, axis=0), axis=1)
    gone = np.concatenate(([0.0], np.cumsum(steps)))
    return (
        Note("begins", f"on the branch {branch_words(first)}"),
        *_steps_of_speed(plan, acceleration_limits),
        *(Note("chosen", note) for note in plan.notes),
        *(
            Note(f"{place.kind}, {plan.t[place.at]:.3f} s, {gone[place.at]:.4f} m", place.words)
            for place in singular_places(plan.indices, plan.positions)
        ),
    )


def _steps_of_speed(plan: ArmPlan, limits: tuple[float, ...]) -> list[Note]:
    """Return what the drives are in for where a law does not begin and end at rest."""
    shares = plan.end_accelerations / np.array(limits)
    joint = int(np.argmax(shares))
    if shares[joint] <= _AT_REST:
        return []
    return [
        Note(
            "starts or stops",
            f"at its speed: within a period {AXIS_NAMES[joint]} would need "
            f"{plan.end_accelerations[joint]:.3g} rad/s^2, its limit is {limits[joint]:g} rad/s^2; "
            f"look-ahead, and esc with from_rest: true, begin and end at rest",
        )
    ]
