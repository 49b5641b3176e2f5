"""What is known of a walk before it is done: each number's unit and meaning."""

from collections.abc import Mapping
from typing import Final

from rig.hal.motion import FactKind

LEGS_FACTS: Final[Mapping[str, FactKind]] = {
    "plan_duration": FactKind("s", "how long the motion takes"),
    "peak_knee_rate": FactKind("rad/s", "greatest rate of a knee, sampled at 1 kHz"),
    "peak_norm_rate": FactKind("rad/s", "greatest norm of the joint rates"),
    "rate_jump": FactKind("rad/s", "greatest jump of a rate in 1 ms"),
    "advance": FactKind("m", "how far the planned joints carry the waist"),
    "advance_lost": FactKind("m", "by how much the waist goes less or more far than was asked for"),
    "path_deviation": FactKind("m", "how far the joints leave the path"),
    "tilt": FactKind("rad", "how far a sole turns out of the horizontal or aside"),
    "leg_mismatch": FactKind("m", "disagreement of the legs on the waist"),
    "leg_mismatch_quantised": FactKind(
        "m", "disagreement of the legs on the waist at 209 pulses per degree of a joint"
    ),
    "min_knee": FactKind("rad", "the straightest knee"),
    "start_knee": FactKind("rad", "the more bent knee at the start"),
    "static_margin": FactKind(
        "m", "least distance of the centre of mass inside the support's edge"
    ),
    "balance_margin": FactKind(
        "m", "least distance of centre of mass and zero-moment point inside the support's edge"
    ),
    "near_singular_windows": FactKind("", "stretches with a knee below 5 deg"),
    "near_singular_astray": FactKind(
        "", "stretches with a knee below 5 deg that are at no landing or arrival"
    ),
    "least_unraised_reach": FactKind(
        "", "share of its path that a phase does under sc without raised speed"
    ),
    "most_unraised_reach": FactKind(
        "", "share of its path that the phase which is cut least does under sc without raised speed"
    ),
    "standing_knee_torque": FactKind("N m", "mean torque at rest of the knee that stands alone"),
    "knee_torque_saved": FactKind(
        "N m", "how much less torque at rest that knee needs than at constant height"
    ),
}
