"""Parameters of the arm's plant.

All defaults are estimates (E) for a robot of about 0.8 m reach that carries 1 kg: link masses as
such robots have them, friction a tenth of a harmonic drive's rating, drives as their makers tune
them. Lengths and joint ranges are the profile's geometry.
"""

from dataclasses import dataclass, field
from typing import Annotated, TypeVar

from annotated_types import Ge, Gt, Interval, Unit

T = TypeVar("T")
Six = tuple[T, T, T, T, T, T]

Torque = Annotated[float, Unit("N m"), Gt(0)]
Friction = Annotated[float, Unit("N m"), Ge(0)]
Viscous = Annotated[float, Unit("N m s/rad"), Ge(0)]
Inertia = Annotated[float, Unit("kg m^2"), Gt(0)]
Mass = Annotated[float, Unit("kg"), Gt(0)]
Angle = Annotated[float, Unit("rad")]


@dataclass(frozen=True, slots=True)
class ArmDriveSettings:
    """The six drives: cascaded loops of position, velocity and torque, without gravity terms.

    Parameters
    ----------
    position_bandwidth : float
        Of the position loop, Hz.
    velocity_bandwidth : float
        Of the velocity loop, for the inertia that it was tuned for, Hz.
    integral_ratio : float
        Of the velocity loop: its bandwidth over the corner frequency of its integral part.
    torque_bandwidth : float
        Of the torque (current) loop, Hz.
    torque_limits : tuple of float
        Peak torque at each joint, N m.
    inertias : tuple of float
        Of motor and gear, at each joint, kg m².
    friction : tuple of float
        Dry friction of each joint, N m.
    viscous : tuple of float
        Viscous friction of each joint, N m s/rad.
    brakes : tuple of float
        Holding torque of each joint's brake, which is on while the drive has no torque, N m;
        0 for none.
    hold_after : float
        A moving reference that is not renewed for so long stands still, s.
    """

    position_bandwidth: Annotated[float, Unit("Hz"), Gt(0)] = 7.0
    velocity_bandwidth: Annotated[float, Unit("Hz"), Gt(0)] = 40.0
    integral_ratio: Annotated[float, Gt(1)] = 5.0
    torque_bandwidth: Annotated[float, Unit("Hz"), Gt(0)] = 300.0
    torque_limits: Six[Torque] = (150.0, 150.0, 100.0, 40.0, 40.0, 30.0)
    inertias: Six[Inertia] = (1.2, 1.2, 0.8, 0.2, 0.2, 0.12)
    friction: Six[Friction] = (8.0, 8.0, 5.0, 1.5, 1.5, 1.0)
    viscous: Six[Viscous] = (10.0, 10.0, 6.0, 2.0, 2.0, 1.2)
    brakes: Six[Friction] = (200.0, 200.0, 130.0, 50.0, 50.0, 40.0)
    hold_after: Annotated[float, Unit("s"), Gt(0)] = 0.05


@dataclass(frozen=True, slots=True)
class ArmLinkSettings:
    """Masses and radii of the links; each is a rod from joint to joint.

    Parameters
    ----------
    masses : tuple of float
        Shoulder, upper arm, forearm, and the wrist's three, kg.
    radii : tuple of float
        Of the same links, m.
    payload : float
        At the tool point, kg.
    """

    masses: Six[Mass] = (6.0, 5.0, 3.2, 1.0, 1.0, 0.5)
    radii: Six[float] = (0.08, 0.05, 0.045, 0.04, 0.04, 0.03)
    payload: Annotated[float, Unit("kg"), Ge(0)] = 0.5


@dataclass(frozen=True, slots=True)
class ArmPlantSettings:
    """The arm with its drives.

    Parameters
    ----------
    links : ArmLinkSettings
        What it is made of.
    drives : ArmDriveSettings
        What moves it.
    start : tuple of float, optional
        Where the joints stand at first, rad. None: 0, 30, 90, 0, -30 and 0 degrees, or as near as
        their ranges permit.
    stop_margin : float
        From a joint's range to its mechanical stop, rad.
    mass_spread, friction_spread : float
        Bounds of the relative deviations of each link's mass and each joint's friction from
        unit to unit.
    timestep : float
        Of integration and drives, s.
    """

    links: ArmLinkSettings = field(default_factory=ArmLinkSettings)
    drives: ArmDriveSettings = field(default_factory=ArmDriveSettings)
    start: Six[Angle] | None = None
    stop_margin: Annotated[float, Unit("rad"), Ge(0)] = 0.1
    mass_spread: Annotated[float, Interval(ge=0.0, lt=0.5)] = 0.05
    friction_spread: Annotated[float, Interval(ge=0.0, lt=1.0)] = 0.3
    timestep: Annotated[float, Unit("s"), Interval(ge=1e-4, le=2e-3)] = 1e-3

    def variant(self) -> None:
        """Return nothing: there is one kind of arm only."""

    def perturbed(
        self, *, friction: float, stribeck: float, wire_offset: float
    ) -> "ArmPlantSettings":
        """Return them as they are: an arm has no seals and no wires."""
        return self
