"""What is known beforehand of an arm that follows twists."""

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.online.commands import ArmTwists
from controllers.arm.plan import ArmPlan
from rig.hal.motion import Fact
from rig.mechanisms.arm.facts import INDICES
from rig.mechanisms.arm.twist_lines import off_direction

_STANDS = 1e-3
"""Share of what is asked for below which the hand stands."""


def facts_of_twists(plan: ArmPlan, geometry: ArmGeometry, asked: ArmTwists) -> dict[str, Fact]:
    """Return the numbers that are known of an arm that follows twists."""
    rates, limits = plan.rates.max(axis=0), np.array(geometry.rate_limits)
    change = np.diff(plan.velocities, axis=0, prepend=np.zeros((1, 6)))
    jump = float((np.abs(change) / limits).max()) / (1e3 * plan.period)
    accelerations = np.abs(change).max(axis=0) / plan.period
    over = float((accelerations / np.array(geometry.acceleration_limits)).max())
    told = np.abs(plan.command).max(axis=1) > 0.0
    share = np.where(told, plan.scale[:, 0], 1.0)
    away, turned = off_direction(plan, geometry, asked)
    speed = np.linalg.norm(plan.command[:, :3], axis=1)
    whole = float(speed.sum()) * plan.period
    way = float(np.linalg.norm(np.diff(plan.hand, axis=0), axis=1).sum())
    along = float((share * speed)[told].sum()) * plan.period
    facts = {
        "time_end": Fact(plan.duration, "s", "until the hand is at rest after the last twist"),
        "off_direction": Fact(away, "m", "greatest way of the hand off a twist's line"),
        "turned_off": Fact(turned, "rad", "greatest turn of the tool beside that of a twist"),
        "lag": Fact(
            float((1.0 - share).sum()) * plan.period, "s", "what the hand is late by at the end"
        ),
        "standing_share": Fact(
            float((share < _STANDS).sum()) / max(int(told.sum()), 1), "",
            "share of the time with a twist in which the hand stands",
        ),
        "distance_asked": Fact(whole, "m", "way of the hand that the twists ask for"),
        "distance": Fact(way, "m", "way of the hand"),
        "distance_share": Fact(along / whole if whole else 1.0, "", "of it along the twists"),
        "peak_rate_share": Fact(float((rates / limits).max()), "", "greatest rate over its limit"),
        "peak_acceleration_share": Fact(over, "", "greatest acceleration over its limit"),
        "rate_jump": Fact(jump, "", "greatest change of a rate within 1 ms over its limit"),
        "peak_rate_arm": Fact(float(rates[:3].max()), "rad/s", "greatest rate of q1 to q3"),
        "peak_rate_wrist": Fact(float(rates[3:].max()), "rad/s", "greatest rate of q4 to q6"),
        "peak_acceleration": Fact(float(accelerations.max()), "rad/s^2", "of any joint"),
        "elbow_sign_changes": Fact(float(len(plan.crossings)), "", "passes through the elbow's"),
    }  # fmt: skip
    for name, rate in zip(AXIS_NAMES, rates, strict=True):
        facts[f"peak_rate_{name}"] = Fact(float(rate), "rad/s", f"greatest rate of {name}")
    for (name, unit), values in zip(INDICES, plan.indices.T, strict=True):
        facts[f"closest_{name}"] = Fact(
            float(np.abs(values).min()), unit, f"least index of the {name}"
        )
    return facts
