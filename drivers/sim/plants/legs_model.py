"""From the legs' dimensions to a MuJoCo model; an algebra of its own, none of the controllers'."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol
from xml.etree.ElementTree import Element, tostring

import numpy as np

from drivers.sim.plants.legs_settings import LegServoSettings, TerrainBlock
from drivers.sim.plants.mjcf import add

if TYPE_CHECKING:
    import mujoco

Vector3 = tuple[float, float, float]


class SoleDimensions(Protocol):
    """The sole's rectangle, from under the ankle, m."""

    front: float
    back: float
    half_width: float


class LinkMasses(Protocol):
    """Masses (kg) and centres of the links."""

    hip_yaw: float
    hip_roll: float
    thigh: float
    shank: float
    ankle: float
    foot: float
    upper_body: float
    thigh_centre: float
    shank_centre: float
    foot_depth: float
    upper_body_forward: float
    upper_body_height: float


class LegDimensions(Protocol):
    """The part of a profile's geometry that the plant needs: m, kg, rad, rad/s, N m."""

    @property
    def axes(self) -> tuple[str, ...]:
        """Of the joints of a leg, from the waist."""

    thigh: float
    shank: float
    ankle_height: float
    hip_half_spacing: float

    @property
    def sole(self) -> SoleDimensions:
        """What a foot stands on."""

    @property
    def masses(self) -> LinkMasses:
        """Of the links."""

    max_rate: float

    @property
    def torque_peak(self) -> tuple[float, ...]:
        """Of a leg's servos, N m."""


class FloorSlope(NamedTuple):
    """A floor through the middle between the soles of a robot that stands ready.

    Parameters
    ----------
    pitch, roll : float
        rad: the way ahead goes down, the left side is higher.
    """

    pitch: float = 0.0
    roll: float = 0.0

    @property
    def normal(self) -> Vector3:
        """Away from the floor."""
        s, c = math.sin(self.roll), math.cos(self.roll)
        return (math.sin(self.pitch) * c, 0.0 - s, math.cos(self.pitch) * c)

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Turns the vertical to the normal, about y and then about the turned x."""
        s, c = math.sin(0.5 * self.pitch), math.cos(0.5 * self.pitch)
        sr, cr = math.sin(0.5 * self.roll), math.cos(0.5 * self.roll)
        return (c * cr, c * sr, s * cr, -s * sr)

    def height(self, x: float, y: float) -> float:
        """Return how high the floor is there, m."""
        ahead, left, up = self.normal
        return -(ahead * x + left * y) / up


LEVEL_FLOOR = FloorSlope()


class LegDeviations(NamedTuple):
    """Differences of a unit from its drawing.

    Parameters
    ----------
    masses : tuple of float
        Factors: upper body, then the six links of the right and of the left leg.
    frictions : tuple of float
        Factors of the twelve joints' dry and viscous friction.
    floor : float
        Factor of the floor's friction.
    """

    masses: tuple[float, ...] = (1.0,) * 13
    frictions: tuple[float, ...] = (1.0,) * 12
    floor: float = 1.0


NOMINAL = LegDeviations()

JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
CHANNELS = tuple(f"{leg}_{joint}" for leg in ("right", "left") for joint in JOINTS)

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_SOLE_THICKNESS = 0.004
_LINK_WIDTH = 0.05
"""Across a leg's links, m: for their inertia. E."""
_BODY_SIZE = (0.10, 0.16, 0.24)
"""Of the upper body, m: for its inertia. E."""
_BLOCK_DEPTH = 0.4
"""Of what is on the floor, down its own axis, m: it goes well below."""
_CONTACT = (0.01, 1.0)
"""Time in which the floor pushes a sole out, s, and damping ratio."""


def build_model(
    geometry: LegDimensions,
    servo: LegServoSettings,
    *,
    floor_friction: float,
    timestep: float,
    deviations: LegDeviations = NOMINAL,
    terrain: tuple[TerrainBlock, ...] = (),
    floor: FloorSlope = LEVEL_FLOOR,
) -> "mujoco.MjModel":
    """Return the whole robot with its floor.

    Bodies: ``waist`` (free), and per leg ``right_hip_yaw`` … ``right_foot``. Sites ``right_sole``
    and ``left_sole`` are under the ankles.

    Parameters
    ----------
    geometry : LegDimensions
        Lengths, masses, torques.
    servo : LegServoSettings
        Of every joint.
    floor_friction : float
        Coefficient.
    timestep : float
        s.
    deviations : LegDeviations
        Of this unit.
    terrain : tuple of TerrainBlock
        What is on the floor: geoms ``terrain_0`` and so on.
    floor : FloorSlope
        Of the floor itself.
    """
    import mujoco

    return mujoco.MjModel.from_xml_string(
        describe(geometry, servo, floor_friction, timestep, deviations, terrain, floor)
    )


