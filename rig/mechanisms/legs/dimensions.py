"""What the legs' dimensions come to: how long, how wide and how heavy they are."""

import math

from controllers.gait.geometry import JOINTS, LegGeometry
from rig.hal.formats import format_quantity


def described(geometry: LegGeometry) -> tuple[tuple[str, str], ...]:
    """Return rows of what and value for `rig check`."""
    its, sole = geometry, geometry.sole
    length = its.thigh + its.shank
    ranges = its.limits
    return (
        ("legs", f"{_mm(length)} from hip to ankle with straight knees, where they are singular"),
        (
            "hips",
            f"{_mm(length + its.ankle_height)} above the ground then, and "
            f"{_mm(2.0 * its.hip_half_spacing)} apart",
        ),
        (
            "soles",
            f"{_mm(sole.front)} ahead of the ankle, {_mm(sole.back)} behind it, "
            f"{_mm(2.0 * sole.half_width)} wide",
        ),
        ("mass of the robot", format_quantity(its.masses.total, "kg")),
        *(
            (name, f"left {_range(*left)}, right {_range(*right)}")
            for name, left, right in zip(JOINTS, ranges[6:], ranges[:6], strict=True)
        ),
        ("any joint", f"at most {math.degrees(its.max_rate):.4g} deg/s"),
    )


def _range(low: float, high: float) -> str:
    return f"{math.degrees(low):.4g} to {math.degrees(high):.4g} deg"


def _mm(length: float) -> str:
    return format_quantity(length, "m")
