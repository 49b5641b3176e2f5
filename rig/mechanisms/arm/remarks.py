"""What the planner says of a motion: where singularities lie, what branch it takes and why."""

import numpy as np

from controllers.arm.choice import branch_words
from controllers.arm.inverse import branch_of
from controllers.arm.kinematics import Dimensions
from controllers.arm.plan import ArmPlan
from controllers.arm.singular_places import singular_places
from rig.hal.motion import Note


def remarks_of_plan(plan: ArmPlan, arm: Dimensions) -> tuple[Note, ...]:
    """Return the branch at the start, what was chosen, and each singularity with its place."""
    first = branch_of(arm, tuple(plan.positions[0].tolist()))
    steps = np.linalg.norm(np.diff(plan.hand, axis=0), axis=1)
    gone = np.concatenate(([0.0], np.cumsum(steps)))
    return (
        Note("begins", f"on the branch {branch_words(first)}"),
        *(Note("chosen", note) for note in plan.notes),
        *(
            Note(f"{place.kind}, {plan.t[place.at]:.3f} s, {gone[place.at]:.4f} m", place.words)
            for place in singular_places(plan.indices, plan.positions)
        ),
    )
