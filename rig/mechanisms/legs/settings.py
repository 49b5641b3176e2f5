"""What a profile says of a pair of walking legs."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, Interval, Le, MinLen, Unit

from controllers.gait.geometry import Angle, LegGeometry
from controllers.gait.types import BalanceSettings
from rig.mechanisms.servo.settings import ServoSettings

SixAngles = tuple[Angle, Angle, Angle, Angle, Angle, Angle]


def _jig_poses() -> dict[str, SixAngles]:
    degrees = {
        "straight": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        "crouched": (45.0, 20.0, -60.0, 100.0, -40.0, -15.0),
        "splayed": (-20.0, -15.0, 45.0, 50.0, 40.0, 15.0),
    }
    return {name: tuple(map(math.radians, pose)) for name, pose in degrees.items()}  # type: ignore[misc]


@dataclass(frozen=True, slots=True)
class JigSettings:
    """The jig that holds both legs at known angles while they are calibrated.

    Parameters
    ----------
    poses : dict of str to tuple of float
        Angles of the left leg's six joints in each, rad; the right leg's are mirrored. Zeros
        are read in the first one, scales from all of them.
    tolerance : float
        Standard uncertainty of an angle in it, rad.
    dwell : float
        How long each pose is read, s.
    """

    poses: Annotated[dict[str, SixAngles], MinLen(2)] = field(default_factory=_jig_poses)
    tolerance: Annotated[float, Unit("rad"), Gt(0), Le(0.2)] = math.radians(0.1)
    dwell: Annotated[float, Unit("s"), Interval(ge=0.3, le=60)] = 1.0


@dataclass(frozen=True, slots=True)
class LegsSettings(ServoSettings):
    """Two legs of six joints each: which devices, what geometry, which limits.

    Parameters
    ----------
    servos : tuple of str
        Devices; together they have all twelve joints once.
    limits : ServoLimits
        What the loop never permits, beside the joint limits of the geometry.
    geometry : LegGeometry
        Dimensions, joint limits and masses.
    balance : BalanceSettings
        The margin below which a plan is refused.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    jig : JigSettings
        What holds the legs in a calibration.
    """

    geometry: LegGeometry = field(default_factory=LegGeometry)
    balance: BalanceSettings = field(default_factory=BalanceSettings)
    jig: JigSettings = field(default_factory=JigSettings)
