"""What a profile says of one antagonistic pair of cylinders."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Unit

from rig.mechanisms.pneumatic.settings import (
    PneumaticLimits,
    PneumaticSettings,
    SealFriction,
    check_order,
)


@dataclass(frozen=True, slots=True)
class FrictionModel(SealFriction):
    """Friction of the whole pair as the controllers believe it; see `SealFriction`."""

    def __post_init__(self) -> None:
        if self.breakaway < self.coulomb:
            raise ValueError(
                f"breakaway ({self.breakaway:g} N) is below coulomb ({self.coulomb:g} N); "
                "friction at rest is at least that of sliding."
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderLimits(PneumaticLimits):
    """Limits of a pair, beside what `PneumaticLimits` says.

    Parameters
    ----------
    position : tuple of float
        Permitted positions of the pair, m; outside is a fault.
    pair_force : float
        Greatest difference of the two chambers' forces, N; beyond is clipped.
    mismatch : float
        How far the two rods may disagree about the pair's position, m: beyond it a wire is
        slack or broken, or an encoder is wrong.
    """

    position: tuple[Annotated[float, Unit("m")], Annotated[float, Unit("m")]]
    pair_force: Annotated[float, Unit("N"), Gt(0)]
    mismatch: Annotated[float, Unit("m"), Gt(0)]

    def __post_init__(self) -> None:
        check_order("position", self.position)
        PneumaticLimits.__post_init__(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderSettings(PneumaticSettings):
    """One antagonistic pair, beside what `PneumaticSettings` says.

    Parameters
    ----------
    encoder_agonist, encoder_antagonist : str
        The devices that measure the rods.
    friction : FrictionModel
        Of the whole pair.
    limits : CylinderLimits
        What the loop never permits.
    """

    encoder_agonist: str
    encoder_antagonist: str
    friction: FrictionModel
    limits: CylinderLimits

    def __post_init__(self) -> None:
        PneumaticSettings.__post_init__(self)
        reach = min(self.home, self.stroke - self.home)
        lower, upper = self.limits.position
        if max(-lower, upper) > reach:
            raise ValueError(
                f"limits.position {lower:g} … {upper:g} m exceeds what the stroke leaves "
                f"around home, ±{reach:g} m."
            )
