"""What the legs' dimensions are, as a profile gives them."""

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Unit

JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
"""Joints of one leg, from the waist to the foot."""

LEGS = ("right", "left")
"""In the order of the paper's eq. (3)."""

AXIS_NAMES = tuple(f"{leg}_{joint}" for leg in LEGS for joint in JOINTS)
"""All twelve, in the order of every vector of joints."""

KNEES = (3, 9)
"""Where the knees stand in such a vector."""

AXES = ("z", "x", "y", "y", "y", "x")
"""Axes of `JOINTS` that the closed forms are made for."""

Axis = Literal["x", "y", "z"]
Angle = Annotated[float, Unit("rad")]
Length = Annotated[float, Unit("m"), Gt(0)]
Mass = Annotated[float, Unit("kg"), Gt(0)]
Torque = Annotated[float, Unit("N m"), Gt(0)]
Sign = Literal[-1, 1]


def _degrees(*values: float) -> tuple[float, float, float, float, float, float]:
    first, second, third, fourth, fifth, sixth = map(math.radians, values)
    return first, second, third, fourth, fifth, sixth


@dataclass(frozen=True, slots=True)
class SoleGeometry:
    """The rectangle on which a foot stands, seen from under the ankle.

    Parameters
    ----------
    front, back : float
        From the ankle forwards and backwards, m.
    half_width : float
        To either side, m.
    """

    front: Length = 0.0582
    back: Length = 0.0358
    half_width: Length = 0.031


@dataclass(frozen=True, slots=True)
class LegMasses:
    """Masses of the links and where their centres are.

    Parameters
    ----------
    hip_yaw, hip_roll : float
        Of the two links between the hip's axes, kg; their centres are at the hip's centre.
    thigh, shank : float
        Of the links above and below the knee, kg.
    ankle : float
        Of the link between the ankle's axes, kg; its centre is at the ankle.
    foot : float
        Of the foot below the ankle's axes, kg.
    upper_body : float
        Everything above the hips, kg.
    thigh_centre, shank_centre : float
        From hip to knee and from knee to ankle, as a share of that length.
    foot_depth : float
        Of the foot's centre under the ankle, m.
    upper_body_forward, upper_body_height : float
        Of the upper body's centre, from the waist, m.

    Notes
    -----
    No table of HOAP-1's links is public. The leg's masses are those of a public model of its
    successor HOAP-2 (which of 0.439 and 0.173 kg is the thigh's is a reading of it), the centres
    those of a HOAP-3 model, scaled; the upper body makes up the 6.0 kg that HOAP-1 weighs.
    """

    hip_yaw: Mass = 0.039
    hip_roll: Mass = 0.173
    thigh: Mass = 0.439
    shank: Mass = 0.286
    ankle: Mass = 0.171
    foot: Mass = 0.157
    upper_body: Mass = 3.470
    thigh_centre: Annotated[float, Ge(0), Le(1)] = 0.665
    shank_centre: Annotated[float, Ge(0), Le(1)] = 0.455
    foot_depth: Annotated[float, Unit("m"), Ge(0)] = 0.027
    upper_body_forward: Annotated[float, Unit("m")] = 0.004
    upper_body_height: Annotated[float, Unit("m")] = 0.100

    @property
    def leg(self) -> float:
        """Of one leg, kg."""
        return self.hip_yaw + self.hip_roll + self.thigh + self.shank + self.ankle + self.foot

    @property
    def total(self) -> float:
        """Of the whole robot, kg."""
        return self.upper_body + 2.0 * self.leg


