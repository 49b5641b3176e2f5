"""What a profile says of a six-joint arm."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import MinLen

from controllers.arm.geometry import ArmGeometry
from rig.mechanisms.servo_settings import ServoLimits


@dataclass(frozen=True, slots=True)
class ArmSettings:
    """A U-R-S arm: which devices, what geometry, which limits.

    Parameters
    ----------
    servos : tuple of str
        Devices; together they have q1 … q6 once.
    limits : ServoLimits
        What the loop never permits, beside the joint limits of the geometry.
    geometry : ArmGeometry
        Dimensions, joint ranges, rates and accelerations.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    """

    servos: Annotated[tuple[str, ...], MinLen(1)]
    limits: ServoLimits
    geometry: ArmGeometry = field(default_factory=ArmGeometry)
    emergency_stop: str | None = None
