"""What the arm's dimensions and limits are, as a profile gives them."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Unit

from controllers.arm.dynamics.settings import ArmDynamics

AXIS_NAMES = ("q1", "q2", "q3", "q4", "q5", "q6")
"""Base, shoulder, elbow, and the wrist's three, from the base outwards."""

Angle = Annotated[float, Unit("rad")]
Length = Annotated[float, Unit("m")]
Rate = Annotated[float, Unit("rad/s"), Gt(0)]
Acceleration = Annotated[float, Unit("rad/s^2"), Gt(0)]
SixAngles = tuple[Angle, Angle, Angle, Angle, Angle, Angle]


@dataclass(frozen=True, slots=True)
class ArmGeometry:
    """Dimensions and limits of a U-R-S arm: two joints, an elbow and a spherical wrist.

    Zero pose: the arm stands straight up. ``q1`` turns about +Z; ``q2`` and ``q3`` tip the upper
    arm and the forearm about +Y, from the vertical; the wrist is Z-Y-Z about the forearm, about Y
    and about the tool. The tool's frame at zero is the base's.

    Parameters
    ----------
    a2, a3 : float
        Shoulder to elbow, and elbow to wrist centre along the forearm, m; they may be equal.
    d6 : float
        Wrist centre to tool point, along the tool, m.
    base_height : float
        Of the shoulder above the base's origin, m.
    wrist_sign : int
        Whether q5 turns about +Y or -Y of the forearm. The paper does not say which.
    elbow_offset : float
        Of the wrist centre from the forearm's axis through the elbow, along its X, m.
    shoulder_offset : float
        Of the plane of upper arm and forearm from the axis of q1, along Y, m. With it the axis
        is inside a void, whose surface is singular instead.
    a1 : float
        Of the shoulder from the axis of q1, within the arm's plane and ahead, m: with it the
        boundary of the workspace is no sphere but a torus.
    marker : tuple of float
        Point of the hand that calibrations measure, from the tool point along the tool's axes,
        m. On the tool's axis it does not see q6.
    position_min, position_max : tuple of float
        Range of each joint, rad.
    rate_limits : tuple of float
        Greatest speed of each joint, rad/s.
    acceleration_limits : tuple of float
        Greatest acceleration of each joint, rad/s².
    dynamics : ArmDynamics, optional
        Masses, friction and torque limits, with which torques are foreseen.

    Raises
    ------
    ValueError
        A joint's range is empty.

    References
    ----------
    Miyata, Sato and Kanamiya, "Enhanced Singularity-Consistent Motion Generation for U-R-S Type
    Manipulators Considering the Singular Region", Fig. 1 and section 3 (lengths, 1 rad/s). The
    paper gives no table of joint axes: they are those with which its eq. (5) and (6) are right.
    """

    a2: Annotated[float, Unit("m"), Gt(0)] = 0.4
    a3: Annotated[float, Unit("m"), Gt(0)] = 0.39
    d6: Annotated[float, Unit("m"), Ge(0)] = 0.118
    base_height: Annotated[float, Unit("m")] = 0.0
    wrist_sign: Literal[1, -1] = 1
    elbow_offset: Annotated[float, Unit("m")] = 0.0
    shoulder_offset: Annotated[float, Unit("m")] = 0.0
    a1: Annotated[float, Unit("m")] = 0.0
    marker: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    position_min: SixAngles = (-math.pi, -math.pi, -2.8, -2.0 * math.pi, -2.5, -2.0 * math.pi)
    position_max: SixAngles = (math.pi, math.pi, 2.8, 2.0 * math.pi, 2.5, 2.0 * math.pi)
    rate_limits: tuple[Rate, Rate, Rate, Rate, Rate, Rate] = (1.0, 1.0, 1.0, 2.0, 2.0, 2.0)
    acceleration_limits: tuple[
        Acceleration, Acceleration, Acceleration, Acceleration, Acceleration, Acceleration
    ] = (10.0, 10.0, 10.0, 20.0, 20.0, 20.0)
    dynamics: ArmDynamics | None = None

    def __post_init__(self) -> None:
        ranges = zip(AXIS_NAMES, self.position_min, self.position_max, strict=True)
        for name, lower, upper in ranges:
            if not lower < upper:
                raise ValueError(
                    f"position_min of {name} ({lower:g} rad) must be below its position_max "
                    f"({upper:g} rad)."
                )

    @property
    def forearm(self) -> float:
        """Elbow to wrist centre, whatever the forearm's shape, m."""
        return math.hypot(self.a3, self.elbow_offset)

    @property
    def elbow_angle(self) -> float:
        """What is added to q3 for the angle between upper arm and elbow-wrist line, rad."""
        return math.atan2(self.elbow_offset, self.a3)

    @property
    def reach(self) -> float:
        """Shoulder to wrist centre with the elbow stretched, m; R in the notation here."""
        return self.a2 + self.forearm