def describe(
    geometry: LegDimensions,
    servo: LegServoSettings,
    floor_friction: float,
    timestep: float,
    deviations: LegDeviations = NOMINAL,
    terrain: tuple[TerrainBlock, ...] = (),
    floor: FloorSlope = LEVEL_FLOOR,
) -> str:
    """Return the same as MJCF text; its form is the same in all of MuJoCo's versions."""
    root = Element("mujoco", model="legs")
    # Friction cones of a soft floor creep; a higher ratio makes them hold.
    add(root, "option", timestep=timestep, integrator="implicitfast", cone="elliptic", impratio=10)
    add(root, "compiler", angle="radian", autolimits=False)
    world = add(root, "worldbody")
    add(
        world,
        "geom",
        name="floor",
        type="plane",
        size=(2.0, 2.0, 0.1),
        quat=floor.quaternion,
        friction=(floor_friction * deviations.floor, 0.005, 0.0001),
        solref=_CONTACT,
    )
    for number, block in enumerate(terrain):
        _add_block(world, number, block, floor_friction * deviations.floor)
    masses = geometry.masses
    waist = add(world, "body", name="waist")
    add(waist, "freejoint", name="waist")
    _add_inertia(
        waist,
        masses.upper_body * deviations.masses[0],
        (masses.upper_body_forward, 0.0, masses.upper_body_height),
        _BODY_SIZE,
    )
    actuators = add(root, "actuator")
    for number, side in enumerate((-1.0, 1.0)):
        mine = slice(6 * number, 6 * number + 6)
        _add_leg(
            waist,
            side,
            geometry,
            servo,
            CHANNELS[mine],
            deviations.masses[1:][mine],
            deviations.frictions[mine],
        )
        for channel, peak in zip(CHANNELS[mine], geometry.torque_peak, strict=True):
            add(
                actuators,
                "position",
                name=channel,
                joint=channel,
                kp=servo.stiffness,
                kv=servo.damping,
                forcelimited=True,
                forcerange=(-peak, peak),
            )
    return tostring(root, encoding="unicode")


def _add_block(world: Element, number: int, block: TerrainBlock, friction: float) -> None:
    s, c = math.sin(block.slope), math.cos(block.slope)
    half, deep = 0.5 * block.length / c, 0.5 * _BLOCK_DEPTH
    # The middle of its upper side, and from there half its depth down its own axis.
    at = (
        block.start + 0.5 * block.length + deep * s,
        0.0,
        block.height + 0.5 * block.length * s / c - deep * c,
    )
    add(
        world,
        "geom",
        name=f"terrain_{number}",
        type="box",
        size=(half, 1.0, deep),
        pos=at,
        euler=(0.0, -block.slope, 0.0),
        friction=(friction, 0.005, 0.0001),
        solref=_CONTACT,
    )


