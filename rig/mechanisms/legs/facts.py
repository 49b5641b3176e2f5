"""What is known of a walk before it is done: the numbers of its plan."""

from collections.abc import Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from controllers.gait.arc_lengths import measure
from controllers.gait.balance import standing_knee_torque
from controllers.gait.geometry import KNEES
from controllers.gait.laws import LimitedNormLaw, LimitedNormSettings
from controllers.gait.leg_postures import leg_posture, rotations
from controllers.gait.pieces import in_pieces
from controllers.gait.plan import GaitPlan
from controllers.gait.time_laws import LimitedNormPace
from rig.hal.motion import Fact, facts_of
from rig.mechanisms.legs.fact_kinds import LEGS_FACTS

Array = NDArray[np.float64]

_RESOLUTION = float(np.deg2rad(1.0 / 209.0))
"""Of HOAP's servos, rad: 209 pulses per degree; the legs' mismatch is given for it as well."""


_ROUNDING = 1e-9
_AT_ONCE = 0.05
"""A stretch near the singularity belongs to an instant that is in it, or this near to it, s."""


def plan_facts(
    plan: GaitPlan, fine: GaitPlan, distance: float, flat: GaitPlan | None = None
) -> Mapping[str, Fact]:
    """Return the numbers of a plan that metrics may name.

    Parameters
    ----------
    plan : GaitPlan
        At the loop's period.
    fine : GaitPlan
        The same at 1 kHz, for peak rates.
    distance : float
        How far the waist was to go, m.
    flat : GaitPlan, optional
        The same walk with the hip at constant height, if this one's is not.
    """
    reached = _unraised_reaches(plan)
    torque = _standing_knee_torque(plan)
    saved = _standing_knee_torque(flat) - torque if flat is not None else 0.0
    windows = plan.near_singular_windows
    values = {
        "plan_duration": plan.duration,
        "peak_knee_rate": fine.peak_knee_rate,
        "peak_norm_rate": fine.peak_norm,
        "rate_jump": fine.greatest_jump,
        "advance": plan.advance,
        "advance_lost": abs(distance - plan.advance),
        "path_deviation": max(plan.off_path, fine.off_path),
        "tilt": _tilt(fine),
        "leg_mismatch": max(plan.mismatch(), fine.mismatch()),
        "leg_mismatch_quantised": plan.mismatch(_RESOLUTION),
        "min_knee": float(fine.q[:, list(KNEES)].min()),
        "start_knee": float(fine.q[0, list(KNEES)].max()),
        "static_margin": plan.static_margin,
        "balance_margin": plan.margin,
        "near_singular_windows": float(len(windows)),
        "near_singular_astray": float(_astray(plan)),
        "least_unraised_reach": min(reached),
        "most_unraised_reach": max(
            (share for share in reached if share < 1.0 - _ROUNDING), default=1.0
        ),
        "standing_knee_torque": torque,
        "knee_torque_saved": saved,
    }
    return facts_of(LEGS_FACTS, values)


def _unraised_reaches(plan: GaitPlan) -> list[float]:
    """Return how far each phase gets if the joints' norm is bounded and no speed is raised."""
    if plan.law == LimitedNormLaw.name:
        return [planned.pace.reach_unraised for planned in plan.phases]
    cycles = [planned.last - planned.first for planned in plan.phases]
    means = [
        planned.joint_length / (count * plan.period)
        for planned, count in zip(plan.phases, cycles, strict=True)
    ]
    bound = LimitedNormSettings().norm_factor * max(means)
    return [
        LimitedNormPace(
            measure(plan.geometry, planned.phase), count, plan.period, bound
        ).summary.reach_unraised
        for planned, count in zip(plan.phases, cycles, strict=True)
    ]


def _standing_knee_torque(plan: GaitPlan) -> float:
    """Return the mean magnitude over the time in which one leg stands, N m; 0 if both always do."""
    torques = []
    for planned in plan.phases:
        right, left = planned.phase.standing
        if right != left:
            during = slice(planned.first, planned.last + 1)
            leg = 0 if right else 1
            borne = partial(standing_knee_torque, plan.geometry, leg)
            torques.append(in_pieces(borne, plan.q[during], plan.waist[during]))
    return float(np.abs(np.concatenate(torques)).mean()) if torques else 0.0


def _astray(plan: GaitPlan) -> int:
    """Return how many near-singular stretches hold no instant between two phases, or the end."""
    instants = [planned.last * plan.period for planned in plan.phases]
    return sum(
        not any(start - _AT_ONCE <= instant <= end + _AT_ONCE for instant in instants)
        for start, end in plan.near_singular_windows
    )


def _tilt(plan: GaitPlan) -> float:
    """Return the greatest angle between a sole and how it was to lie, under an upright waist."""

    def tilts(leg: int, q: Array, yaw: Array, attitudes: Array) -> Array:
        heading = np.zeros((len(yaw), 3))
        heading[:, 2] = yaw
        wanted = np.swapaxes(rotations(heading), 1, 2) @ rotations(attitudes)
        turned = np.swapaxes(wanted, 1, 2) @ leg_posture(plan.geometry, leg, q).foot
        # Of a rotation matrix, the part that is not symmetric is sin(angle) times the axis.
        sines = 0.5 * np.stack(
            [turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0],
             turned[:, 1, 0] - turned[:, 0, 1]]
        )  # fmt: skip
        return np.asarray(np.linalg.norm(sines, axis=0), dtype=np.float64)

    worst = max(
        float(in_pieces(partial(tilts, leg), plan.q, plan.yaw, plan.attitudes[:, leg]).max())
        for leg in (0, 1)
    )
    return float(np.arcsin(min(worst, 1.0)))
