"""What a profile says of a pair of walking legs."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, Interval, Le, MinLen, Unit

from controllers.gait.correction_settings import SagSettings, StabiliserSettings
from controllers.gait.geometry import Angle, LegGeometry
from controllers.gait.types import BalanceSettings
from rig.hal.rules import Rules
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
    load_cells : tuple of str
        Devices that together have the eight load cells of the soles, four to each:
        ``right_front_left``, ``right_front_right``, ``right_back_left`` and so on.
    cell_inset : float
        Of the cells from the sole's edges, m.
    inertial : str, optional
        The device that measures how the waist leans and turns.
    stabiliser : StabiliserSettings, optional
        How what these feel corrects the planned posture; None: they are only logged.
    sag : SagSettings, optional
        How the servos' sag is compensated; None: not at all. It needs no sensor.
    start_tilt : float, optional
        Greatest angle between the soles, by the encoders, from which a walk begins, rad. None:
        the legs hang, and nothing is known of them.
    fall_tilt : float, optional
        Lean of the waist beyond which the run stops if the feet bear less than half of the weight,
        too: the robot falls, rad. Whatever the lean, one that has stood and bears less than a tenth
        for 0.3 s lies or is lifted. None: neither stops it. It needs load_cells and inertial.
    """

    geometry: LegGeometry = field(default_factory=LegGeometry)
    balance: BalanceSettings = field(default_factory=BalanceSettings)
    jig: JigSettings = field(default_factory=JigSettings)
    load_cells: tuple[str, ...] = ()
    cell_inset: Annotated[float, Unit("m"), Interval(ge=0.0, le=0.02)] = 0.005
    inertial: str | None = None
    stabiliser: StabiliserSettings | None = None
    sag: SagSettings | None = None
    start_tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, le=3.0)] | None = 0.07
    fall_tilt: Annotated[float, Unit("rad"), Interval(ge=0.1, le=3.0)] | None = math.radians(30.0)

    def __post_init__(self) -> None:
        with Rules() as rule:
            if bool(self.load_cells) != (self.inertial is not None):
                rule.broken("load_cells and inertial: balance needs both; give both or none.")
            if self.stabiliser is not None and self.inertial is None:
                rule.broken("stabiliser: it needs load_cells and inertial, and there are none.")
