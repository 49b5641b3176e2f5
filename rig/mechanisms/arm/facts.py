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
from controllers.arm.trajectories import ArmPathSettings
from controllers.motion import InfeasibleMotion
from rig.hal.motion import Fact

INDICES = (("shoulder", "m"), ("elbow", ""), ("wrist", ""))
"""Singularity indices c, S3 and S5: names and units."""
OUTCOMES = ("done", "halts", "stalls")
"""How a law's motion ends; a fact gives the place in this list."""


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
        "time_end": Fact(plan.duration, "s", "duration of the motion"),
        "time_optimum": Fact(optimum, "s", "least time under the joints' rate limits alone"),
        "time_over_optimum": Fact(
            plan.duration / optimum if done else math.inf, "", "duration over the least one"
        ),
        "time_crossing": Fact(
            crossings[0] if crossings else math.inf, "s", "first pass through the elbow's"
        ),
        "dwell_time": Fact(
            region[1] - region[0] if len(region) > 1 else math.inf, "s", "time in the region"
        ),
        "outcome": Fact(float(OUTCOMES.index(plan.outcome)), "", f"0, 1, 2: {', '.join(OUTCOMES)}"),
        "completes": Fact(float(done), "", "1 if the law gets to the path's end"),
        "path_deviation": Fact(plan.path_deviation, "m", "greatest distance from the path"),
        "twist_residual": Fact(plan.twist_residual, "", "greatest entry of J q' - (b v, b² w)"),
        "return_error": Fact(
            return_error(plan.positions[0], plan.positions[-1]),
            "rad",
            "joints at the end from those at the start, whole turns apart",
        ),
        "elbow_sign_changes": Fact(float(len(crossings)), "", "passes through the elbow's"),
        "closest_boundary": Fact(
            0.0 if crossings else float(np.abs(plan.inside).min()),
            "m",
            "least distance of the wrist from the workspace's boundary",
        ),
        "peak_rate_arm": Fact(float(rates[:3].max()), "rad/s", "greatest rate of q1 to q3"),
        "peak_rate_wrist": Fact(float(rates[3:].max()), "rad/s", "greatest rate of q4 to q6"),
        "peak_acceleration_arm": Fact(
            float(accelerations[:3].max()), "rad/s^2", "greatest acceleration of q1 to q3"
        ),
        "peak_acceleration": Fact(float(accelerations.max()), "rad/s^2", "of any joint"),
    }
    for name, rate in zip(AXIS_NAMES, rates, strict=True):
        facts[f"peak_rate_{name}"] = Fact(float(rate), "rad/s", f"greatest rate of {name}")
    for (name, unit), values in zip(INDICES, plan.indices.T, strict=True):
        crosses = bool(np.any(values[:-1] * values[1:] < 0.0))
        closest = 0.0 if crosses else float(np.abs(values).min())
        facts[f"closest_{name}"] = Fact(closest, unit, f"least index of the {name}")
        facts[f"crosses_{name}"] = Fact(float(crosses), "", f"1 if it crosses the {name}'s")
    return facts


def _shares(plan: ArmPlan, geometry: ArmGeometry) -> dict[str, Fact]:
    """Return what is asked of the joints in shares of their limits: alike for every arm."""
    rates = plan.peak_rates / np.array(geometry.rate_limits)
    hardest = plan.peak_accelerations / np.array(geometry.acceleration_limits)
    return {
        "peak_rate_share": Fact(float(rates.max()), "", "greatest rate over its limit"),
        "peak_acceleration_share": Fact(
            float(hardest.max()), "", "greatest acceleration over its limit, on the way"
        ),
        "end_acceleration_share": Fact(
            float((plan.end_accelerations / np.array(geometry.acceleration_limits)).max()),
            "",
            "the same of the start and the stop: above 1 they are steps of the speed",
        ),
    }


def _torques(plan: ArmPlan, geometry: ArmGeometry, path: object) -> dict[str, Fact]:
    """Return what is asked of the drives, if the profile says their limits and the masses."""
    if geometry.dynamics is None:
        return {}
    payload = path.payload if isinstance(path, PosePath) else Payload()
    torques = torques_for(geometry, payload)
    needed = np.abs(torques_of_plan(torques, plan)).max(axis=0, initial=0.0)
    share = float((needed / torques.limits).max())
    return {
        "peak_torque_share": Fact(share, "", "greatest torque foreseen over its limit"),
        **{
            f"peak_torque_{name}": Fact(float(torque), "N m", f"greatest torque foreseen of {name}")
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
