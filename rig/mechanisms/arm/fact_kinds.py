"""What is known of an arm's motion before it is done: each number's unit and meaning."""

from collections.abc import Mapping
from typing import Final

from controllers.arm.geometry import AXIS_NAMES
from rig.hal.motion import FactKind

INDICES = (("shoulder", "m"), ("elbow", ""), ("wrist", ""))
"""Singularity indices c, S3 and S5: names and units."""
OUTCOMES = ("done", "halts", "stalls")
"""How a law's motion ends; a fact gives the place in this list."""

RATES: Final = {
    f"peak_rate_{name}": FactKind("rad/s", f"greatest rate of {name}") for name in AXIS_NAMES
}
CLOSEST: Final = {
    f"closest_{name}": FactKind(unit, f"least index of the {name}'s singularity; 0 is at it")
    for name, unit in INDICES
}

PATH_FACTS: Final[Mapping[str, FactKind]] = {
    "time_end": FactKind("s", "duration of the motion"),
    "time_optimum": FactKind("s", "least time under the joints' rate limits alone"),
    "time_over_optimum": FactKind(
        "", "duration over the least one, which knows the joints' rate limits alone"
    ),
    "time_crossing": FactKind(
        "s", "first pass through the elbow's singularity; those of shoulder and wrist are remarks"
    ),
    "dwell_time": FactKind("s", "time in the region near the boundary"),
    "outcome": FactKind("", f"how the law ends it, 0, 1, 2: {', '.join(OUTCOMES)}"),
    "completes": FactKind("", "1 if the law gets to the path's end"),
    "path_deviation": FactKind("m", "greatest distance of the hand from the path"),
    "twist_residual": FactKind("", "greatest entry of J q' - (b v, b² w)"),
    "return_error": FactKind("rad", "joints at the end from those at the start, whole turns apart"),
    "elbow_sign_changes": FactKind("", "passes through the elbow's singularity"),
    "closest_boundary": FactKind("m", "least distance of the wrist from the workspace's boundary"),
    "peak_rate_share": FactKind("", "greatest rate of a joint over its limit"),
    "peak_acceleration_share": FactKind(
        "", "greatest acceleration of a joint over its limit, on the way"
    ),
    "end_acceleration_share": FactKind(
        "", "acceleration of start and stop over its limit: above 1 they are steps of the speed"
    ),
    "peak_torque_share": FactKind("", "greatest torque foreseen of a drive over its limit"),
    "peak_rate_arm": FactKind("rad/s", "greatest rate of q1 to q3"),
    "peak_rate_wrist": FactKind("rad/s", "greatest rate of q4 to q6"),
    "peak_acceleration_arm": FactKind("rad/s^2", "greatest acceleration of q1 to q3"),
    "peak_acceleration": FactKind("rad/s^2", "greatest acceleration of any joint"),
    **RATES,
    **{
        f"peak_torque_{name}": FactKind("N m", f"greatest torque foreseen of {name}")
        for name in AXIS_NAMES
    },
    **CLOSEST,
    **{
        f"crosses_{name}": FactKind("", f"1 if the motion crosses the {name}'s singularity")
        for name, _ in INDICES
    },
}

TWIST_FACTS: Final[Mapping[str, FactKind]] = {
    "time_end": FactKind("s", "until the hand is at rest after the last twist"),
    "off_direction": FactKind("m", "greatest way of the hand off a twist's line"),
    "turned_off": FactKind("rad", "greatest turn of the tool beside that of a twist"),
    "lag": FactKind("s", "what the hand is late by at the end"),
    "standing_share": FactKind("", "share of the time with a twist in which the hand stands"),
    "distance_asked": FactKind("m", "way of the hand that the twists ask for"),
    "distance": FactKind("m", "way of the hand"),
    "distance_share": FactKind(
        "", "share of the way that was asked for that the hand goes along the twists"
    ),
    "peak_rate_share": FactKind("", "greatest rate of a joint over its limit"),
    "peak_acceleration_share": FactKind("", "greatest acceleration of a joint over its limit"),
    "rate_jump": FactKind("", "greatest change of a rate within 1 ms over its limit"),
    "peak_rate_arm": FactKind("rad/s", "greatest rate of q1 to q3"),
    "peak_rate_wrist": FactKind("rad/s", "greatest rate of q4 to q6"),
    "peak_acceleration": FactKind("rad/s^2", "greatest acceleration of any joint"),
    "elbow_sign_changes": FactKind("", "passes through the elbow's singularity"),
    **RATES,
    **CLOSEST,
}
