"""What a profile says of a six-joint arm."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, Unit

from controllers.arm.geometry import ArmGeometry
from controllers.arm.places.frames import TaughtFrame
from rig.mechanisms.servo.settings import ServoSettings


@dataclass(frozen=True, slots=True)
class HandMetrology:
    """Measurement of the hand's positions when the arm is calibrated.

    Parameters
    ----------
    accuracy : float
        Standard uncertainty of each coordinate, m.
    marker_accuracy : float
        To which the marker's place on the hand is known, along each axis, m.
    frame : str
        ``base``: the instrument was aligned to the base, and its axes define the zero of q1
        and the height of the base. ``free``: it stands anywhere, and these two are not seen.
    poses : int
        How many are measured for the lengths.
    dwell : float
        How long each one is held, s: as long as it takes to measure it.
    """

    accuracy: Annotated[float, Unit("m"), Gt(0)] = 50e-6
    marker_accuracy: Annotated[float, Unit("m"), Ge(0)] = 20e-6
    frame: Literal["base", "free"] = "base"
    poses: Annotated[int, Interval(ge=10, le=200)] = 24
    dwell: Annotated[float, Unit("s"), Interval(ge=0.5, le=600)] = 1.2


@dataclass(frozen=True, slots=True)
class ArmSettings(ServoSettings):
    """A U-R-S arm: which devices, what geometry, which limits.

    Parameters
    ----------
    servos : tuple of str
        Devices; together they have q1 … q6 once.
    limits : ServoLimits
        What the loop never permits, beside the joint limits of the geometry.
    geometry : ArmGeometry
        Dimensions, joint ranges, rates and accelerations. At zero the arm stands straight up. q1
        turns it about the base's Z; q2 leans it ahead, and q3 the forearm, about the Y of its
        plane; q4 turns about the forearm, q5 leans the tool ahead (`wrist_sign` 1), q6 turns about
        the tool.
    metrology : HandMetrology
        How the hand's positions are measured in a calibration.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    frames : dict of TaughtFrame
        Of fixtures and work pieces, by name: a path's `frame` may be one of them.
    """

    geometry: ArmGeometry = field(default_factory=ArmGeometry)
    metrology: HandMetrology = field(default_factory=HandMetrology)
    frames: dict[str, TaughtFrame] = field(default_factory=dict)
