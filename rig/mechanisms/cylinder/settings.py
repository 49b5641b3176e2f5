"""What a profile says of one antagonistic pair of cylinders."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, Unit

from rig.hal.rising import Rising
from rig.hal.rules import Rules
from rig.mechanisms.pneumatic.alarms.bounds import check_pressure_alarm
from rig.mechanisms.pneumatic.alarms.settings import (
    FrozenAlarm,
    OscillationAlarm,
    PressureAlarm,
    SwappedAlarm,
)
from rig.mechanisms.pneumatic.settings import (
    PneumaticLimits,
    PneumaticSettings,
    SealFriction,
    check_can_trip,
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

    position: Annotated[tuple[float, float], Unit("m"), Rising("position")]
    pair_force: Annotated[float, Unit("N"), Gt(0)]
    mismatch: Annotated[float, Unit("m"), Gt(0)]


@dataclass(frozen=True, slots=True)
class RodsAlarm:
    """The two rods no longer agree about the pair's position as they did when it was energised.

    Parameters
    ----------
    change : float, optional
        Permitted change, m. None: what may be without a fault, three parts that add up. A seal
        that sticks on either side stretches the wires by the breakaway force over their stiffness.
        The two encoders' scales are 1 % off against each other over half of the permitted
        positions. The wires' stretch at base pressure is known to 30 %.
    """

    change: Annotated[float, Unit("m"), Gt(0)] | None = None


@dataclass(frozen=True, slots=True)
class PairAlarmSettings:
    """Alarms of a pair beside its limits.

    Parameters
    ----------
    pressure : PressureAlarm
        A regulator stuck or slow, its tube or its monitor off, the supply lost.
    frozen : FrozenAlarm
        An encoder frozen, a rod jammed.
    swapped : SwappedAlarm
        The encoders swapped, or the tubes.
    rods : RodsAlarm
        An encoder that drifts, is mirrored or has a wrong scale; a wire slack.
    oscillation : OscillationAlarm
        A loop that is not stable on this rig.
    """

    pressure: PressureAlarm = field(default_factory=PressureAlarm)
    frozen: FrozenAlarm = field(default_factory=FrozenAlarm)
    swapped: SwappedAlarm = field(default_factory=SwappedAlarm)
    rods: RodsAlarm = field(default_factory=RodsAlarm)
    oscillation: OscillationAlarm = field(default_factory=OscillationAlarm)


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
    alarms : PairAlarmSettings
        What tells that something is broken, and how soon.
    """

    encoder_agonist: str
    encoder_antagonist: str
    friction: FrictionModel
    limits: CylinderLimits
    alarms: PairAlarmSettings = field(default_factory=PairAlarmSettings)

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(PneumaticSettings.__post_init__, self)
            if self.encoder_agonist == self.encoder_antagonist:
                rule.broken(
                    f"encoder_agonist, encoder_antagonist: {self.encoder_agonist} is named for "
                    "both rods."
                )
            reach = min(self.home, self.stroke - self.home)
            lower, upper = self.limits.position
            if max(-lower, upper) > reach:
                rule.broken(
                    f"limits.position {lower:g} … {upper:g} m exceeds what the stroke leaves "
                    f"around home, ±{reach:g} m."
                )
            for name, limit in (
                ("limits.mismatch", self.limits.mismatch),
                ("alarms.rods.change", self.most_disagreement),
                ("alarms.frozen.distance", self.alarms.frozen.distance),
                ("alarms.swapped.distance", self.alarms.swapped.distance),
                ("alarms.oscillation.amplitude", self.alarms.oscillation.amplitude),
            ):
                rule.of(check_can_trip, name, limit, self.stroke, "m", "is the stroke")
            rule.of(check_pressure_alarm, self.alarms.pressure, self)

    @property
    def most_disagreement(self) -> float:
        """How far the rods' agreement may change, m; see `RodsAlarm`."""
        if self.alarms.rods.change is not None:
            return self.alarms.rods.change
        lower, upper = self.limits.position
        sticking = self.friction.breakaway / self.wire_stiffness
        stretch = self.area * self.base_pressure / self.wire_stiffness
        return sticking + 0.01 * 0.5 * (upper - lower) + 0.3 * stretch

    @property
    def greatest_pressure(self) -> float:
        """The greatest pressure that a chamber is given, Pa gauge: ``limits.pair_force`` clips it.

        The laws keep the mean of both chambers at the base pressure.
        """
        clipped = self.base_pressure + 0.5 * self.limits.pair_force / self.area
        return min(clipped, self.limits.pressure[1])

    @property
    def lowers_pressure(self) -> str:
        """See `PneumaticSettings.lowers_pressure`."""
        if self.greatest_pressure == self.limits.pressure[1]:
            return "limits.pressure"
        return "base_pressure or limits.pair_force"
