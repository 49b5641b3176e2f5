"""What an arm's dimensions come to: how far it reaches, and where it is singular."""

import math

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from rig.hal.formats import format_quantity


def described(geometry: ArmGeometry) -> tuple[tuple[str, str], ...]:
    """Return rows of what and value for `rig check`."""
    its = geometry
    nearest = abs(its.a2 - its.forearm)
    return (
        (
            "reach",
            f"wrist centre {_mm(nearest)} to {_mm(its.reach)} from the shoulder, tool point "
            f"{_mm(its.d6)} beyond it",
        ),
        ("singular at the shoulder", _shoulder(its)),
        ("singular at the elbow", f"{_at(its, 2, -its.elbow_angle)}, where the arm is stretched"),
        ("singular at the wrist", f"{_at(its, 4, 0.0)}, where the axes of q4 and q6 are in line"),
        *((name, _joint(its, joint)) for joint, name in enumerate(AXIS_NAMES)),
    )


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
