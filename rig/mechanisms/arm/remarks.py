"""What the planner says of a motion: where singularities lie, what branch it takes and why."""

import numpy as np

from controllers.arm.choice import branch_words
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.inverse import branch_of
from controllers.arm.kinematics import Dimensions
from controllers.arm.plan import ArmPlan
from controllers.arm.singular_places import singular_places
from rig.hal.motion import Note

_WITHIN = 1.001
"""Share of a limit up to which a motion keeps to it."""
_SWINGS = 1e-3
"""rad: a joint that turns by less has passed nothing."""
_OFF = 1e-5
"""m: what promises its path keeps to it by far less."""
_THROUGH = ("look-ahead and esc go", "look-ahead goes")
"""Who gets to the end: as told of any law, and of esc."""


def remarks_of_plan(plan: ArmPlan, arm: Dimensions, geometry: ArmGeometry) -> tuple[Note, ...]:
    """Return the branch, what the drives cannot do, what was chosen, each singularity, the end."""
    first = branch_of(arm, tuple(plan.positions[0].tolist()))
    steps = np.linalg.norm(np.diff(plan.hand, axis=0), axis=1)
    gone = np.concatenate(([0.0], np.cumsum(steps)))
    return (
        Note("begins", f"on the branch {branch_words(first)}, with the hand at {_place(plan)}"),
        *_steps_of_speed(plan, geometry.acceleration_limits),
        *_fastest(plan, geometry.rate_limits),
        *_off_path(plan),
        *(Note("chosen", note) for note in plan.notes),
        *(
            Note(
                f"{place.kind}, {plan.t[place.at]:.3f} s, {gone[place.at]:.4f} m",
                place.words + _beside(plan, place.at),
            )
            for place in singular_places(plan.indices, plan.positions)
            if place.through or max(place.swings) > _SWINGS
        ),
        *_ends_early(plan, float(gone[-1])),
    )


def _place(plan: ArmPlan) -> str:
    """Return where the hand begins, as a path's centre or place would say it."""
    x, y, z = (1e3 * plan.hand[0]).tolist()
    return f"[{x:.6g} mm, {y:.6g} mm, {z:.6g} mm]"


def _fastest(plan: ArmPlan, limits: tuple[float, ...]) -> list[Note]:
    """Return which joint a law asks for more than it can do, or for the most of its rate."""
    shares = np.abs(plan.velocities) / np.array(limits)
    sample, joint = np.unravel_index(int(np.argmax(shares)), shares.shape)
    name, peak, limit = AXIS_NAMES[joint], abs(plan.velocities[sample, joint]), limits[joint]
    if shares[sample, joint] > _WITHIN:
        return [
            Note(
                "is too fast",
                f"for {name}, which would need {peak:.3g} rad/s of {limit:g} rad/s: {plan.law} "
                f"promises no rates, and the hand will not keep to its path",
            )
        ]
    c, s3, s5 = plan.indices[sample].tolist()
    return [
        Note(
            "is fastest",
            f"in {name}, {100 * shares[sample, joint]:.3g} % of {limit:g} rad/s after "
            f"{plan.t[sample]:.3f} s; there the wrist is {1e3 * abs(c):.3g} mm from the axis of "
            f"q1, S3 = {s3:.3g}, S5 = {s5:.3g}",
        )
    ]


def _off_path(plan: ArmPlan) -> list[Note]:
    """Return where a law that promises no path leaves it farthest, of what is known beforehand."""
    if plan.path_deviation <= _OFF:
        return []
    k = int(np.argmax(plan.deviation))
    return [
        Note(
            "leaves its path",
            f"by {1e3 * plan.path_deviation:.3g} mm after {plan.t[k]:.3f} s: {plan.law} does so "
            f"near singularities, and where the arm cannot reach; look-ahead stays on a path, or "
            f"says where it cannot",
        )
    ]


def _beside(plan: ArmPlan, k: int) -> str:
    off = float(plan.deviation[k])
    return f"; {1e3 * off:.3g} mm beside the path" if off > _OFF else ""


def _ends_early(plan: ArmPlan, way: float) -> list[Note]:
    """Return where a law stays that does not get to the end of its path."""
    if plan.outcome == "done":
        return []
    return [
        Note(
            "ends early",
            f"{plan.law} {plan.outcome} after {plan.duration:.3f} s and {way:.4g} m, before the "
            f"end of the path; {_THROUGH[plan.law == 'esc']} through singularities",
        )
    ]


def _steps_of_speed(plan: ArmPlan, limits: tuple[float, ...]) -> list[Note]:
    """Return what the drives are in for where a law does not begin and end at rest."""
    shares = plan.end_accelerations / np.array(limits)
    joint = int(np.argmax(shares))
    if shares[joint] <= _WITHIN:
        return []
    return [
        Note(
            "starts or stops",
            f"at its speed: within a period {AXIS_NAMES[joint]} would need "
            f"{plan.end_accelerations[joint]:.3g} rad/s^2, its limit is {limits[joint]:g} rad/s^2; "
            f"look-ahead, and esc with from_rest: true, begin and end at rest",
        )
    ]
