"""Friction on a joint's ball, as it is believed to be, along a recorded motion.

The model has two parts. The ring slides in its seat: its friction grows with all four tensions and
opposes the ring's angular velocity w. It costs the power K |w|, and each pair gives a share of
that power. Further from upright the axis turns more for the same way of the wires, so |w| comes
from the axis and not from the wires. A wire loses its tension times its friction coefficient times
the angle by which it is wound on the ball; that angle changes by half along a stroke.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import PAIRS, SphericalJointGeometry
from controllers.spherical_joint.poses import natural_rotation
from rig.calibration.arrays import Array, Indices, between_rows
from rig.calibration.profile_changes import profile_with
from rig.calibration.recording import Stretch
from rig.config import Profile
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.pneumatic.calibration.smoothing import Bump, SmoothSignals

_POSE_EVERY = 10
"""Samples between two poses for which the axis and the wound angles are computed."""


class Belief(NamedTuple):
    """Friction parameters of a joint.

    Parameters
    ----------
    coulomb : float
        Of a pair's seals at base pressure, N.
    viscous : float
        Of a pair, N s/m.
    ring : float
        Of the ring at the wires' radius, over all four tensions.
    wire : float
        Coefficient of the wires.
    wound : float
        Angle by which a wire is wound with the ring upright, rad.
    seals : float
        Growth of a pair's seals' friction with the sum of its tensions.
    usual : float
        That sum at base pressure, N.
    """

    coulomb: float
    viscous: float
    ring: float
    wire: float
    wound: float
    seals: float
    usual: float

    @property
    def shared(self) -> float:
        """Friction on the ball over a pair's tensions, both pairs moving and the ring upright.

        The tension that the wires lose does not load the ring.
        """
        ring, wires = math.sqrt(2.0) * self.ring, self.wound * self.wire
        return (ring + wires) / (1.0 + ring * wires)

    @property
    def alone(self) -> float:
        """The same with equal tensions in both pairs, of which one moves."""
        wires = self.wound * self.wire
        return (2.0 * self.ring + wires) / (1.0 + self.ring * wires)

    def with_ring(self, share: float) -> "Belief":
        """Return the same friction on the ball with a larger part of it the ring's.

        Parameters
        ----------
        share : float
            Increase of the ring's part, over that part; the wires' part shrinks as far as it can.
        """
        ring, both = (1.0 + share) * self.ring, self.shared
        wires = max((both - math.sqrt(2.0) * ring) / (1.0 - both * ring), 0.0)
        return self._replace(ring=ring, wire=wires / self.wound)

    def seal(self, pull: Array, speed: Array) -> Array:
        """Return the friction of one rod's seals (N) under a chamber's pull (N) at a speed."""
        still = 0.5 * (self.coulomb - self.seals * self.usual)
        friction: Array = still + self.seals * pull + 0.5 * self.viscous * np.abs(speed)
        return friction


def belief_of(profile: Profile) -> Belief:
    """Return the profile's friction; there the seals' does not grow with the tensions."""
    settings = profile.mechanism_settings
    friction = settings.friction
    wound = 0.5 * math.pi - settings.geometry.ring_half_angle
    return Belief(
        friction.coulomb, friction.viscous, friction.ring, friction.wire, wound, 0.0,
        2.0 * settings.area * settings.base_pressure,
    )  # fmt: skip


def with_stiffer_wires(profile: Profile) -> Profile:
    """Return a joint's profile with wires that are stiffer by their tolerance."""
    settings = profile.mechanism_settings
    stiffness = (1.0 + settings.tolerance.stiffness) * settings.wire_stiffness
    return profile_with(profile, {f"{profile.mechanism}.wire_stiffness": stiffness})


