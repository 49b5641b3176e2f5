"""What is known of a walk before it is done: the numbers of its plan."""

from collections.abc import Mapping

import numpy as np

from controllers.gait.geometry import KNEES
from controllers.gait.plan import GaitPlan
from controllers.gait.postures import leg_posture
from rig.runtime.motion import Fact

_RESOLUTION = float(np.deg2rad(1.0 / 209.0))
"""Of HOAP's servos, rad: 209 pulses per degree; the legs' mismatch is given for it as well."""


def plan_facts(plan: GaitPlan, fine: GaitPlan, distance: float) -> Mapping[str, Fact]:
    """Return the numbers of a plan that metrics may name.

    Parameters
    ----------
    plan : GaitPlan
        At the loop's period.
    fine : GaitPlan
        The same at 1 kHz, for peak rates.
    distance : float
        How far the waist was to go, m.
    """
    reached = [phase.pace.reach_unraised for phase in plan.phases]
    return {
        "peak_knee_rate": Fact(fine.peak_knee_rate, "rad/s", "greatest knee rate, at 1 kHz"),
        "peak_norm_rate": Fact(fine.peak_norm, "rad/s", "greatest norm of the joint rates"),
        "rate_jump": Fact(fine.greatest_jump, "rad/s", "greatest jump of a rate in 1 ms"),
        "advance": Fact(plan.advance, "m", "how far the planned joints carry the waist"),
        "advance_lost": Fact(
            abs(distance - plan.advance), "m", "by how much that is not what was asked for"
        ),
        "path_deviation": Fact(fine.off_path, "m", "how far the joints leave the path"),
        "tilt": Fact(_tilt(fine), "rad", "how far a sole turns out of the horizontal or aside"),
        "leg_mismatch": Fact(fine.mismatch(), "m", "disagreement of the legs on the waist"),
        "leg_mismatch_quantised": Fact(
            plan.mismatch(_RESOLUTION), "m", "the same at 209 pulses per degree"
        ),
        "min_knee": Fact(float(fine.q[:, list(KNEES)].min()), "rad", "the straightest knee"),
        "static_margin": Fact(plan.static_margin, "m", "centre of mass inside the support"),
        "balance_margin": Fact(plan.margin, "m", "centre of mass and zero-moment point"),
        "near_singular_windows": Fact(
            float(len(plan.near_singular_windows)), "", "stretches with a knee below 5 deg"
        ),
        "least_unraised_reach": Fact(
            min(reached), "", "share of its path that a phase would do without raised speed"
        ),
    }


def _tilt(plan: GaitPlan) -> float:
    """Return the greatest angle between a sole and the ground's axes, under an upright waist."""
    worst = 0.0
    for leg in (0, 1):
        turned = leg_posture(plan.geometry, leg, plan.q).foot
        # Of a rotation matrix, the part that is not symmetric is sin(angle) times the axis.
        sines = 0.5 * np.stack(
            [turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0],
             turned[:, 1, 0] - turned[:, 0, 1]]
        )  # fmt: skip
        worst = max(worst, float(np.linalg.norm(sines, axis=0).max()))
    return float(np.arcsin(min(worst, 1.0)))
