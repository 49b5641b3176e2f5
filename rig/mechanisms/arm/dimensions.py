"""What an arm's dimensions come to: how far it reaches, and where it is singular."""

import math

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from rig.hal.formats import format_quantity


def described(geometry: ArmGeometry) -> tuple[tuple[str, str], ...]:
    """Return rows of what and value for `rig check`."""
    its = geometry
    nearest, farthest = _reach(its)
    return (
        (
            "reach",
            f"wrist centre {_mm(nearest)} to {_mm(farthest)} from the shoulder with q3 in its "
            f"range, tool point {_mm(its.d6)} beyond it",
        ),
        (
            "links",
            f"shoulder {_mm(its.base_height)} above the base and {_mm(its.a1)} ahead of the axis "
            f"of q1, {_mm(its.a2)} to the elbow, {_mm(its.forearm)} on to the wrist centre",
        ),
        ("singular at the shoulder", _shoulder(its)),
        ("singular at the elbow", f"{_at(its, 2, -its.elbow_angle)}, where the arm is stretched"),
        ("singular at the wrist", f"{_at(its, 4, 0.0)}, where the axes of q4 and q6 are in line"),
        *((f"{name} of the laws", _joint(its, joint)) for joint, name in enumerate(AXIS_NAMES)),
    )


def _reach(its: ArmGeometry) -> tuple[float, float]:
    """Return the least and the greatest distance of the wrist's centre from the shoulder, m."""
    low, high = (angle + its.elbow_angle for angle in (its.position_min[2], its.position_max[2]))
    # The distance falls with the elbow's angle from 0 to half a turn, and rises beyond.
    turns = range(math.ceil(low / math.pi), math.floor(high / math.pi) + 1)
    angles = [low, high, *(turn * math.pi for turn in turns)]
    ways = [
        math.sqrt(max(its.a2**2 + its.forearm**2 + 2.0 * its.a2 * its.forearm * math.cos(q), 0.0))
        for q in angles
    ]
    return min(ways), max(ways)


def _shoulder(its: ArmGeometry) -> str:
    if its.shoulder_offset:
        return (
            f"wrist centre {_mm(abs(its.shoulder_offset))} from the axis of q1, and no nearer does "
            "it get"
        )
    return "wrist centre on the axis of q1"


def _at(its: ArmGeometry, joint: int, angle: float) -> str:
    """Say where within its range a joint's sine about `angle` is zero: at every half turn."""
    low, high = its.position_min[joint], its.position_max[joint]
    first, last = math.ceil((low - angle) / math.pi), math.floor((high - angle) / math.pi)
    found = [angle + turns * math.pi for turns in range(first, last + 1)]
    name = AXIS_NAMES[joint]
    if not found:
        return f"nowhere within the range of {name}"
    return f"{name} at " + " and ".join(_degrees(value) for value in found)


def _joint(its: ArmGeometry, joint: int) -> str:
    low, high = its.position_min[joint], its.position_max[joint]
    return (
        f"{math.degrees(low):.4g} to {_degrees(high)}, at most "
        f"{math.degrees(its.rate_limits[joint]):.4g} deg/s and "
        f"{math.degrees(its.acceleration_limits[joint]):.4g} deg/s^2"
    )


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle) + 0.0:.4g} deg"


def _mm(length: float) -> str:
    return format_quantity(length, "m")
