"""One antagonistic pair: two cylinders that pull one carriage against each other."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from controllers.cylinder.law import PairLaw
from controllers.cylinder.types import PairCommand, PairModel, PairReference, PairState
from controllers.minimum_jerk import minimum_jerk
from rig.hal import (
    Controller,
    Device,
    EmergencyStopInput,
    LimitExceeded,
    LinearEncoder,
    PressureRegulator,
    SafetyError,
    StaleReading,
)
from rig.hal.closed_loop import ClosedLoop
from rig.hal.columns import Column
from rig.hal.hindsight import Suspect
from rig.hal.motion import Motion, Note
from rig.hal.picking import DevicePicker
from rig.hal.quantities import Expected, Margin
from rig.mechanisms.cylinder.jumps import check_jump
from rig.mechanisms.cylinder.references import PairMotion
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.cylinder.targets import PairTargets
from rig.mechanisms.cylinder.watch import CHANNELS, PairWatch
from rig.mechanisms.pneumatic.alarms.bounds import derive_bounds, expect_bounds
from rig.mechanisms.pneumatic.alarms.tracking import Gone, TrackingWatch
from rig.mechanisms.pneumatic.devices import check_asked_pressures
from rig.mechanisms.pneumatic.loop import loop_of
from rig.mechanisms.pneumatic.mechanism import PneumaticMechanism
from rig.mechanisms.pneumatic.reported import check_measured
from rig.mechanisms.pneumatic.valves.regulating import as_regulators, regulating_kind

if TYPE_CHECKING:
    from rig.hal.hindsight import Logged

_BETWEEN = 7
"""Of so many cycles of a reference one is looked at between them, too …"""
_SHARE = 0.382
"""… after this share of the period, which divides none."""
_STILL = 0.1
"""While its chambers fill, a pair may move by this share of its range at most."""

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class EstimatingPairController(Controller[PairReference, PairState, PairCommand], Protocol):
    """A controller that shows what it believes: velocity (m/s) and disturbance (N)."""

    @property
    def estimate(self) -> tuple[float, float]:
        """Velocity of the pair, m/s, and disturbance force on it, N."""


class AntagonisticPair(PneumaticMechanism[CylinderSettings, PairState, PairReference, PairCommand]):
    """The loop's view of one antagonistic pair; parameters are those of `PneumaticMechanism`."""

    Settings = CylinderSettings
    whose = "an antagonistic pair"
    channels = CHANNELS
    law = EstimatingPairController

    # The reference comes first, where the loop's own column of that group ends: a log whose groups
    # stand together already needs no rearranging.
    columns = (
        Column("reference.position", "m", "desired position"),
        Column("reference.velocity", "m/s", "desired velocity"),
        Column("reference.acceleration", "m/s^2", "desired acceleration"),
        Column("reading.position", "m", "position of the pair, mean of both rods"),
        Column("reading.position_agonist", "m", "extension of the agonist's rod"),
        Column("reading.position_antagonist", "m", "extension of the antagonist's rod"),
        Column("reading.pressure_agonist", "Pa", "monitored chamber pressure, gauge"),
        Column("reading.pressure_antagonist", "Pa", "monitored chamber pressure, gauge"),
        Column("reading.age", "s", "age of the oldest reading when it was used"),
        Column("estimate.velocity", "m/s", "velocity as the controller estimates it"),
        Column("estimate.disturbance", "N", "disturbance as the controller estimates it"),
        Column("command.agonist", "Pa", "setpoint that the controller wants, gauge"),
        Column("command.antagonist", "Pa", "setpoint that the controller wants, gauge"),
        Column("applied.agonist", "Pa", "setpoint that was sent, gauge"),
        Column("applied.antagonist", "Pa", "setpoint that was sent, gauge"),
    )

    def __init__(
        self,
        settings: CylinderSettings,
        *,
        regulators: PressureRegulator,
        encoder_agonist: LinearEncoder,
        encoder_antagonist: LinearEncoder,
        emergency_stop: EmergencyStopInput | None,
        period: float,
    ) -> None:
        encoders = (encoder_agonist, encoder_antagonist)
        super().__init__(settings, regulators, encoders, emergency_stop, period)
        self.controller: EstimatingPairController | None = None
        self._encoder_agonist = encoder_agonist
        self._encoder_antagonist = encoder_antagonist
        self._limits = limits = settings.limits
        # What every cycle looks at, at hand.
        self._lower, self._upper = limits.position
        self._oldest_reading = limits.reading_age
        self._position_agonist = encoder_agonist.position
        self._position_antagonist = encoder_antagonist.position
        self._pressure = regulators.pressure
        self._max_difference = limits.pair_force / settings.area
        self._force_hits = 0
        self._extensions = (settings.home, settings.home)
        self._position = self._now = 0.0
        watched = settings.alarms.oscillation, settings.start, limits.most_run_off
        self._tracking = TrackingWatch(("the pair",), limits.following, *watched)
        self._watch = PairWatch(self.settings, regulators.name, [one.name for one in encoders])
        self._pressure_watch = self._watch.pressures

    @classmethod
    def expected_of(cls, settings: CylinderSettings) -> tuple[Expected, ...]:
        """Return what a cut wire comes to, and from where on pressures are an alarm."""
        bounds = derive_bounds(settings.alarms.pressure, settings)
        return (*super().expected_of(settings), *expect_bounds(bounds))

    @classmethod
    def constants_of(cls, settings: CylinderSettings) -> dict[str, float]:
        """Return piston area, m², and the chambers' volumes where their rods read 0, m³."""
        return settings.chambers(dict.fromkeys(CHANNELS, 0.0))

    @classmethod
    def closed_loop(cls, settings: CylinderSettings, controller: object) -> ClosedLoop | None:
        """Return the margins of a law of ours; see `Mechanism.closed_loop`."""
        return loop_of(controller) if isinstance(controller, PairLaw) else None

    @classmethod
    def assemble(
        cls, settings: CylinderSettings, devices: Mapping[str, Device], period: float
    ) -> "AntagonisticPair":
        """Pick the devices that the settings name; see `Mechanism.assemble`."""
        with DevicePicker("cylinder", devices) as pick:
            feed = pick("regulators", settings.regulators, regulating_kind(settings))
            agonist = pick("encoder_agonist", settings.encoder_agonist, LinearEncoder)
            antagonist = pick("encoder_antagonist", settings.encoder_antagonist, LinearEncoder)
            stop = pick.if_named("emergency_stop", settings.emergency_stop, EmergencyStopInput)
        regulators = as_regulators(feed, (agonist, antagonist), settings, period)
        return cls(
            settings,
            regulators=regulators,
            encoder_agonist=agonist,
            encoder_antagonist=antagonist,
            emergency_stop=stop,
            period=period,
        )

    @classmethod
    def wiring(cls, settings: CylinderSettings) -> dict[str, str]:
        """Return which channel of the plant each single-channel device measures."""
        return {
            settings.encoder_agonist: "agonist",
            settings.encoder_antagonist: "antagonist",
        }

    @classmethod
    def model_of(cls, settings: CylinderSettings) -> PairModel:
        """Return what the controllers are told of a pair."""
        return PairModel(**settings.told())

    @classmethod
    def plan(
        cls, settings: CylinderSettings, reference: object, controller: Any, period: float
    ) -> Motion[PairReference]:
        """Return the reference itself, if it keeps positions and speed, and can be followed."""
        if not isinstance(reference, PairMotion):
            raise ValueError("the reference is not one for a pair of cylinders")
        motion, limits = reference, settings.limits
        (lower, upper), fastest, before = limits.position, limits.speed, math.nan
        for tick in range(int(motion.duration / period) + 1):
            position, velocity, _ = motion.at(t := tick * period)
            if not lower <= position <= upper:
                raise ValueError(
                    f"after {t:.3g} s the reference is at {position * 1e3:.4g} mm, outside "
                    f"limits.position, {lower * 1e3:.4g} … {upper * 1e3:.4g} mm"
                )
            jump, before = position - before - period * velocity, position
            if tick % _BETWEEN == 0:  # a sine of the loop's rate seems to stand in every cycle
                velocity = max(velocity, motion.at(t + _SHARE * period).velocity, key=abs)
            if abs(velocity) > fastest:
                raise ValueError(
                    f"after {t:.3g} s the reference moves at {velocity:.3g} m/s, faster than "
                    f"limits.speed, {fastest:g} m/s"
                )
            if abs(jump) > limits.following and isinstance(controller, PairLaw):
                lost = settings.alarms.oscillation.lost
                check_jump(controller, t, jump, limits.following, limits.pair_force, lost)
        check_measured(motion.segments, period)
        return motion

    @classmethod
    def approach(
        cls, start: PairReference, end: PairReference, duration: float, t: float
    ) -> PairReference:
        """Return the minimum-jerk motion between two positions at `t`."""
        return PairReference(*minimum_jerk(start.position, end.position, duration, t))

    @classmethod
    def slow_down(cls, reference: PairReference, rate: float, change: float) -> PairReference:
        """Return the reference as it is passed more slowly; see `Mechanism.slow_down`."""
        position, velocity, acceleration = reference
        slowed = rate * rate * acceleration + change * velocity
        return PairReference(position, rate * velocity, slowed)

    @classmethod
    def pace_between(cls, before: PairReference, after: PairReference, time: float) -> float:
        """Return the speed, m/s."""
        return abs(after.position - before.position) / time

    @classmethod
    def targets(cls, settings: CylinderSettings, controller: object) -> PairTargets:
        """Return where the pair may be sent by a number."""
        return PairTargets(settings.limits)

    def attach(self, controller: EstimatingPairController, motion: Motion[PairReference]) -> None:
        """Take the controller whose estimate is logged."""
        self.controller = controller

    def read(self, now: float) -> PairState:
        """Assemble the pair's state; see `Mechanism.read`."""
        (agonist,), t_agonist = self._position_agonist()
        (antagonist,), t_antagonist = self._position_antagonist()
        (p_agonist, p_antagonist), t_pressure = self._pressure()
        device: Device = self._encoder_agonist
        oldest = t_agonist
        if t_antagonist < oldest:
            oldest, device = t_antagonist, self._encoder_antagonist
        if t_pressure < oldest:
            oldest, device = t_pressure, self._regulators
        self._age = age = now - oldest
        if age > self._oldest_reading:
            raise StaleReading(device.name, age, self._oldest_reading)
        self._extensions = (agonist, antagonist)
        return _new(PairState, (now, 0.5 * (antagonist - agonist), p_agonist, p_antagonist))

    def recall(self, logged: Mapping[str, float]) -> PairState:
        """Assemble the pair's state from the log; see `Mechanism.recall`."""
        self._stop_contact.ignore()
        self._age = logged["reading.age"]
        self._extensions = (
            logged["reading.position_agonist"],
            logged["reading.position_antagonist"],
        )
        return PairState(
            logged["clock"],
            logged["reading.position"],
            logged["reading.pressure_agonist"],
            logged["reading.pressure_antagonist"],
        )

    def places_of(self, state: PairState) -> tuple[float]:
        """Return the pair's position, m."""
        return (state.position,)

    def check(self, state: PairState, now: float) -> None:
        """Raise if the state is not safe; see `Mechanism.check`."""
        self._stop_contact.check(now)
        _, position, p_agonist, p_antagonist = state
        if not math.isfinite(position + p_agonist + p_antagonist):
            raise SafetyError(f"a reading is not a number: {state}")
        if not self._lower <= position <= self._upper:
            raise Gone("position of the pair", position, self._lower, self._upper, "m")
        self._position, self._now = position, now
        self._watch.check(state, self._extensions, now)

    def explain(self, error: Exception, state: PairState) -> Exception:
        """Return a fault with the cause that the rest of the pair shows; see `Mechanism`."""
        found = self._watch.explain(error)
        if isinstance(error, LimitExceeded) and (swing := self._tracking.suspicion(self._now)):
            return SafetyError(f"{swing} ({error})" if found is error else f"{swing}; or {found}")
        return found

    def diagnose(self, fault: Exception, logged: "Logged") -> tuple[Suspect, ...]:
        """Return what explains the end of a log best; see `Mechanism.diagnose`."""
        if not self.is_pneumatic(fault):
            return ()
        from rig.mechanisms.cylinder.hindsight import pair_suspects

        return pair_suspects(logged, self.settings)

    def remarks(self, logged: "Logged") -> tuple[Note, ...]:
        """Return that the pair never rests, or sticks and slips; see `Mechanism.remarks`."""
        from rig.mechanisms.pneumatic.hunting import remarks_on_hunting

        columns = "reference.position", "reading.position"
        return (*remarks_on_hunting(logged, {"the pair": columns}), *self._tracking.remarks())

    def resting_command(self, state: PairState) -> PairCommand:
        """Return the measured pressures, within the permitted range."""
        lower, upper = self._limits.pressure
        return PairCommand(
            min(max(state.agonist, lower), upper), min(max(state.antagonist, lower), upper)
        )

    def energised_command(self, state: PairState) -> PairCommand:
        """Return the base pressure in both chambers: forces balance, nothing moves."""
        return PairCommand(self.settings.base_pressure, self.settings.base_pressure)

    def balanced_command(self, state: PairState) -> PairCommand:
        """Return the mean of the measured pressures in both chambers: their forces cancel."""
        lower, upper = self._limits.pressure
        mean = min(max(0.5 * (state.agonist + state.antagonist), lower), upper)
        return PairCommand(mean, mean)

    def released_command(self) -> PairCommand:
        """Return both chambers vented but for one that the profile has hold its pressure."""
        return PairCommand(*self._regulators.safe_pressure())

    def blend(self, start: PairCommand, end: PairCommand, share: float) -> PairCommand:
        """Return the command `share` of the way from `start` to `end`."""
        return PairCommand(
            start.agonist + share * (end.agonist - start.agonist),
            start.antagonist + share * (end.antagonist - start.antagonist),
        )

    def start_limiting(self, state: PairState) -> None:
        """Start the rate limit from the measured pressures."""
        self._limiter.reset((state.agonist, state.antagonist))
        self._watch.restart()
        self._tracking.restart()

    def check_command(self, reference: PairReference, command: PairCommand) -> None:
        """See `Mechanism.check_command`; the reference says nothing of pressures."""
        check_asked_pressures(CHANNELS, command, self._limits.pressure[1])
        self._tracking.check(
            (reference.position,), (self._position,), self._now,
            self._watch.explain_held, self._watch.drives,
        )  # fmt: skip

    def check_still(self, home: PairReference) -> None:
        """See `Mechanism.check_still`."""
        most = _STILL * (self._upper - self._lower)
        self._tracking.check_still((home.position,), (self._position,), self._now, most)

    def limit(self, command: PairCommand) -> PairCommand:
        """Return the command that may be applied: pair force, range and rate."""
        agonist, antagonist = command
        difference = agonist - antagonist
        if abs(difference) > self._max_difference:
            self._force_hits += 1
            mean = 0.5 * (agonist + antagonist)
            half = math.copysign(0.5 * self._max_difference, difference)
            agonist, antagonist = mean + half, mean - half
        return _new(PairCommand, self._limiter.limit((agonist, antagonist)))

    def write(self, applied: PairCommand) -> None:
        """Hand the setpoints to the regulators."""
        self._regulators.set_pressure(applied)
        self._watch.send(applied)

    def row(
        self,
        state: PairState,
        reference: PairReference,
        command: PairCommand,
        applied: PairCommand,
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        estimate = self.controller.estimate if self.controller is not None else (0.0, 0.0)
        _, position, p_agonist, p_antagonist = state
        return (
            *reference,
            position,
            *self._extensions,
            p_agonist,
            p_antagonist,
            self._age,
            *estimate,
            *command,
            *applied,
        )

    def reference_of(self, state: PairState) -> PairReference:
        """Return the reference to stay where the pair is."""
        return PairReference(state.position, 0.0, 0.0)

    def worst_margin(self, state: PairState, applied: PairCommand, now: float) -> Margin:
        """Return the quantity that is nearest to its limit."""
        limits = self._limits
        lower, upper = limits.position
        middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
        mismatch = 0.5 * sum(self._extensions) - self.settings.home
        return min(
            Margin("position", 1.0 - abs(state.position - middle) / half),
            Margin("reading age", 1.0 - self._age / limits.reading_age),
            Margin("pressure", 1.0 - max(applied) / limits.pressure[1]),
            Margin("rod mismatch", 1.0 - abs(mismatch) / limits.mismatch),
            key=lambda margin: margin.fraction,
        )

    def limit_hits(self) -> dict[str, int]:
        """Return how often each limit was hit since the start."""
        return {**super().limit_hits(), "pair force": self._force_hits}
