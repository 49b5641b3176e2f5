"""From the arm's dimensions to a MuJoCo model; an algebra of its own, none of the controllers'."""

from typing import TYPE_CHECKING, NamedTuple, Protocol
from xml.etree.ElementTree import Element, tostring

from drivers.sim.plants.arm_settings import ArmPlantSettings
from drivers.sim.plants.mjcf import add

if TYPE_CHECKING:
    import mujoco

JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
LINKS = ("shoulder", "upper_arm", "forearm", "wrist", "wrist_bend", "tool")
HAND = "hand"
MARKER = "marker"

_STIFF_FRICTION = "0.9999 0.9999 0.001 0.5 2"
"""MuJoCo softens dry friction, so that a braked joint creeps; with its own default by 10 mrad/s."""


class ArmDimensions(Protocol):
    """The part of a profile's geometry that the plant needs: m and rad.

    At zero the arm stands straight up. q1 turns about Z, q2 and q3 about Y, the wrist about Z,
    `wrist_sign` times Y, and Z.
    """

    a2: float
    a3: float
    d6: float
    base_height: float
    wrist_sign: int
    elbow_offset: float
    shoulder_offset: float
    a1: float
    marker: tuple[float, float, float]
    position_min: tuple[float, ...]
    position_max: tuple[float, ...]


class ArmDeviations(NamedTuple):
    """Differences of a unit from its drawing: factors.

    Parameters
    ----------
    masses : tuple of float
        Of the six links.
    frictions : tuple of float
        Of the six joints' dry and viscous friction.
    """

    masses: tuple[float, ...] = (1.0,) * 6
    frictions: tuple[float, ...] = (1.0,) * 6


def build_model(
    geometry: ArmDimensions, settings: ArmPlantSettings, deviations: ArmDeviations
) -> "mujoco.MjModel":
    """Return the arm as MuJoCo has it: six hinges with dry friction, driven by torques.

    Parameters
    ----------
    geometry : ArmDimensions
        Lengths and joint ranges.
    settings : ArmPlantSettings
        Masses, friction, motors.
    deviations : ArmDeviations
        Of this unit.
    """
    import mujoco

    return mujoco.MjModel.from_xml_string(describe_model(geometry, settings, deviations))


def describe_model(
    geometry: ArmDimensions, settings: ArmPlantSettings, deviations: ArmDeviations
) -> str:
    """Return the arm in MuJoCo's own language."""
    drives, links = settings.drives, settings.links
    root = Element("mujoco", model="arm")
    add(root, "compiler", angle="radian", autolimits=True)
    option = add(
        root,
        "option",
        timestep=settings.timestep,
        gravity="0 0 -9.80665",
        integrator="implicitfast",
    )
    add(option, "flag", contact="disable")
    body = add(root, "worldbody")
    place, hand = (0.0, 0.0, geometry.base_height), (0.0, 0.0, geometry.d6)
    about_y, about_z, here = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
    # Of each joint its axis, and where its link ends, at which the next joint is.
    rods = (
        (about_z, (geometry.a1, geometry.shoulder_offset, 0.0)),
        (about_y, (0.0, 0.0, geometry.a2)),
        (about_y, (geometry.elbow_offset, 0.0, geometry.a3)),
        (about_z, here),
        ((0.0, float(geometry.wrist_sign), 0.0), here),
        (about_z, hand),
    )
    for k, (axis, end) in enumerate(rods):
        body = add(body, "body", name=LINKS[k], pos=place)
        factor = deviations.frictions[k]
        add(
            body,
            "joint",
            name=JOINTS[k],
            axis=axis,
            range=(
                geometry.position_min[k] - settings.stop_margin,
                geometry.position_max[k] + settings.stop_margin,
            ),
            armature=drives.inertias[k],
            frictionloss=drives.friction[k] * factor,
            damping=drives.viscous[k] * factor,
            solimpfriction=_STIFF_FRICTION,
        )
        _add_rod(body, end, links.radii[k], links.masses[k] * deviations.masses[k])
        place = end
    add(body, "site", name=HAND, pos=hand)
    x, y, z = geometry.marker
    add(body, "site", name=MARKER, pos=(x, y, geometry.d6 + z))
    if links.payload > 0.0:
        add(body, "geom", type="sphere", size=0.03, pos=hand, mass=links.payload)
    actuators = add(root, "actuator")
    for joint in JOINTS:
        add(actuators, "motor", name=joint, joint=joint)
    return tostring(root, encoding="unicode")


def _add_rod(body: Element, end: tuple[float, float, float], radius: float, mass: float) -> None:
    """Add a capsule from the joint to `end`, or a ball if they are one point."""
    if any(end):
        add(body, "geom", type="capsule", fromto=(0.0, 0.0, 0.0, *end), size=radius, mass=mass)
    else:
        add(body, "geom", type="sphere", size=radius, mass=mass)
