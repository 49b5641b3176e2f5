"""What is known beforehand of an arm that follows twists."""

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.online.commands import ArmTwists
from controllers.arm.plan import ArmPlan
from controllers.arm.singular_places import least_size
from rig.hal.motion import Fact, facts_of
from rig.mechanisms.arm.fact_kinds import INDICES, TWIST_FACTS
from rig.mechanisms.arm.twist_lines import off_direction

STANDS = 1e-3
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
        "time_end": plan.duration,
        "off_direction": away,
        "turned_off": turned,
        "lag": float((1.0 - share).sum()) * plan.period,
        "standing_share": float((np.abs(share) < STANDS).sum()) / max(int(told.sum()), 1),
        "distance_asked": whole,
        "distance": way,
        "distance_share": along / whole if whole else 1.0,
        "peak_rate_share": float((rates / limits).max()),
        "peak_acceleration_share": over,
        "rate_jump": jump,
        "peak_rate_arm": float(rates[:3].max()),
        "peak_rate_wrist": float(rates[3:].max()),
        "peak_acceleration": float(accelerations.max()),
        "elbow_sign_changes": float(len(plan.crossings)),
    }  # fmt: skip
    for name, rate in zip(AXIS_NAMES, rates, strict=True):
        facts[f"peak_rate_{name}"] = float(rate)
    for (name, _), values in zip(INDICES, plan.indices.T, strict=True):
        facts[f"closest_{name}"] = least_size(values)
    return facts_of(TWIST_FACTS, facts)
