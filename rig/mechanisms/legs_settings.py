"""What a profile says of a pair of walking legs."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import MinLen

from controllers.gait.geometry import LegGeometry
from controllers.gait.types import BalanceSettings
from rig.mechanisms.servo_settings import ServoLimits


@dataclass(frozen=True, slots=True)
class LegsSettings:
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
    """

    servos: Annotated[tuple[str, ...], MinLen(1)]
    limits: ServoLimits
    geometry: LegGeometry = field(default_factory=LegGeometry)
    balance: BalanceSettings = field(default_factory=BalanceSettings)
    emergency_stop: str | None = None
