"""The part of the loop's view that all mechanisms with pneumatic cylinders have in common."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, TypeVar, cast

from rig.hal import (
    DeviceFault,
    EmergencyStop,
    EmergencyStopInput,
    LinearEncoder,
    LoopStalled,
    PressureRegulator,
    SafetyError,
    StaleReading,
)
from rig.hal.mechanism import Command, Mechanism, Reference, State
from rig.hal.quantities import Expected
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.alarms.vented import explain_left
from rig.mechanisms.pneumatic.cut_wire import expect_cut_wire, refuse_weak_stop
from rig.mechanisms.pneumatic.devices import check_pneumatics, settable
from rig.mechanisms.pneumatic.pull import expect_pull
from rig.mechanisms.pneumatic.settings import PneumaticLimits, PneumaticSettings
from rig.mechanisms.stop_contact import StopContact
from rig.runtime.limits import VectorLimiter

_EMPTIES = 6.0
"""Time constants of a regulator or an exhaust after which any chamber is empty."""
_GUESSED = 0.33
"""Spread of a regulator's bandwidth that nobody has measured: the least factor of `UNKNOWNS`, 0.67.
E: it falls with the chamber's volume, which no catalogue knows."""
_LEFT_TO_SEALS = 0.5
"""Share of the seals' friction that chambers may differ by while they are vented together."""
_SLOWEST_RELEASE = 3.0
"""Longer than this nobody waits for a rig that was told to stop, s."""

Chosen = TypeVar("Chosen", bound=PneumaticSettings)


