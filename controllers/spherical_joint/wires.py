"""What the two models of the wires have in common, and a pose's way to shortenings."""

from typing import Literal, NamedTuple, Protocol

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.paper_wire import PaperWires
from controllers.spherical_joint.poses import (
    ROTATIONS,
    PoseConvention,
    Rotation,
    Vector,
    move_axis,
)

WireKind = Literal["exact", "paper"]

_STEP = 1e-3
"""Over which a path is differentiated, s. Central differences of a motion below 1 Hz are right to
some 1e-6 of it, and the rounding of the second one stays below 1e-10 m/s²."""


class Wires(Protocol):
    """Lengths of the four wires against the ring's attitude."""

    def lengths(self, rotation: Rotation) -> Quadruple:
        """Return the lengths from anchor to adjust point, m."""
        ...


class WireMotion(NamedTuple):
    """How the four wires are to move: shortening from home (m), its rate and acceleration."""

    position: Quadruple
    velocity: Quadruple
    acceleration: Quadruple


def make_wires(kind: WireKind, geometry: SphericalJointGeometry) -> Wires:
    """Return the wires' model by its name."""
    return ExactWires(geometry) if kind == "exact" else PaperWires(geometry)


class InverseKinematics:
    """From the ring's axis to the shortening of each wire, and its derivatives.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions.
    wire : str
        ``exact`` or ``paper``.
    pose : str
        ``natural`` or ``paper``.

    References
    ----------
    Kobayashi and Saito, section 3. Shortening is eq. (6): home less current length, positive when
    the wire is pulled in.
    """

    def __init__(
        self,
        geometry: SphericalJointGeometry,
        wire: WireKind = "exact",
        pose: PoseConvention = "natural",
    ) -> None:
        self._lengths = make_wires(wire, geometry).lengths
        self._rotation = ROTATIONS[pose]
        self._home = self._lengths(self._rotation((0.0, 0.0, 1.0)))

    def shortening(self, axis: Vector) -> Quadruple:
        """Return how much shorter than at home each wire is, m; eq. (6)."""
        first, second, third, fourth = self._lengths(self._rotation(axis))
        home = self._home
        return (home[0] - first, home[1] - second, home[2] - third, home[3] - fourth)

    def motion(self, axis: Vector, velocity: Vector, acceleration: Vector) -> WireMotion:
        """Return the wires' motion for that of the axis.

        Parameters
        ----------
        axis, velocity, acceleration : tuple of float
            Unit vector, 1/s, 1/s².
        """
        here = self.shortening(axis)
        ahead = self.shortening(move_axis(axis, velocity, acceleration, _STEP))
        back = self.shortening(move_axis(axis, velocity, acceleration, -_STEP))
        rate = 0.5 / _STEP
        curve = 1.0 / (_STEP * _STEP)
        (a0, a1, a2, a3), (h0, h1, h2, h3), (b0, b1, b2, b3) = ahead, here, back
        return WireMotion(
            here,
            (rate * (a0 - b0), rate * (a1 - b1), rate * (a2 - b2), rate * (a3 - b3)),
            (
                curve * (a0 - h0 - h0 + b0),
                curve * (a1 - h1 - h1 + b1),
                curve * (a2 - h2 - h2 + b2),
                curve * (a3 - h3 - h3 + b3),
            ),
        )
