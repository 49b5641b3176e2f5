"""What is known of an arm's motion before it is done: numbers for metrics and comparisons."""

import math
from dataclasses import replace
from typing import get_args

import numpy as np

from controllers.arm.dynamics.carried import torques_for, torques_of_plan
from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.optimum import least_time
from controllers.arm.plan import ArmPlan
from controllers.arm.pose_path import PosePath
from controllers.arm.singular_places import least_size
from controllers.arm.trajectories import ArmPathSettings
from controllers.motion import InfeasibleMotion
from rig.hal.motion import Fact, facts_of
from rig.mechanisms.arm.fact_kinds import INDICES, OUTCOMES, PATH_FACTS


def facts_of_plan(plan: ArmPlan, geometry: ArmGeometry, path: object) -> dict[str, Fact]:
    """Return the numbers that are known of a plan; what never happens is infinite."""
    assert isinstance(path, get_args(ArmPathSettings))
    rates, accelerations = plan.peak_rates, plan.peak_accelerations
    crossings = plan.crossings
    region = plan.marks.get("region", ())
    done = plan.outcome == "done"
    optimum = _optimum(geometry, path, plan)
    facts = {
        **_shares(plan, geometry),
        **_torques(plan, geometry, path),
        "time_end": plan.duration,
        "time_optimum": optimum,
        "time_over_optimum": plan.duration / optimum if done else math.inf,
        "time_crossing": crossings[0] if crossings else math.inf,
        "dwell_time": region[1] - region[0] if len(region) > 1 else math.inf,
        "outcome": float(OUTCOMES.index(plan.outcome)),
        "completes": float(done),
        "path_deviation": plan.path_deviation,
        "twist_residual": plan.twist_residual,
        "return_error": return_error(plan.positions[0], plan.positions[-1]),
        "elbow_sign_changes": float(len(crossings)),
        "closest_boundary": 0.0 if crossings else float(np.abs(plan.inside).min()),
        "peak_rate_arm": float(rates[:3].max()),
        "peak_rate_wrist": float(rates[3:].max()),
        "peak_acceleration_arm": float(accelerations[:3].max()),
        "peak_acceleration": float(accelerations.max()),
    }
    for name, rate in zip(AXIS_NAMES, rates, strict=True):
        facts[f"peak_rate_{name}"] = float(rate)
    for (name, _), values in zip(INDICES, plan.indices.T, strict=True):
        facts[f"closest_{name}"] = least_size(values)
        facts[f"crosses_{name}"] = float(np.any(values[:-1] * values[1:] < 0.0))
    return facts_of(PATH_FACTS, facts)


def _shares(plan: ArmPlan, geometry: ArmGeometry) -> dict[str, float]:
    """Return what is asked of the joints in shares of their limits: alike for every arm."""
    rates = plan.peak_rates / np.array(geometry.rate_limits)
    hardest = plan.peak_accelerations / np.array(geometry.acceleration_limits)
    return {
        "peak_rate_share": float(rates.max()),
        "peak_acceleration_share": float(hardest.max()),
        "end_acceleration_share": float(
            (plan.end_accelerations / np.array(geometry.acceleration_limits)).max()
        ),
    }


def _torques(plan: ArmPlan, geometry: ArmGeometry, path: object) -> dict[str, float]:
    """Return what is asked of the drives, if the profile says their limits and the masses."""
    if geometry.dynamics is None:
        return {}
    payload = path.payload if isinstance(path, PosePath) else Payload()
    torques = torques_for(geometry, payload)
    needed = np.abs(torques_of_plan(torques, plan)).max(axis=0, initial=0.0)
    share = float((needed / torques.limits).max())
    return {
        "peak_torque_share": share,
        **{
            f"peak_torque_{name}": float(torque)
            for name, torque in zip(AXIS_NAMES, needed, strict=True)
        },
    }


def return_error(start: np.ndarray, end: np.ndarray) -> float:
    """Return by how much joints differ that may be whole turns apart, rad."""
    difference = end - start
    turns = 2.0 * math.pi * np.round(difference / (2.0 * math.pi))
    return float(np.abs(difference - turns).max())


def _optimum(geometry: ArmGeometry, path: ArmPathSettings, plan: ArmPlan) -> float:
    """Return the least time on the branch that the plan is on, s."""
    if isinstance(path, PosePath):
        q1, q2, q3, q4, q5, q6 = plan.positions[0].tolist()
        path = replace(path, begin=(q1, q2, q3, q4, q5, q6))
    try:
        return least_time(geometry, path)
    except InfeasibleMotion:  # laws that do without the singularity may have done it
        return math.inf
