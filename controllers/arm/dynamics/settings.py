"""What a profile says of the arm's masses and drives, and a path of what the hand carries."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval, Unit

Torque = Annotated[float, Unit("N m"), Interval(gt=0, le=1e5)]
Friction = Annotated[float, Unit("N m"), Interval(ge=0, le=1e4)]
Viscous = Annotated[float, Unit("N m s/rad"), Interval(ge=0, le=1e5)]
Inertia = Annotated[float, Unit("kg m^2"), Interval(ge=0, le=1e3)]
Mass = Annotated[float, Unit("kg"), Interval(ge=0, le=1e4)]
Radius = Annotated[float, Unit("m"), Interval(gt=0, le=2)]
Length = Annotated[float, Unit("m"), Interval(ge=-10, le=10)]
Place = tuple[Length, Length, Length]
Moments = tuple[Inertia, Inertia, Inertia]


@dataclass(frozen=True, slots=True)
class ArmDynamics:
    """Masses of the arm's links and limits of its drives, with which torques are foreseen.

    A link that nothing more is said of is a rod with round ends, from its joint to the next one.
    The defaults are those of the simulated arm, before it differs from its drawing.

    Parameters
    ----------
    torque_limits : tuple of float
        Of the drives, at each joint, N m.
    masses : tuple of float
        Shoulder, upper arm, forearm, and the wrist's three, kg.
    radii : tuple of float
        Of the rods, m.
    centres : tuple of tuple of float, optional
        Centre of gravity of each link, from its joint, in its axes, which at zero are the
        base's, m.
    moments : tuple of tuple of float, optional
        With `centres`: moments of inertia of each link about its centre of gravity and its axes,
        kg m².
    rotors : tuple of float
        Inertia of motor and gear, at each joint, kg m².
    friction : tuple of float
        Dry friction of each joint, N m.
    viscous : tuple of float
        Viscous friction of each joint, N m s/rad.

    Raises
    ------
    ValueError
        One of `centres` and `moments` is given without the other.
    """

    torque_limits: tuple[Torque, Torque, Torque, Torque, Torque, Torque] = (
        150.0, 150.0, 100.0, 40.0, 40.0, 30.0,
    )  # fmt: skip
    masses: tuple[Mass, Mass, Mass, Mass, Mass, Mass] = (6.0, 5.0, 3.2, 1.0, 1.0, 0.5)
    radii: tuple[Radius, Radius, Radius, Radius, Radius, Radius] = (
        0.08, 0.05, 0.045, 0.04, 0.04, 0.03,
    )  # fmt: skip
    centres: tuple[Place, Place, Place, Place, Place, Place] | None = None
    moments: tuple[Moments, Moments, Moments, Moments, Moments, Moments] | None = None
    rotors: tuple[Inertia, Inertia, Inertia, Inertia, Inertia, Inertia] = (
        1.2, 1.2, 0.8, 0.2, 0.2, 0.12,
    )  # fmt: skip
    friction: tuple[Friction, Friction, Friction, Friction, Friction, Friction] = (
        8.0, 8.0, 5.0, 1.5, 1.5, 1.0,
    )  # fmt: skip
    viscous: tuple[Viscous, Viscous, Viscous, Viscous, Viscous, Viscous] = (
        10.0, 10.0, 6.0, 2.0, 2.0, 1.2,
    )  # fmt: skip

    def __post_init__(self) -> None:
        if (self.centres is None) != (self.moments is None):
            raise ValueError("centres and moments belong together: give both of them, or neither.")


@dataclass(frozen=True, slots=True)
class Payload:
    """A load in the hand.

    Parameters
    ----------
    mass : float
        What the hand carries, kg.
    centre : tuple of float
        Centre of gravity, from the tool point along the tool's axes, m.
    moments : tuple of float
        Moments of inertia about it and the tool's axes, kg m².
    """

    mass: Mass = 0.0
    centre: Place = (0.0, 0.0, 0.0)
    moments: Moments = (0.0, 0.0, 0.0)
