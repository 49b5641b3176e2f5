"""From the arm's dimensions to a MuJoCo model; an algebra of its own, none of the controllers'."""

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol
from xml.etree.ElementTree import Element, SubElement, tostring

from drivers.sim.plants.arm_settings import ArmPlantSettings

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
    SubElement(root, "compiler", angle="radian", autolimits="true")
    option = SubElement(
        root,
        "option",
        timestep=_number(settings.timestep),
        gravity="0 0 -9.80665",
        integrator="implicitfast",
    )
    SubElement(option, "flag", contact="disable")
    body = SubElement(root, "worldbody")
    wrist_bend = _vector(0.0, float(geometry.wrist_sign), 0.0)
    places = (
        (_vector(0.0, 0.0, geometry.base_height), "0 0 1"),
        (_vector(0.0, geometry.shoulder_offset, 0.0), "0 1 0"),
        (_vector(0.0, 0.0, geometry.a2), "0 1 0"),
        (_vector(geometry.elbow_offset, 0.0, geometry.a3), "0 0 1"),
        (_vector(0.0, 0.0, 0.0), wrist_bend),
        (_vector(0.0, 0.0, 0.0), "0 0 1"),
    )
    here = (0.0, 0.0, 0.0)
    ends = (
        (0.0, geometry.shoulder_offset, 0.0),
        (0.0, 0.0, geometry.a2),
        (geometry.elbow_offset, 0.0, geometry.a3),
        here,
        here,
        (0.0, 0.0, geometry.d6),
    )
    for k, (position, axis) in enumerate(places):
        body = SubElement(body, "body", name=LINKS[k], pos=position)
        factor = deviations.frictions[k]
        SubElement(
            body,
            "joint",
            name=JOINTS[k],
            axis=axis,
            range=f"{_number(geometry.position_min[k] - settings.stop_margin)} "
            f"{_number(geometry.position_max[k] + settings.stop_margin)}",
            armature=_number(drives.inertias[k]),
            frictionloss=_number(drives.friction[k] * factor),
            damping=_number(drives.viscous[k] * factor),
            solimpfriction=_STIFF_FRICTION,
        )
        mass = links.masses[k] * deviations.masses[k]
        _add_rod(body, ends[k], links.radii[k], mass)
    SubElement(body, "site", name=HAND, pos=_vector(0.0, 0.0, geometry.d6))
    x, y, z = geometry.marker
    SubElement(body, "site", name=MARKER, pos=_vector(x, y, geometry.d6 + z))
    if links.payload > 0.0:
        SubElement(
            body,
            "geom",
            type="sphere",
            size="0.03",
            pos=_vector(0.0, 0.0, geometry.d6),
            mass=_number(links.payload),
        )
    actuators = SubElement(root, "actuator")
    for joint in JOINTS:
        SubElement(actuators, "motor", name=joint, joint=joint)
    return tostring(root, encoding="unicode")


def _add_rod(body: Element, end: tuple[float, float, float], radius: float, mass: float) -> None:
    """Add a capsule from the joint to `end`, or a ball if they are one point."""
    shape: dict[str, Any] = {"size": _number(radius), "mass": _number(mass)}
    if any(end):
        SubElement(body, "geom", type="capsule", fromto=f"0 0 0 {_vector(*end)}", **shape)
    else:
        SubElement(body, "geom", type="sphere", **shape)


def _vector(*values: float) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return repr(float(value))
