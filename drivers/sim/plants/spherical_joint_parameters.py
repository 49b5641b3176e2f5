"""From the joint's geometry, settings and a seed to the parameters of ring and wires."""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.sim.plants.spherical_joint_kernel import JOINT_PARAMETERS, WIRE_PARAMETERS
from drivers.sim.plants.spherical_joint_settings import (
    CONTACTS,
    ContactFriction,
    JointPlantSettings,
)
from drivers.sim.plants.spherical_joint_wire import wire_path

WIRES = 4
"""Wires of the joint."""


class JointGeometry(Protocol):
    """The joint's dimensions, m and rad."""

    @property
    def ball_radius(self) -> float:
        """Radius of the ball, on which the anchors lie."""

    @property
    def ring_radius(self) -> float:
        """Radius of the circle of the anchors."""

    @property
    def anchor_angles(self) -> Sequence[float]:
        """Azimuth of each wire from the ball's x axis, shape (4,)."""

    @property
    def adjust_radius(self) -> float:
        """Radius of the circle of the adjust points."""

    @property
    def adjust_depth(self) -> float:
        """Depth of the adjust points below the ball's centre."""

    @property
    def marker_height(self) -> float:
        """Distance of the marker from the ball's centre, along the ring's axis."""


def check_geometry(geometry: JointGeometry) -> None:
    """Raise a ValueError if there is no such joint."""
    ball, ring = geometry.ball_radius, geometry.ring_radius
    if not 0.0 < ring < ball:
        raise ValueError(f"plant: a ring of {ring:g} m does not sit on a ball of {ball:g} m")
    if len(geometry.anchor_angles) != WIRES:
        raise ValueError(f"plant: {len(geometry.anchor_angles)} anchor angles; {WIRES} are needed")
    reach = math.hypot(geometry.adjust_radius, geometry.adjust_depth)
    if not reach > ball:
        raise ValueError(
            f"plant: adjust points {reach:g} m from the centre are not outside a ball of {ball:g} m"
        )


def draw_wires(
    rng: np.random.Generator, settings: JointPlantSettings, geometry: JointGeometry
) -> NDArray[Any]:
    """Return the `WIRE_PARAMETERS` of each wire: the geometry and this unit's deviations.

    Anchors stay on the ball. The wires are as long as the joint as built needs them at home.
    """
    ball = geometry.ball_radius
    polar = math.asin(geometry.ring_radius / ball)
    friction = contact_friction(settings).wire
    wires = np.zeros(WIRES, WIRE_PARAMETERS)
    for wire, angle in zip(wires, geometry.anchor_angles, strict=True):
        turned, raised, *shift, unit, offset = rng.uniform(-1.0, 1.0, 7)
        azimuth = angle + settings.tolerance * turned / geometry.ring_radius
        colatitude = polar - settings.tolerance * raised / ball
        anchor = (
            ball * math.sin(colatitude) * math.cos(azimuth),
            ball * math.sin(colatitude) * math.sin(azimuth),
            ball * math.cos(colatitude),
        )
        adjust = (
            geometry.adjust_radius * math.cos(angle) + settings.tolerance * shift[0],
            geometry.adjust_radius * math.sin(angle) + settings.tolerance * shift[1],
            -geometry.adjust_depth + settings.tolerance * shift[2],
        )
        wire["anchor_x"], wire["anchor_y"], wire["anchor_z"] = anchor
        wire["adjust_x"], wire["adjust_y"], wire["adjust_z"] = adjust
        wire["free"] = settings.wire_offset * offset - settings.home
        wire["friction"] = friction * (1.0 + settings.friction_spread * unit)
        wire["stiffness"] = settings.ring.contact_stiffness
        wire["damping"] = settings.ring.contact_damping
    wires["free"] += home_lengths(wires, ball)
    return wires


def home_lengths(wires: NDArray[Any], ball_radius: float) -> list[float]:
    """Return how long each wire is with the ring at home, m."""
    ends = ("anchor_x", "anchor_y", "anchor_z", "adjust_x", "adjust_y", "adjust_z")
    return [
        wire_path(ax, ay, az, bx, by, bz, ball_radius)[0]
        for ax, ay, az, bx, by, bz in wires[list(ends)].tolist()
    ]


def draw_joint(
    rng: np.random.Generator, settings: JointPlantSettings, geometry: JointGeometry
) -> NDArray[Any]:
    """Return the `JOINT_PARAMETERS`: ring, seat and marker, with this unit's deviations.

    The wires pull the ring onto its seat with their sum; the cone of the contact, which leans
    by the angle of the ring from the pole, turns that into more normal force.
    """
    ring, ball = settings.ring.loaded(), geometry.ball_radius
    lean = math.tan(math.asin(geometry.ring_radius / ball))
    spread = 1.0 + settings.friction_spread * rng.uniform(-1.0, 1.0)
    x, y, z = (settings.tolerance * rng.uniform(-1.0, 1.0, 3)).tolist()
    values = {
        "supply_time": settings.feed.supply_time,
        "supply_volume": settings.feed.supply_volume,
        "ball_radius": ball,
        "inertia_tilt": ring.inertia_tilt,
        "inertia_spin": ring.inertia_spin,
        "weight": 9.80665 * ring.mass,
        "centre_height": ring.centre_height,
        "seat_arm": contact_friction(settings).ring * spread * lean * ring.seat_lever * ball,
        "seat_stiffness": ring.contact_stiffness * ball**2,
        "seat_damping": ring.contact_damping * ball**2,
        "tilt_stop": ring.tilt_stop,
        "stop_stiffness": ring.stop_stiffness,
        "stop_damping": ring.stop_damping,
        "marker_x": x,
        "marker_y": y,
        "marker_z": geometry.marker_height + z,
    }
    joint = np.zeros(1, JOINT_PARAMETERS)
    joint[0] = tuple(values[name] for name in JOINT_PARAMETERS.names or ())
    return joint


def contact_friction(settings: JointPlantSettings) -> ContactFriction:
    """Return the nominal friction on the ball."""
    nominal, scale = CONTACTS[settings.seals], settings.friction_scale
    return ContactFriction(
        ring=nominal.ring * scale * settings.ring_friction_scale,
        wire=nominal.wire * scale * settings.wire_friction_scale,
    )
