"""What a profile says of any mechanism whose rods pneumatic cylinders pull."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit

from rig.hal.rising import Rising
from rig.hal.rules import Rules
from rig.mechanisms.pneumatic.alarms.tracking import START
from rig.mechanisms.pneumatic.valves.settings import ValvesSettings

Pressure = Annotated[float, Unit("Pa"), Ge(0)]


@dataclass(frozen=True, slots=True)
class SealFriction:
    """Friction of a pair's seals as the controllers believe it.

    Parameters
    ----------
    coulomb, breakaway : float
        While sliding and when it starts to slide, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        More of it for each speed, N s/m.
    """

    coulomb: Annotated[float, Unit("N"), Ge(0)]
    breakaway: Annotated[float, Unit("N"), Ge(0)]
    stribeck_velocity: Annotated[float, Unit("m/s"), Gt(0)]
    viscous: Annotated[float, Unit("N s/m"), Ge(0)]


@dataclass(frozen=True, slots=True)
class RegulatorModel:
    """Second-order response of the regulators as the controllers believe it.

    Parameters
    ----------
    bandwidth : float
        Natural frequency, rad/s.
    damping : float
        Damping ratio.
    dead_time : float
        Until anything is seen of a setpoint, s: bus, converter, valve, monitor. Alarms allow for
        it.
    spread : float
        How far a healthy regulator's bandwidth may be off, over it: no two are alike, and air
        fills faster than it leaves. Alarms allow for it.
    monitor_time : float
        Time constant of the monitors' filter, s: the part of `dead_time` for which the air does
        not wait. By the regulators' data sheet; 0: it waits for all.
    full_scale : float, optional
        The range of which hysteresis and linearity are shares, Pa; limits of the pressure change
        nothing of it. None: what the regulators can set.
    """

    bandwidth: Annotated[float, Unit("rad/s"), Interval(ge=0.1, le=1e4)] = 40.0
    damping: Annotated[float, Interval(ge=0.05, le=20)] = 1.0
    dead_time: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 5e-3
    spread: Annotated[float, Ge(0), Lt(1)] = 0.15
    monitor_time: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 0.0
    full_scale: Annotated[float, Unit("Pa"), Gt(0)] | None = None

    def __post_init__(self) -> None:
        if self.monitor_time > self.dead_time:
            raise ValueError(
                f"monitor_time ({self.monitor_time:g} s) is a part of dead_time "
                f"({self.dead_time:g} s), and cannot be more."
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class PneumaticLimits:
    """Limits of any such mechanism; each is checked or enforced in every cycle.

    Parameters
    ----------
    speed : float
        Permitted speed of a rod or pair, m/s; above is a fault.
    pressure : tuple of float
        Permitted setpoints, Pa gauge; beyond is clipped.
    pressure_rate : float
        Greatest change of a setpoint, Pa/s; beyond is clipped.
    reading_age : float
        Oldest reading of encoders and regulators that control may use, s; older is a fault.
    following : float
        How far a rod may be from where it should be, m; farther for longer than
        ``alarms.oscillation.lost`` is a fault.
    run_off : float, optional
        How far a rod may be off by its own motion that its pressures do not bring about, m; at once
        a fault. Twice ``following`` without one; a calibration that widens that keeps this.
    stop_energy : float, optional
        What the mechanical stop bears, J. Nothing but a stop holds the mechanism when a wire is
        cut: without one that bears it, hardware is refused. `rig check` says how much it is.
    """

    speed: Annotated[float, Unit("m/s"), Gt(0)]
    pressure: Annotated[tuple[Pressure, Pressure], Rising("pressure")]
    pressure_rate: Annotated[float, Unit("Pa/s"), Gt(0)]
    reading_age: Annotated[float, Unit("s"), Interval(ge=1e-4, le=1.0)]
    following: Annotated[float, Unit("m"), Gt(0)] = 3e-3
    run_off: Annotated[float, Unit("m"), Gt(0)] | None = None
    stop_energy: Annotated[float, Unit("J"), Gt(0), Le(1e4)] | None = None

    @property
    def most_run_off(self) -> float:
        """See `run_off`, m."""
        return 2.0 * self.following if self.run_off is None else self.run_off


@dataclass(frozen=True, slots=True, kw_only=True)
class PneumaticSettings:
    """Cylinders and regulators of any such mechanism.

    Parameters
    ----------
    regulators : str
        The device that sets the chambers' pressures.
    bore, rod, stroke : float
        Cylinder bore, rod diameter and stroke, m.
    home : float
        Rod extension of every cylinder where the mechanism's position is zero, m.
    moving_mass : float
        Mass referred to a pair's position: two pistons and what they move, kg.
    base_pressure : float
        Co-contraction: the mean of the setpoints at home, Pa gauge.
    friction : SealFriction
        Friction as the controllers believe it.
    limits : PneumaticLimits
        What the loop never permits.
    regulator_response : RegulatorModel
        Response of the regulators as the controllers believe it.
    wire_stiffness : float
        Of one wire, N/m.
    dead_volume : float
        Of a chamber with its tube where the rod is fully out, m³: what the air used is told by. E:
        1 cm³ and 1 m of 2.5 mm.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    valves : ValvesSettings, optional
        That the device `regulators` is proportional valves with chamber sensors, and the inner
        loop that makes regulators of them; `regulator_response` is the response that it keeps to.
    """

    regulators: str
    bore: Annotated[float, Unit("m"), Gt(0), Le(0.5)]
    rod: Annotated[float, Unit("m"), Gt(0)]
    stroke: Annotated[float, Unit("m"), Gt(0), Le(5.0)]
    home: Annotated[float, Unit("m"), Gt(0)]
    moving_mass: Annotated[float, Unit("kg"), Interval(ge=1e-4, le=1e3)]
    base_pressure: Pressure
    friction: SealFriction
    limits: PneumaticLimits
    regulator_response: RegulatorModel = field(default_factory=RegulatorModel)
    wire_stiffness: Annotated[float, Unit("N/m"), Gt(0)] = 80e3
    dead_volume: Annotated[float, Unit("m^3"), Ge(0), Le(1e-2)] = 5.9e-6
    emergency_stop: str | None = None
    valves: ValvesSettings | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            if not self.rod < self.bore:
                rule.broken(f"rod ({self.rod:g} m) does not fit into bore ({self.bore:g} m).")
            if not self.home < self.stroke:
                rule.broken(f"home ({self.home:g} m) is not within stroke ({self.stroke:g} m).")
            low, high = self.limits.pressure
            if not low <= self.base_pressure <= high:
                rule.broken(
                    f"base_pressure ({self.base_pressure:g} Pa) is outside limits.pressure "
                    f"{low:g} … {high:g} Pa."
                )
            elif self.base_pressure == low:
                rule.broken(
                    f"base_pressure ({self.base_pressure:g} Pa) is the least of limits.pressure: "
                    "no chamber could give way to its opponent, and at 0 Pa wires hang slack at "
                    f"rest; give more than {low:g} Pa."
                )
            rule.of(self._check_alarms)

    def _check_alarms(self) -> None:
        """Refuse an alarm that nothing could trip: it is switched off by a slip of the pen."""
        if not self.area > 0.0:
            return  # which is said
        # What full pressure in one chamber makes of the mass within the stroke; friction is less.
        work = self.greatest_pressure * self.area * self.stroke
        fastest = math.sqrt(2.0 * work / self.moving_mass)
        check_can_trip("limits.speed", self.limits.speed, fastest, "m/s", "is ever reached")
        check_can_trip("limits.following", self.limits.following, self.stroke, "m", "is the stroke")
        check_can_trip(
            "limits.run_off", self.limits.most_run_off, 2.0 * self.stroke, "m", "is a way"
        )

    @property
    def area(self) -> float:
        """Effective piston area on the rod side, m²."""
        return math.pi / 4 * (self.bore**2 - self.rod**2)

    @property
    def greatest_pressure(self) -> float:
        """The greatest pressure that a chamber is given, Pa gauge."""
        return self.limits.pressure[1]

    @property
    def lowers_pressure(self) -> str:
        """What of the settings makes `greatest_pressure` less, in words."""
        return "limits.pressure"

    @property
    def feeder(self) -> str:
        """What feeds a chamber, in words."""
        return "regulator" if self.valves is None else "valve"

    @property
    def start(self) -> float:
        """How far a rod may go within 10 ms while it should stand, m.

        With valves the sensors sit at the chambers: what leaks shows there, and what moves with it
        unseen was pushed. Vented, a pair that is pushed flies; held, it is brought back.
        """
        return START if self.valves is None else math.inf

    @property
    def full_scale(self) -> float:
        """The range of which a regulator's errors are shares, Pa: not less than the limits'."""
        low, high = self.limits.pressure
        return max(self.regulator_response.full_scale or 0.0, high - low)

    def chambers(self, extensions: Mapping[str, float]) -> dict[str, float]:
        """Return what measures need to know of the chambers, SI.

        Parameters
        ----------
        extensions : mapping of str to float
            Of each channel's rod where its reading is 0, m.
        """
        empty = self.dead_volume + self.area * self.stroke
        volumes = {f"volume_{k}": empty - self.area * out for k, out in extensions.items()}
        return {"area": self.area, **volumes}

    def told(self) -> dict[str, float]:
        """Return what the laws of any such mechanism are told of it, SI."""
        return {
            "area": self.area,
            "mass": self.moving_mass,
            "base_pressure": self.base_pressure,
            "pressure_min": self.limits.pressure[0],
            "pressure_max": self.limits.pressure[1],
            "regulator_bandwidth": self.regulator_response.bandwidth,
            "regulator_damping": self.regulator_response.damping,
            "regulator_dead_time": self.regulator_response.dead_time,
            "regulator_monitor_time": self.regulator_response.monitor_time,
            "coulomb": self.friction.coulomb,
            "breakaway": self.friction.breakaway,
            "stribeck_velocity": self.friction.stribeck_velocity,
            "viscous": self.friction.viscous,
        }


def check_can_trip(name: str, limit: float, most: float, unit: str, why: str) -> None:
    """Refuse an alarm whose limit is no less than what there can be.

    Raises
    ------
    ValueError
        It could never trip.
    """
    if not limit < most:
        raise ValueError(
            f"{name} ({limit:g} {unit}): the alarm could never trip, as no more than {most:.3g} "
            f"{unit} {why}."
        )
