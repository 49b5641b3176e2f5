"""What the two models of the wires have in common, and a pose's way to shortenings."""

from typing import Literal, NamedTuple, Protocol

from controllers.compiled import inlined
from controllers.spherical_joint.exact_wire import ExactWires, WireConstants, wire_lengths
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.paper_wire import PaperWires
from controllers.spherical_joint.poses import (
    ROTATIONS,
    PoseConvention,
    Rotation,
    Vector,
    move_axis,
    natural_rotation,
)

WireKind = Literal["exact", "paper"]

_STEP = 1e-3
"""Over which a path is differentiated, s. Central differences of a motion below 1 Hz are right to
some 1e-6 of it, and the rounding of the second one stays below 1e-10 m/s²."""


class Wires(Protocol):
    """Lengths of the four wires against the ring's attitude."""

    def lengths(self, rotation: Rotation) -> Quadruple:
        """Return the lengths from anchor to adjust point, m."""


class WireMotion(NamedTuple):
    """The wanted motion of the four wires: shortening from home (m), its rate and acceleration."""

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
        self.is_natural = (wire, pose) == ("exact", "natural")
        """The wires are exact ones, and the poses natural."""
        self._lengths = make_wires(wire, geometry).lengths
        self._rotation = ROTATIONS[pose]
        self.home = self._lengths(self._rotation((0.0, 0.0, 1.0)))
        """Lengths of the wires at home, m."""

    def shortening(self, axis: Vector) -> Quadruple:
        """Return how much shorter than at home each wire is, m; eq. (6)."""
        return _shortened(self.home, self._lengths(self._rotation(axis)))

    def motion(self, axis: Vector, velocity: Vector, acceleration: Vector) -> WireMotion:
        """Return the wires' motion for that of the axis.

        Parameters
        ----------
        axis, velocity, acceleration : tuple of float
            Unit vector, 1/s, 1/s².
        """
        return WireMotion(
            *_derivatives(
                self.shortening(move_axis(axis, velocity, acceleration, -_STEP)),
                self.shortening(axis),
                self.shortening(move_axis(axis, velocity, acceleration, _STEP)),
            )
        )


@inlined
def natural_motion(
    wires: WireConstants, home: Quadruple, axis: Vector, velocity: Vector, acceleration: Vector
) -> tuple[Quadruple, Quadruple, Quadruple]:
    """Return the motion of exact wires under the natural pose; see `InverseKinematics.motion`.

    Parameters
    ----------
    wires : WireConstants
        Of exact wires.
    home : tuple of float
        Lengths at home, m.
    axis, velocity, acceleration : tuple of float
        Unit vector, 1/s, 1/s².
    """
    back = move_axis(axis, velocity, acceleration, -_STEP)
    ahead = move_axis(axis, velocity, acceleration, _STEP)
    return _derivatives(
        _shortened(home, wire_lengths(wires, natural_rotation(back))),
        _shortened(home, wire_lengths(wires, natural_rotation(axis))),
        _shortened(home, wire_lengths(wires, natural_rotation(ahead))),
    )


@inlined
def _shortened(home: Quadruple, lengths: Quadruple) -> Quadruple:
    (a, b, c, d), (e, f, g, h) = home, lengths
    return (a - e, b - f, c - g, d - h)


@inlined
def _derivatives(
    back: Quadruple, here: Quadruple, ahead: Quadruple
) -> tuple[Quadruple, Quadruple, Quadruple]:
    """Return value, first and second derivative by central differences over `_STEP`."""
    rate = 0.5 / _STEP
    curve = 1.0 / (_STEP * _STEP)
    (b0, b1, b2, b3), (h0, h1, h2, h3), (a0, a1, a2, a3) = back, here, ahead
    return (
        here,
        (rate * (a0 - b0), rate * (a1 - b1), rate * (a2 - b2), rate * (a3 - b3)),
        (
            curve * (a0 - h0 - h0 + b0),
            curve * (a1 - h1 - h1 + b1),
            curve * (a2 - h2 - h2 + b2),
            curve * (a3 - h3 - h3 + b3),
        ),
    )
