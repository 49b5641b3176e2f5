"""What is known beforehand of an arm that follows twists."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import Dimensions, dimensions_of, forward
from controllers.arm.plan import ArmPlan
from rig.hal.motion import Fact
from rig.mechanisms.arm.facts import INDICES

Array = NDArray[np.float64]

_SLOWEST = 1e-9
"""m/s or rad/s: what is slower has no line that the hand could be held against."""
_TAKEN_UP = 0.5
"""From so long after a twist has changed on the hand is held against it, s."""
_STANDS = 1e-3
"""Share of what is asked for below which the hand stands."""


def facts_of_twists(plan: ArmPlan, geometry: ArmGeometry) -> dict[str, Fact]:
    """Return the numbers that are known of an arm that follows twists."""
    rates, limits = plan.rates.max(axis=0), np.array(geometry.rate_limits)
    change = np.diff(plan.velocities, axis=0, prepend=np.zeros((1, 6)))
    jump = float((np.abs(change) / limits).max()) / (1e3 * plan.period)
    accelerations = np.abs(change).max(axis=0) / plan.period
    over = float((accelerations / np.array(geometry.acceleration_limits)).max())
    asked = np.abs(plan.command).max(axis=1) > 0.0
    share = np.where(asked, plan.scale[:, 0], 1.0)
    away, turned = off_direction(plan, geometry)
    speed = np.linalg.norm(plan.command[:, :3], axis=1)
    whole = float(speed.sum()) * plan.period
    way = float(np.linalg.norm(np.diff(plan.hand, axis=0), axis=1).sum())
    along = float((share * speed)[asked].sum()) * plan.period
    facts = {
        "time_end": Fact(plan.duration, "s", "until the hand is at rest after the last twist"),
        "off_direction": Fact(away, "m", "greatest distance of the hand from the line of a twist"),
        "turned_off": Fact(turned, "rad", "greatest turn of the tool beside that of a twist"),
        "lag": Fact(
            float((1.0 - share).sum()) * plan.period, "s", "what the hand is late by at the end"
        ),
        "standing_share": Fact(
            float((share < _STANDS).sum()) / max(int(asked.sum()), 1), "",
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


def off_direction(plan: ArmPlan, geometry: ArmGeometry) -> tuple[float, float]:
    """Return how far the hand gets off the lines that the twists are (m), and the tool (rad).

    A line begins where the hand is `_TAKEN_UP` after a twist has changed, and ends with the
    twist. The tool is held against the turn that belongs to how far the hand, or without a
    velocity the tool itself, has gone.
    """
    arm = dimensions_of(geometry)
    same = np.all(np.diff(plan.command, axis=0) == 0.0, axis=1)
    starts = [0, *(np.flatnonzero(~same) + 1).tolist(), len(plan.t)]
    wait = math.ceil(_TAKEN_UP / plan.period)
    away = turned = 0.0
    for begin, end in pairwise(starts):
        twist = np.where(np.abs(plan.command[begin]) < _SLOWEST, 0.0, plan.command[begin])
        first = begin + wait
        if first + 1 >= end or not twist.any():
            continue
        gone = plan.hand[first:end] - plan.hand[first]
        turns = _turns(arm, plan.positions[first:end])
        progress = _progress(gone, turns, twist)
        away = max(away, float(np.linalg.norm(gone - np.outer(progress, twist[:3]), axis=1).max()))
        turned = max(turned, _beside(turns, progress, twist[3:]))
    return away, turned


def _turns(arm: Dimensions, positions: Array) -> Array:
    """Return the tool's rotations since the first row, shape (n, 3, 3)."""
    rotations = np.array([forward(arm, tuple(q)).rotation for q in positions.tolist()])
    return np.asarray(rotations @ rotations[0].T)


def _progress(gone: Array, turns: Array, twist: Array) -> Array:
    """Return for how long the twist would have had to be done, s, shape (n,)."""
    v, w = twist[:3], twist[3:]
    if v.any():
        return np.asarray(gone @ v / (v @ v))
    from scipy.spatial.transform import Rotation

    steps = Rotation.from_matrix(turns[1:] @ np.transpose(turns[:-1], (0, 2, 1))).as_rotvec()
    return np.concatenate(([0.0], np.cumsum(steps @ w / (w @ w))))


def _beside(turns: Array, progress: Array, w: Array) -> float:
    """Return the greatest angle of the tool from where the progress has it, rad."""
    from scipy.spatial.transform import Rotation

    wanted = Rotation.from_rotvec(np.outer(progress, w))
    return float((Rotation.from_matrix(turns) * wanted.inv()).magnitude().max())