def friction_on_ball(
    profile: Profile,
    belief: Belief,
    stretch: Stretch,
    axis: Array,
    signals: Sequence[SmoothSignals],
) -> list[Array]:
    """Return the believed friction on each pair, N, weighed with the bump of its signals.

    Parameters
    ----------
    profile : Profile
        Of a joint.
    belief : Belief
        Its friction.
    stretch : Stretch
        What was recorded.
    axis : ndarray, shape (n, 3)
        Of the ring.
    signals : sequence of SmoothSignals
        Of both pairs, of the same stretch.
    """
    settings, bump = profile.mechanism_settings, Bump(profile.loop.period)
    turning = np.linalg.norm(np.column_stack([bump.rate(column) for column in axis.T]), axis=1)
    wound, pulls = _wound(settings.geometry, axis), JointPneumatics(profile).pulls(stretch)
    speeds: list[Array] = []
    lost: list[Array] = []
    bearing = np.zeros_like(turning)
    for wires, pair in zip(PAIRS, signals, strict=True):
        side = np.sign(pair.velocity)
        mine, speed = np.zeros_like(turning), pair.velocity
        for wire, sign in zip(wires, (1.0, -1.0), strict=True):
            angle = bump.mean(wound[:, wire])
            # The seals' friction lies between chamber and wire, then the ball's.
            tension = bump.mean(pulls[:, wire])
            tension = tension - belief.seal(tension, pair.velocity) * sign * side
            on_wire = belief.wire * angle * tension
            bearing += tension - on_wire * sign * side
            mine += on_wire * side
            # A wire shortens as its tension falls: the ring is then faster than the rod.
            speed = speed - 0.5 * sign * bump.rate(pulls[:, wire]) / settings.wire_stiffness
        speeds.append(speed)
        lost.append(mine)
    square = np.maximum(np.sum([speed**2 for speed in speeds], axis=0), 1e-12)
    ring = belief.ring * bearing * settings.geometry.ball_radius * turning / square
    return [ring * speed + mine for speed, mine in zip(speeds, lost, strict=True)]


def sheared(profile: Profile, stretch: Stretch, signals: Sequence[SmoothSignals]) -> list[Array]:
    """Return the speed at which a pair with equal rods has the same viscous friction, m/s.

    Away from upright one rod of a pair is faster than the other one, and the power lost grows with
    the square of their speeds.
    """
    bump, rods = Bump(profile.loop.period), JointPneumatics(profile).rods(stretch)
    found = []
    for wires, pair in zip(PAIRS, signals, strict=True):
        square = np.zeros_like(pair.velocity)
        for wire in wires:
            square += bump.rate(rods[:, wire] - rods[0, wire]) ** 2
        still = np.where(pair.velocity == 0.0, 1.0, pair.velocity)
        found.append(0.5 * square / still)
    return found


def axis_of(profile: Profile, belief: Belief, stretch: Stretch) -> Array:
    """Return where the ring points in a stroke, shape (n, 3).

    The wires' stretch follows from the pressures less the seals' friction. While the motion runs,
    the controller can only take it from its own belief of the friction.
    """
    places = _places(len(stretch["t"]))
    pulled_in, pull = _rods(profile, stretch, places)
    speed = np.gradient(pulled_in, stretch["t"][places], axis=0)
    taken = np.sign(pulled_in[-1] - pulled_in[0]) * belief.seal(pull, speed)
    return axis_with(profile, stretch, taken)


def axis_with(profile: Profile, stretch: Stretch, taken: Array) -> Array:
    """Return where the ring points, shape (n, 3), for given friction of the rods' seals.

    Parameters
    ----------
    profile, stretch
        Of a joint, and what was recorded.
    taken : ndarray, shape (4,) or (m, 4)
        Friction of each rod's seals, N: constant, or at each pose.
    """
    settings = profile.mechanism_settings
    forward = ForwardKinematics(settings.geometry)
    places = _places(len(stretch["t"]))
    pulled_in, pull = _rods(profile, stretch, places)
    rows = pulled_in - (pull - taken) / settings.wire_stiffness
    axis = np.array([forward.update((a, b, c, d)).axis for a, b, c, d in rows.tolist()])
    return between_rows(axis, places, np.arange(len(stretch["t"])))


def _rods(profile: Profile, stretch: Stretch, places: Indices) -> tuple[Array, Array]:
    """Return how far each rod is pulled in, m, and its chamber's pull, N, shape (m, 4)."""
    pneumatics = JointPneumatics(profile)
    return pneumatics.rods(stretch)[places], pneumatics.pulls(stretch)[places]


def _places(count: int) -> Indices:
    """Return the samples whose pose is computed, the last one among them."""
    return np.unique(np.append(np.arange(0, count, _POSE_EVERY), count - 1))


def _wound(geometry: SphericalJointGeometry, axis: Array) -> Array:
    """Return by which angle each wire is wound on the ball, rad, shape (n, 4)."""
    anchors, adjusts = np.array(geometry.anchors), np.array(geometry.adjust_points)
    straight = math.acos(geometry.ball_radius / geometry.adjust_distance)
    size = geometry.ball_radius * geometry.adjust_distance
    places = _places(len(axis))
    rows = []
    for x, y, z in axis[places].tolist():
        turned = anchors @ np.array(natural_rotation((x, y, z))).T
        cosine = np.clip((turned * adjusts).sum(axis=1) / size, -1.0, 1.0)
        rows.append(np.maximum(np.arccos(cosine) - straight, 0.0))
    return between_rows(np.array(rows), places, np.arange(len(axis)))
