"""What a joint cannot or must not do, found before it moves.

Each check gives a `Refusal` with the number, its bound and the pose; `refuse` raises the first.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from annotated_types import Ge, Gt, Le, Lt, Unit

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import (
    ROTATIONS,
    PoseConvention,
    Vector,
    azimuth_of,
    natural_rotation,
    tilt_of,
)
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics, WireKind

Check = Literal["geometry", "tilt", "antipode", "stroke", "wire-free", "slack", "tension", "seat"]


class InfeasiblePose(ValueError):
    """The joint cannot take a pose; the message says why, with the number and the pose."""


class Refusal(NamedTuple):
    """One reason why a pose is refused.

    Parameters
    ----------
    check : str
        Which check found it.
    value, bound : float
        The number and what it broke, in `unit`.
    unit : str
        SI.
    axis : tuple of float
        The pose.
    message : str
        A sentence with all of it.
    """

    check: Check
    value: float
    bound: float
    unit: str
    axis: Vector
    message: str


@dataclass(frozen=True, slots=True)
class JointBounds:
    """Bounds that a profile sets to the joint.

    Parameters
    ----------
    max_tilt : float
        Greatest tilt of the ring's axis, rad.
    extension : tuple of float
        Least and greatest extension of a rod, m.
    home_extension : float
        Of every rod when the ring is at home, m.
    least_tension, most_tension : float
        Of a wire, N.
    total_tension : float
        Of the four wires together, while their least allows it, N: co-contraction.
    seat_margin : float
        Least angle between the wires' net force and the edge of the ring's contact cone, rad. A
        captured ring takes ``-pi``.
    free_wires : bool
        Whether a wire may leave the ball on the side that the ring tilts to. The exact wire knows
        it; an uncovered wire can also slip off sideways, which a profile may want to exclude.

    Raises
    ------
    ValueError
        A range is empty, or home is outside it.
    """

    max_tilt: Annotated[float, Unit("rad"), Gt(0), Lt(math.pi)] = math.radians(60.0)
    extension: tuple[Annotated[float, Unit("m")], Annotated[float, Unit("m")]] = (0.0, 60e-3)
    home_extension: Annotated[float, Unit("m"), Ge(0)] = 30e-3
    least_tension: Annotated[float, Unit("N"), Ge(0)] = 5.0
    most_tension: Annotated[float, Unit("N"), Gt(0)] = 90.0
    total_tension: Annotated[float, Unit("N"), Ge(0)] = 87.0
    seat_margin: Annotated[float, Unit("rad"), Ge(-math.pi), Le(0.5 * math.pi)] = 0.0
    free_wires: bool = True

    def __post_init__(self) -> None:
        lower, upper = self.extension
        if not lower < self.home_extension < upper:
            raise ValueError(
                f"home_extension ({self.home_extension:g} m) is not within extension "
                f"({lower:g} … {upper:g} m)."
            )
        if not self.least_tension < self.most_tension:
            raise ValueError(
                f"least_tension ({self.least_tension:g} N) is not below most_tension "
                f"({self.most_tension:g} N)."
            )


def calculability_angle(geometry: SphericalJointGeometry) -> float:
    """Return upsilon (rad) of the paper, which must be above 45 degrees for tilts of 90.

    With the ring tilted by 90 degrees the anchor is at ``(-L, r_ri)`` and the adjust point at
    ``(r_c, -r_c)``; upsilon is the angle of their line to the horizontal.

    References
    ----------
    Kobayashi and Saito, eq. (14)-(17) with Fig. 6. KB = r_c + L is horizontal there, AK = r_c +
    r_ri vertical; for the paper's adjust points the condition says ``r_ri > r_c / sqrt(2)``.
    """
    return math.atan2(
        geometry.ball_radius + geometry.ring_radius, geometry.ball_radius + geometry.ring_height
    )


def antipode_tilt(geometry: SphericalJointGeometry) -> float:
    """Return the tilt (rad) at which an anchor comes to lie opposite its adjust point.

    The general form of eq. (17), for any greatest tilt and any adjust point: beyond it the
    shortest way of the wire round the ball is on the other side. No artefact of the paper's
    construction, the true wire flips there too.
    """
    return geometry.ring_half_angle + math.atan2(geometry.adjust_radius, geometry.adjust_depth)


def free_wire_tilt(geometry: SphericalJointGeometry) -> float:
    """Return the tilt (rad) at which the wire on that side leaves the ball."""
    wound_from = math.acos(geometry.ball_radius / geometry.adjust_distance)
    below = math.atan2(geometry.adjust_depth, geometry.adjust_radius)
    return 0.5 * math.pi + below - geometry.ring_half_angle - wound_from


class FeasibilityCheck:
    """Checks of a geometry, of poses and of paths against a profile's bounds.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions.
    bounds : JointBounds
        What the profile allows.
    wire, pose : str
        With which the controller computes its references.
    """

    def __init__(
        self,
        geometry: SphericalJointGeometry,
        bounds: JointBounds,
        wire: WireKind = "exact",
        pose: PoseConvention = "natural",
    ) -> None:
        self._geometry = geometry
        self._bounds = bounds
        self._rotation = ROTATIONS[pose]
        self._inverse = InverseKinematics(geometry, wire, pose)
        self._exact = ExactWires(geometry)
        self._distribution = TensionDistribution(geometry)
        self._antipode = antipode_tilt(geometry)
        self._leaves = free_wire_tilt(geometry)

    def check_geometry(self) -> list[Refusal]:
        """Check that the greatest tilt is within reach of the wires' geometry."""
        limit, most = self._antipode, self._bounds.max_tilt
        if most < limit:
            return []
        condition = ""
        if most >= 0.5 * math.pi:
            angle = calculability_angle(self._geometry)
            if angle <= 0.25 * math.pi:
                condition = (
                    f" Eq. (17) of Kobayashi and Saito is not met either: upsilon is "
                    f"{math.degrees(angle):.2f} deg and must be above 45 deg."
                )
        return [
            Refusal(
                "geometry",
                most,
                limit,
                "rad",
                (math.sin(most), 0.0, math.cos(most)),
                f"max_tilt ({math.degrees(most):.2f} deg) must be below "
                f"{math.degrees(limit):.2f} deg, where an anchor comes to lie opposite its "
                f"adjust point and its wire flips to the other side of the ball.{condition}",
            )
        ]

    def check_pose(self, axis: Vector) -> list[Refusal]:
        """Return everything that speaks against a pose; empty if nothing does."""
        bounds = self._bounds
        tilt = tilt_of(axis)
        if tilt >= self._antipode:
            return [
                _finding(
                    "antipode",
                    tilt,
                    self._antipode,
                    axis,
                    "an anchor lies opposite its adjust point from {bound} of tilt",
                )
            ]
        findings = []
        if tilt > bounds.max_tilt:
            findings.append(
                _finding(
                    "tilt", tilt, bounds.max_tilt, axis, "the tilt is {value}, max_tilt is {bound}"
                )
            )
        findings += self._check_stroke(axis)
        rotation = self._rotation(axis)
        if not bounds.free_wires:
            for number, wound in enumerate(self._exact.wound_angles(rotation), start=1):
                if wound <= 0.0:
                    findings.append(
                        _finding(
                            "wire-free",
                            tilt,
                            self._leaves,
                            axis,
                            f"wire {number} leaves the ball, which wires do from {{bound}} of tilt",
                        )
                    )
        return findings + self._check_tension(axis)

    def _check_stroke(self, axis: Vector) -> list[Refusal]:
        bounds = self._bounds
        lower, upper = bounds.extension
        try:
            shortenings = self._inverse.shortening(axis)
        except ValueError as error:
            return [_finding("antipode", tilt_of(axis), self._antipode, axis, str(error))]
        return [
            _finding(
                "stroke",
                extension,
                lower if extension < lower else upper,
                axis,
                f"rod {number} would extend to {{value}}, beyond {{bound}}",
                "m",
            )
            for number, shortening in enumerate(shortenings, start=1)
            if not lower <= (extension := bounds.home_extension - shortening) <= upper
        ]

    def _check_tension(self, axis: Vector) -> list[Refusal]:
        bounds = self._bounds
        # Whatever convention the lengths follow: nothing keeps the ring from spinning to where
        # the wires hold it, and no four taut wires hold it in a spun pose off the axes.
        rotation = natural_rotation(axis)
        shares = self._distribution.shares(rotation)
        least = min(shares)
        number = shares.index(least) + 1
        if least <= 0.0:
            return [
                _finding(
                    "slack",
                    least,
                    0.0,
                    axis,
                    f"wire {number} would bear {{value}} of the tension: no pull holds this pose",
                    "",
                )
            ]
        findings = []
        tensions = self._distribution.hold(rotation, bounds.least_tension, bounds.total_tension)
        most = max(tensions)
        if most > bounds.most_tension:
            findings.append(
                _finding(
                    "tension",
                    most,
                    bounds.most_tension,
                    axis,
                    f"wire {tensions.index(most) + 1} needs {{value}} so that wire {number} keeps "
                    f"{bounds.least_tension:.4g} N; most_tension is {{bound}}",
                    "N",
                )
            )
        margin = self._distribution.seating_margin(rotation, tensions)
        if margin < bounds.seat_margin:
            findings.append(
                _finding(
                    "seat",
                    margin,
                    bounds.seat_margin,
                    axis,
                    "the ring leaves its seat: the wires' net force is {value} inside its contact "
                    "cone, and {bound} are asked for",
                )
            )
        return findings


def refuse(findings: Sequence[Refusal]) -> None:
    """Raise the first of some findings.

    Raises
    ------
    InfeasiblePose
        There is one.
    """
    if findings:
        raise InfeasiblePose(findings[0].message)


def _finding(
    check: Check, value: float, bound: float, axis: Vector, message: str, unit: str = "rad"
) -> Refusal:
    """Word a finding: angles in degrees and lengths in millimetres, as people think of them."""

    def word(number: float) -> str:
        if unit == "rad":
            return f"{math.degrees(number):.2f} deg"
        if unit == "m":
            return f"{number * 1e3:.2f} mm"
        return f"{number:.4g} {unit}".rstrip()

    pose = (
        f"at {math.degrees(tilt_of(axis)):.2f} deg tilt towards "
        f"{math.degrees(azimuth_of(axis)):.1f} deg"
    )
    text = message.format(value=word(value), bound=word(bound))
    return Refusal(check, value, bound, unit, axis, f"{pose}: {text}")