@dataclass(frozen=True, slots=True)
class LegGeometry:
    """Dimensions, limits and masses of two legs alike.

    Frames: the waist's is midway between the hips, a foot's on the sole under the ankle; x
    forwards, y to the left, z up. At zero the leg is straight and the foot under the hip. A
    positive angle turns what is farther from the waist about +x, +y or +z, on both legs alike:
    the hip's pitch is negative with the leg in front, the knee's positive when it bends.

    Parameters
    ----------
    axes : tuple of str
        Of the six joints from waist to foot. The three of the hip meet in a point, and so do
        the two of the ankle.
    thigh, shank : float
        Hip to knee and knee to ankle, m.
    ankle_height : float
        Of the ankle above the sole, m.
    hip_half_spacing : float
        From the waist's frame to either hip, m.
    sole : SoleGeometry
        What the foot stands on.
    min_angle, max_angle : tuple of float
        What the left leg's joints may be commanded to, rad; a degree inside the stops.
    mirror : tuple of int
        -1 where the right leg's limits are the left's with the sign changed.
    max_rate : float
        Of any joint, rad/s.
    torque_peak : tuple of float
        What a joint's servo can hold for a moment, N m.
    masses : LegMasses
        Of the links.

    Raises
    ------
    ValueError
        The axes are not those that the closed forms are made for, or limits are reversed.

    Notes
    -----
    The paper names HOAP-1 and gives no dimension; these are HOAP-2's lengths and the limits and
    torques of the HOAP-3 manual, the nearest that is public.
    """

    axes: tuple[Axis, Axis, Axis, Axis, Axis, Axis] = ("z", "x", "y", "y", "y", "x")
    thigh: Length = 0.100
    shank: Length = 0.100
    ankle_height: Length = 0.0405
    hip_half_spacing: Length = 0.039
    sole: SoleGeometry = field(default_factory=SoleGeometry)
    min_angle: tuple[Angle, Angle, Angle, Angle, Angle, Angle] = _degrees(
        -30.0, -20.0, -81.0, 0.0, -60.0, -24.0
    )
    max_angle: tuple[Angle, Angle, Angle, Angle, Angle, Angle] = _degrees(
        90.0, 30.0, 70.0, 129.0, 60.0, 24.0
    )
    mirror: tuple[Sign, Sign, Sign, Sign, Sign, Sign] = (-1, -1, 1, 1, 1, -1)
    max_rate: Annotated[float, Unit("rad/s"), Gt(0)] = 4.76
    torque_peak: tuple[Torque, Torque, Torque, Torque, Torque, Torque] = (
        3.0,
        4.5,
        3.0,
        4.5,
        4.5,
        3.0,
    )
    masses: LegMasses = field(default_factory=LegMasses)

    def __post_init__(self) -> None:
        if self.axes != AXES:
            raise ValueError(
                f"axes {' '.join(self.axes)}: the closed forms are made for {' '.join(AXES)}."
            )
        for joint, low, high in zip(JOINTS, self.min_angle, self.max_angle, strict=True):
            if not low < high:
                raise ValueError(
                    f"{joint}: min_angle ({math.degrees(low):.4g} deg) must be below max_angle "
                    f"({math.degrees(high):.4g} deg)."
                )
        if self.min_angle[3] < 0.0:
            raise ValueError(
                f"knee: min_angle is {math.degrees(self.min_angle[3]):.4g} deg; a knee that bends "
                "backwards is another branch of the inverse kinematics."
            )

    @property
    def reach(self) -> float:
        """From hip to ankle with a straight knee, m."""
        return self.thigh + self.shank

    def distance(self, knee: float) -> float:
        """Return how far the hip is from the ankle at a knee angle (rad), m."""
        bent = 4.0 * self.thigh * self.shank * math.sin(0.5 * knee) ** 2
        return math.sqrt(self.reach**2 - bent)

    def side(self, leg: int) -> float:
        """Return y of a leg's hip in the waist's frame, m."""
        return self.hip_half_spacing if leg else -self.hip_half_spacing

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest angle of all twelve joints, in the order of `AXIS_NAMES`, rad."""
        left = tuple(zip(self.min_angle, self.max_angle, strict=True))
        right = tuple(
            (low, high) if sign > 0 else (-high, -low)
            for (low, high), sign in zip(left, self.mirror, strict=True)
        )
        return right + left