def _add_leg(
    waist: Element,
    side: float,
    geometry: LegDimensions,
    servo: LegServoSettings,
    channels: tuple[str, ...],
    mass_factors: tuple[float, ...],
    friction_factors: tuple[float, ...],
) -> None:
    m, sole = geometry.masses, geometry.sole
    thigh, shank = geometry.thigh, geometry.shank
    here, wide = (0.0, 0.0, 0.0), _LINK_WIDTH
    leg = "left" if side > 0.0 else "right"
    length = sole.front + sole.back
    # Name, where its joint is in the parent, mass, centre, size.
    links: tuple[tuple[str, Vector3, float, Vector3, Vector3], ...] = (
        ("hip_yaw", (0.0, side * geometry.hip_half_spacing, 0.0), m.hip_yaw, here, (wide,) * 3),
        ("hip_roll", here, m.hip_roll, here, (wide,) * 3),
        ("thigh", here, m.thigh, (0.0, 0.0, -m.thigh_centre * thigh), (wide, wide, thigh)),
        (
            "shank",
            (0.0, 0.0, -thigh),
            m.shank,
            (0.0, 0.0, -m.shank_centre * shank),
            (wide, wide, shank),
        ),
        ("ankle", (0.0, 0.0, -shank), m.ankle, here, (wide,) * 3),
        ("foot", here, m.foot, (0.0, 0.0, -m.foot_depth), (length, 2.0 * sole.half_width, 0.02)),
    )
    body = waist
    for number, (link, at, mass, centre, size) in enumerate(links):
        body = add(body, "body", name=f"{leg}_{link}", pos=at)
        _add_inertia(body, mass * mass_factors[number], centre, size)
        add(
            body,
            "joint",
            name=channels[number],
            type="hinge",
            axis=_AXES[geometry.axes[number]],
            armature=servo.inertia,
            frictionloss=servo.friction * friction_factors[number],
            damping=servo.viscous * friction_factors[number],
        )
    add(
        body,
        "geom",
        name=f"{leg}_sole",
        type="box",
        size=(0.5 * length, sole.half_width, 0.5 * _SOLE_THICKNESS),
        pos=(
            0.5 * (sole.front - sole.back),
            0.0,
            -geometry.ankle_height + 0.5 * _SOLE_THICKNESS,
        ),
        mass=0.0,
        friction=(0.0, 0.0, 0.0),  # the larger of both counts: the floor's
        solref=_CONTACT,
        contype=2,  # soles meet the floor, not each other
        conaffinity=1,
    )
    add(body, "site", name=f"{leg}_sole", pos=(0.0, 0.0, -geometry.ankle_height))


def _add_inertia(body: Element, mass: float, centre: Vector3, size: Vector3) -> None:
    """Give a body the mass and inertia of a box."""
    x, y, z = (side * side * mass / 12.0 for side in size)
    add(body, "inertial", mass=mass, pos=centre, diaginertia=(y + z, x + z, x + y))


def lowest_corner(
    model: "mujoco.MjModel", data: "mujoco.MjData", boxes: Sequence[int], floor: FloorSlope
) -> float:
    """Return how high over a floor the lowest corner of some boxes, by their numbers, is, m."""
    up = np.array(floor.normal)
    heights = [
        up @ data.geom_xpos[box]
        - np.abs(up @ data.geom_xmat[box].reshape(3, 3)) @ model.geom_size[box]
        for box in boxes
    ]
    return float(min(heights)) / float(up[2])


def stand_on(
    geometry: LegDimensions, height: float, floor: FloorSlope
) -> tuple[Vector3, list[float]]:
    """Return the waist's place (m) and the joints (rad) of a robot that stands upright on a floor.

    Parameters
    ----------
    geometry : LegDimensions
        The legs.
    height : float
        Of the hips above the middle between the ankles, m.
    floor : FloorSlope
        On which both soles are flat.

    Raises
    ------
    ValueError
        A leg does not reach.
    """
    x, y, up = (geometry.ankle_height * part for part in floor.normal)
    joints: list[float] = []
    for side in (-1.0, 1.0):
        own = height - floor.height(0.0, side * geometry.hip_half_spacing)
        pitch, knee, ankle = knee_at_height(geometry.thigh, geometry.shank, own)
        joints += [0.0, 0.0, pitch, knee, ankle + floor.pitch, floor.roll]
    return (x, y, up + height), joints


def knee_at_height(thigh: float, shank: float, height: float) -> tuple[float, float, float]:
    """Return hip pitch, knee and ankle pitch (rad) with the hip `height` (m) above the ankle.

    Raises
    ------
    ValueError
        The leg does not reach.
    """
    if not abs(thigh - shank) < height <= thigh + shank:
        raise ValueError(
            f"initial_hip_height ({height:g} m): the leg reaches {abs(thigh - shank):g} … "
            f"{thigh + shank:g} m."
        )
    # Angles of the triangle hip, knee, ankle.
    at_hip = math.acos((thigh**2 + height**2 - shank**2) / (2.0 * thigh * height))
    at_ankle = math.acos((shank**2 + height**2 - thigh**2) / (2.0 * shank * height))
    return -at_hip, at_hip + at_ankle, -at_ankle


def attitude(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a quaternion, rad."""
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw
