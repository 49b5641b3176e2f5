"""The values that pass through the loop of the legs."""

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from annotated_types import Gt, Unit

from controllers.gait.correction_settings import SagSettings, StabiliserSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.sensing import Sensing

Joints = tuple[float, ...]
"""One value per joint, in the order of `controllers.gait.geometry.AXIS_NAMES`."""


class LegsState(NamedTuple):
    """Measurements of the legs in one cycle.

    Parameters
    ----------
    t : float
        Time of the cycle, s.
    positions, velocities : tuple of float
        Of the twelve joints, rad and rad/s.
    sensing : Sensing, optional
        What feet and waist feel; None: the legs have no such sensors.
    """

    t: float
    positions: Joints
    velocities: Joints
    sensing: Sensing | None = None


class LegsReference(NamedTuple):
    """The wanted motion of the legs in one cycle.

    Parameters
    ----------
    positions, velocities : tuple of float
        Of the twelve joints, rad and rad/s: the posture to approach, or the plan's sample.
    follow : bool
        Whether the prepared motion runs: a law then takes the next step of it.
    """

    positions: Joints
    velocities: Joints
    follow: bool


class LegsCommand(NamedTuple):
    """Positions of the joints at the end of this period, and their rates on the way.

    Parameters
    ----------
    positions : tuple of float
        rad.
    velocities : tuple of float
        Mean over the period, rad/s.
    """

    positions: Joints
    velocities: Joints


@dataclass(frozen=True, slots=True)
class BalanceSettings:
    """Bounds of balance.

    Parameters
    ----------
    min_margin : float
        Least distance of the centre of mass and of the zero-moment point from the edge of what
        the feet stand on, m.
    response_time : float
        Over which accelerations are averaged, s. On its servos' compliance the robot rocks at
        some 20 rad/s; a jump of the commanded rates reaches the ground no faster. In simulation
        this tells walks that fall from those that do not.
    """

    min_margin: Annotated[float, Unit("m"), Gt(0)] = 0.005
    response_time: Annotated[float, Unit("s"), Gt(0)] = 0.1


@dataclass(frozen=True, slots=True)
class GaitModel:
    """The robot's geometry and the bounds of its balance, which its laws compute with.

    Parameters
    ----------
    geometry : LegGeometry
        Of both legs.
    balance : BalanceSettings
        The bound below which a plan is refused.
    stabiliser : StabiliserSettings, optional
        How what is felt corrects the plan; None: not at all.
    sag : SagSettings, optional
        How the servos' sag is compensated; None: not at all.
    """

    geometry: LegGeometry = field(default_factory=LegGeometry)
    balance: BalanceSettings = field(default_factory=BalanceSettings)
    stabiliser: StabiliserSettings | None = None
    sag: SagSettings | None = None
