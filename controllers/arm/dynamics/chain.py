"""The torques of a motion: Newton and Euler along the chain of links, for many instants at once.

In the base's axes throughout. It shares nothing with the simulated arm but the drawing.

References
----------
J. Y. S. Luh, M. W. Walker and R. P. C. Paul, "On-Line Computational Scheme for Mechanical
Manipulators", Journal of Dynamic Systems, Measurement, and Control 102(2), 1980.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.dynamics.settings import ArmDynamics, Payload
from controllers.arm.geometry import ArmGeometry

Array = NDArray[np.float64]

_GRAVITY = np.array((0.0, 0.0, 9.80665))
"""Upward acceleration of an arm that stands still, as its masses feel it, m/s²."""


class Link(NamedTuple):
    """A link with what it carries: where it ends, and its mass about its joint.

    Parameters
    ----------
    axis : ndarray, shape (3,)
        Of its joint, in its axes.
    end : ndarray, shape (3,)
        Of the next joint, m.
    mass : float
        kg.
    centre : ndarray, shape (3,)
        Centre of gravity, m.
    inertia : ndarray, shape (3, 3)
        About the centre of gravity, kg m².
    """

    axis: Array
    end: Array
    mass: float
    centre: Array
    inertia: Array


def links_of(geometry: ArmGeometry, dynamics: ArmDynamics, payload: Payload) -> list[Link]:
    """Return the six links, the last with the payload."""
    tool = np.array((0.0, 0.0, geometry.d6))
    drawn = (
        ((0.0, 0.0, 1.0), (geometry.a1, geometry.shoulder_offset, 0.0)),
        ((0.0, 1.0, 0.0), (0.0, 0.0, geometry.a2)),
        ((0.0, 1.0, 0.0), (geometry.elbow_offset, 0.0, geometry.a3)),
        ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        ((0.0, float(geometry.wrist_sign), 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 1.0), tool),
    )
    links = []
    for k, (axis, to) in enumerate(drawn):
        end, mass = np.array(to), dynamics.masses[k]
        if dynamics.centres is None or dynamics.moments is None:
            centre, inertia = 0.5 * end, _rod(mass, end, dynamics.radii[k])
        else:
            centre, inertia = np.array(dynamics.centres[k]), np.diag(dynamics.moments[k])
        links.append(Link(np.array(axis), end, mass, centre, inertia))
    links[-1] = _with_payload(links[-1], payload)
    return links


def _rod(mass: float, end: Array, radius: float) -> Array:
    """Return the inertia of a solid rod with round ends beyond both joints, about its middle."""
    length = float(np.linalg.norm(end))
    if length == 0.0:
        return 0.4 * mass * radius**2 * np.eye(3)
    of_ends = mass / (1.0 + 0.75 * length / radius)  # by volume
    of_shaft = mass - of_ends
    lengthwise = (0.5 * of_shaft + 0.4 * of_ends) * radius**2
    across = of_shaft * (length**2 / 12.0 + radius**2 / 4.0) + of_ends * (
        0.4 * radius**2 + length**2 / 4.0 + 0.375 * length * radius
    )
    along = np.outer(end, end) / length**2
    return np.asarray(lengthwise * along + across * (np.eye(3) - along))


def _with_payload(link: Link, payload: Payload) -> Link:
    """Return the last link with a load that is fixed to it."""
    total = link.mass + payload.mass
    if total == 0.0:
        return link
    place = link.end + np.array(payload.centre)
    centre = (link.mass * link.centre + payload.mass * place) / total
    inertia = (
        link.inertia
        + np.diag(payload.moments)
        + _moved(link.mass, link.centre - centre)
        + _moved(payload.mass, place - centre)
    )
    return link._replace(mass=total, centre=centre, inertia=inertia)


def _moved(mass: float, by: Array) -> Array:
    """Return what a mass adds to an inertia that is taken about a point so far away."""
    return np.asarray(mass * ((by @ by) * np.eye(3) - np.outer(by, by)))


def torques(links: list[Link], q: Array, rates: Array, accelerations: Array, up: bool) -> Array:
    """Return the joints' torques without friction and rotors, N m, shape (n, 6).

    Parameters
    ----------
    links : list of Link
        The arm.
    q, rates, accelerations : ndarray, shape (n, 6)
        rad, rad/s, rad/s².
    up : bool
        Whether the arm has weight.
    """
    n = len(q)
    turn: Array = np.tile(np.eye(3), (n, 1, 1))
    spin, swing = np.zeros((n, 3)), np.zeros((n, 3))
    lift = np.tile(_GRAVITY if up else np.zeros(3), (n, 1))
    moved = []
    for k, link in enumerate(links):
        axis = turn @ link.axis
        turn = turn @ _about(link.axis, q[:, k])
        swing = swing + axis * accelerations[:, k, None] + np.cross(spin, axis) * rates[:, k, None]
        spin = spin + axis * rates[:, k, None]
        centre, end = turn @ link.centre, turn @ link.end
        inertia = turn @ link.inertia @ turn.transpose(0, 2, 1)
        force = link.mass * (lift + _carried(spin, swing, centre))
        moment = _times(inertia, swing) + np.cross(spin, _times(inertia, spin))
        moved.append((axis, centre, end, force, moment))
        lift = lift + _carried(spin, swing, end)
    force_beyond, moment_beyond = np.zeros((n, 3)), np.zeros((n, 3))
    needed = np.empty((n, len(links)))
    for k in range(len(links) - 1, -1, -1):
        axis, centre, end, force, moment = moved[k]
        moment_beyond = (
            moment_beyond + moment + np.cross(centre, force) + np.cross(end, force_beyond)
        )
        force_beyond = force_beyond + force
        needed[:, k] = np.einsum("ij,ij->i", axis, moment_beyond)
    return needed


def _about(axis: Array, angle: Array) -> Array:
    """Return the rotations about a unit axis, shape (n, 3, 3)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * skew + (1.0 - c) * (skew @ skew))