class PneumaticMechanism(Mechanism[Chosen, State, Reference, Command]):
    """A mechanism that pneumatic cylinders move.

    Parameters
    ----------
    settings : PneumaticSettings
        Geometry and limits.
    regulators : PressureRegulator
        Of all chambers, in the order of `channels`.
    encoders : sequence of LinearEncoder
        One to each rod.
    emergency_stop : EmergencyStopInput, optional
        The device that reads the emergency-stop contact.
    period : float
        The loop's period, s.

    Raises
    ------
    ConfigurationError
        The devices have other channels, or ranges that do not hold the limits.
    """

    whose: ClassVar[str]
    """The mechanism, as a message names it: ``"the joint"``."""

    channels: ClassVar[tuple[str, ...]]
    """Its chambers."""

    varies_with: ClassVar = dict.fromkeys(
        ("bore", "rod"), ("friction", "moving_mass", "base_pressure")
    )
    # Not the base pressure: experiments set it as they please.
    dimensions: ClassVar = ("bore", "rod", "stroke", "home", "moving_mass", "geometry")
    believed: ClassVar = ("friction", "regulator_response", "wire_stiffness", "valves")

    def __init__(
        self,
        settings: Chosen,
        regulators: PressureRegulator,
        encoders: Sequence[LinearEncoder],
        emergency_stop: EmergencyStopInput | None,
        period: float,
    ) -> None:
        limits = settings.limits
        check_pneumatics(
            self.whose, self.channels, limits.pressure, settings.stroke, regulators, encoders
        )
        self.settings = settings = _scaled(settings, regulators)
        self._regulators = regulators
        self._stop_contact = StopContact(emergency_stop, limits.reading_age)
        self._limiter = VectorLimiter(
            "pressure", *settable(limits.pressure, regulators), limits.pressure_rate, period, "Pa"
        )
        self._age = 0.0
        self.venting_time = _venting_time(settings)
        self._pressure_watch: PressureWatch
        self._released_at: Sequence[float] | None = None

    @classmethod
    def limits_of(cls, settings: Chosen) -> PneumaticLimits:
        """Return the limits that `rig check` shows."""
        return settings.limits

    @classmethod
    def derated(cls, settings: Chosen, effort: float, speed: float) -> Chosen:
        """Return the settings with a share of the pressures; see `Mechanism.derated`.

        Whoever follows slower references is slower.
        """
        limits = settings.limits
        low, high = limits.pressure
        pressure = low, effort * high
        # Pairs pull by what their two pressures are apart from the base, to either side: of a base
        # near the lower top nothing is left to move against the friction that it causes.
        base = min(settings.base_pressure, 0.5 * (low + effort * high))
        # The regulators are the same ones, with the same hysteresis, and nobody has measured how
        # quick they are: calibrations come after the acceptance test.
        response = settings.regulator_response
        response = replace(
            response, full_scale=settings.full_scale, spread=max(response.spread, _GUESSED)
        )
        limits = replace(limits, pressure=pressure)
        return replace(settings, limits=limits, base_pressure=base, regulator_response=response)

    @classmethod
    def expected_of(cls, settings: Chosen) -> tuple[Expected, ...]:
        """Return what a cut wire comes to, and a pair's pull; see `Mechanism.expected_of`."""
        cut = expect_cut_wire(settings, len(cls.channels), settings.greatest_pressure)
        return (*cut, expect_pull(settings))

    def in_force(self, settings: Chosen) -> Chosen:
        """Return settings with the regulators' full scale; see `Mechanism.in_force`."""
        return _scaled(settings, self._regulators)

    @classmethod
    def unfit(cls, settings: Chosen) -> str | None:
        """Say that the declared mechanical stop does not bear a cut wire; see `Mechanism.unfit`."""
        return refuse_weak_stop(settings, len(cls.channels), settings.greatest_pressure)

    def releasing_time(self, balanced: Command) -> float:
        """Return how long chambers take to be vented together, s; see `Mechanism.releasing_time`.

        No two regulators are equally quick. Their lag behind the setpoints is what their chambers
        may differ by: half of it is left to the friction that holds a pair where it is.
        """
        settings = self.settings
        response = settings.regulator_response
        lag = response.dead_time + 2.0 * response.damping / response.bandwidth
        held = _LEFT_TO_SEALS * settings.friction.coulomb / settings.area
        fullest = max(cast("Sequence[float]", balanced))
        return min(lag * fullest / held, _SLOWEST_RELEASE) if held else _SLOWEST_RELEASE

    @abstractmethod
    def places_of(self, state: State) -> Sequence[float]:
        """Return where its rods or pairs are, m."""

    def strays(self, state: State) -> bool:
        """Return whether a pair moves off as its chambers are vented together; see `Standing`.

        A chamber that leaks, or is stuck, leaves the other one alone.
        """
        places = self.places_of(state)
        if self._released_at is None:
            self._released_at = places
        most = self.settings.limits.following
        ways = (abs(now - then) for now, then in zip(places, self._released_at, strict=True))
        return any(way > most for way in ways)

    def stop_input(self) -> EmergencyStopInput | None:
        """Return the device that reads the emergency stop; see `Mechanism.stop_input`."""
        return self._stop_contact.device

    def unsafe(self, now: float) -> str:
        """Return which chamber's monitor hides what is left in it; see `Standing.unsafe`."""
        regulators = self._regulators
        shown, safe = regulators.pressure().value, regulators.safe_pressure()
        return explain_left(self._pressure_watch, shown, safe, now)

    def is_pneumatic(self, fault: Exception) -> bool:
        """Return whether a fault is one of cylinders and regulators, so that a log may explain it.

        What stops a rig from outside, or what another device says of itself, needs no cause.
        """
        if isinstance(fault, DeviceFault):
            return fault.device == self._regulators.name
        outside = isinstance(fault, EmergencyStop | StaleReading | LoopStalled)
        return isinstance(fault, SafetyError) and not outside

    def limit_hits(self) -> dict[str, int]:
        """Return how often each limit was hit since the start."""
        return {
            "pressure range": self._limiter.range_hits,
            "pressure rate": self._limiter.rate_hits,
        }


def _venting_time(settings: PneumaticSettings) -> float:
    """Return how long the fullest chamber takes to empty, s: by its regulator or its valve."""
    response = settings.regulator_response
    times = [response.dead_time + _EMPTIES / response.bandwidth]
    if settings.valves is not None:
        volume = settings.dead_volume + settings.area * settings.stroke
        times += [_EMPTIES / settings.valves.slowest_exhaust(volume)]
    return max(times)


def _scaled(settings: Chosen, regulators: PressureRegulator) -> Chosen:
    """Return settings whose regulators' full scale is said: by the profile, else by the device."""
    response = settings.regulator_response
    if response.full_scale is not None:
        return settings
    low, high = regulators.pressure_range
    return replace(settings, regulator_response=replace(response, full_scale=high - low))