def _carried(spin: Array, swing: Array, arm: Array) -> Array:
    """Return the acceleration of a point by how its link turns."""
    return np.asarray(np.cross(swing, arm) + np.cross(spin, np.cross(spin, arm)))


def _times(inertia: Array, vector: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", inertia, vector))


class ArmTorques:
    """The torques that an arm with a load needs of its drives.

    Parameters
    ----------
    geometry : ArmGeometry
        Dimensions.
    dynamics : ArmDynamics
        Masses, friction, limits.
    payload : Payload
        In the hand.
    """

    def __init__(self, geometry: ArmGeometry, dynamics: ArmDynamics, payload: Payload) -> None:
        self.carried = payload.mass
        self.limits: Array = np.array(dynamics.torque_limits)
        self._links = links_of(geometry, dynamics, payload)
        self._rotors = np.array(dynamics.rotors)
        self.friction: Array = np.array(dynamics.friction)
        self.viscous: Array = np.array(dynamics.viscous)

    def inertial(self, q: Array, rates: Array, accelerations: Array) -> Array:
        """Return the torques of masses that have no weight, shape (n, 6)."""
        links = torques(self._links, q, rates, accelerations, up=False)
        return np.asarray(links + self._rotors * accelerations)

    def weight(self, q: Array) -> Array:
        """Return the torques that hold the arm still, without friction, shape (n, 6)."""
        still = np.zeros_like(q)
        return torques(self._links, q, still, still, up=True)

    def of(self, q: Array, rates: Array, accelerations: Array) -> Array:
        """Return the whole torques, shape (n, 6); at rest the brakes' work is the friction's."""
        rubbed = self.friction * np.sign(rates) + self.viscous * rates
        return self.inertial(q, rates, accelerations) + self.weight(q) + rubbed
