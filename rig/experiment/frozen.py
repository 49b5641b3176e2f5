"""What becomes of a rig whose setpoints stay as they are, because its program has died.

The motion is gone through on the profile's plant. From its instants, the plant goes on with the
setpoints of then for some time, is vented, and has to stay within its limits: so comes the longest
time after which its devices must act by themselves.
"""

import copy
import dataclasses
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, NamedTuple, cast

from rig.assembly import REGISTRY
from rig.experiment.excerpts import WHOLE, Excerpts, fastest
from rig.experiment.plan import Plan
from rig.experiment.slowest import slowest_device
from rig.hal import DeviceError, Freeze, RestorablePlant
from rig.hal.hazards import Hazard
from rig.runtime.cycle import RUN_COLUMNS
from rig.runtime.loop import Loop
from rig.runtime.phases import Phase, Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

HORIZON = 0.2
"""The longest time that is looked at, s."""
_RESOLUTION = 1e-3
_VENTING = 0.3
"""For how long the plant is watched after its chambers were vented, s."""
_LOOK_EVERY = 2e-3
_EVERY = 0.01
"""Instants of the motion have this distance, s; at first every fifth is looked at."""
_PHASE, _TIME = (
    [of.name for of in RUN_COLUMNS].index(name) for name in ("phase", "reference.time")
)
_PATIENCE = 5.0
"""After so long (s of the computer's) no more instants are looked at."""

Truth = Sequence[float]


class _Instant(NamedTuple):
    t: float
    plant: object


class NoBound(NamedTuple):
    """The reason for which nothing can be said of frozen setpoints."""

    why: str


class Unfollowed(NamedTuple):
    """The fault in which a motion ends on the simulated rig, on which nothing breaks."""

    why: str


Bound = Freeze | NoBound | Unfollowed
"""For how long setpoints may stay as they are, or why that is not known."""


def refuse_slow_devices(plan: Plan, say: Callable[[str], None], bound: Bound | None = None) -> None:
    """Refuse hardware that the motion would throw out of its limits if the program died.

    A motion that the simulated rig does not follow is refused, too: it was gone through for that.

    Parameters
    ----------
    plan : Plan
        Checked.
    say : callable
        Is told what is not known.
    bound : Freeze or NoBound or Unfollowed, optional
        What `longest_freeze` has found of the plan; default: it is looked for.

    Raises
    ------
    DeviceError
        A device acts too late by itself, or the motion ends in a fault in simulation.
    """
    if not plan.motion.has_torque:
        return
    slowest, bound = slowest_device(plan.profile), bound or longest_freeze(plan, say)
    if isinstance(bound, Unfollowed):
        raise DeviceError(
            plan.profile.name,
            f"{bound.why}; nothing breaks there, so this rig is asked for more than it can do, or "
            "its gains do not bear it: make the motion smaller or slower, or mend what the plant "
            "of the profile says of the rig",
        )
    if isinstance(bound, NoBound):
        say(f"what frozen setpoints do is not known: {bound.why}")
    elif slowest is None:
        say("what frozen setpoints do is not bounded: no device says when it acts by itself")
    elif slowest.after > bound.longest:
        raise DeviceError(
            slowest.device,
            f"if the program dies, it keeps its setpoints for {slowest.after * 1e3:.0f} ms, and "
            f"after {bound.longest * 1e3:.0f} ms from {bound.at:.2f} s of the motion on, "
            f"{bound.what} would pass its limit; shorten its heartbeat_timeout or watchdog, "
            "give it a setpoint_deadline, or slow the motion down",
        )


def longest_freeze(plan: Plan, say: Callable[[str], None] = lambda _: None) -> Bound:
    """Return for how long the setpoints of a plan may stay frozen.

    Where it takes the plant to find out, the motion itself is gone through: if that ends in a
    fault, so is said.

    Parameters
    ----------
    plan : Plan
        Checked.
    say : callable
        Hears a sentence when it is going to take some seconds.
    """
    profile = plan.profile
    view = REGISTRY.load("mechanism", profile.mechanism)
    settings = profile.mechanism_settings
    found: Freeze | None = view.longest_freeze(settings, plan.motion.foreseen, profile.loop.period)
    if found is not None:
        return found
    if profile.plant is None:
        return NoBound(f"{profile.name} has no plant to try it on")
    hazards = REGISTRY.hazards(profile.plant.model)
    if hazards is None or not REGISTRY.is_restorable(profile.plant.model):
        return NoBound(f"the plant {profile.plant.model} cannot be taken back to an instant")
    say("trying on the plant what setpoints do that stay as they are …")
    return _Trial(plan, hazards(settings)).longest()


class _Trial:
    """The plant of a plan, its instants, and what it does from there.

    Parameters
    ----------
    plan : Plan
        Whose motion is gone through when this is made.
    hazards : sequence of Hazard
        What must not become true.
    """

    def __init__(self, plan: Plan, hazards: Sequence[Hazard]) -> None:
        is_long = plan.motion.foreseen.duration > WHOLE
        self._go_through(plan, hazards, in_excerpts=is_long)
        if is_long and self._fault is not None:  # the way into a stretch may have been too rough
            self._go_through(plan, hazards, in_excerpts=False)

    def _go_through(self, plan: Plan, hazards: Sequence[Hazard], *, in_excerpts: bool) -> None:
        """Follow the motion, or its fastest stretches, and keep the plant's instants."""
        from rig.assembly.simulated import build_sim, make_plant

        simulation = dataclasses.replace(plan.profile.simulation, faults=())
        profile = dataclasses.replace(plan.profile, simulation=simulation)
        self._plant = plant = cast("RestorablePlant", make_plant(profile))
        self._rig = rig = build_sim(profile, plant)
        names = [name for name, _ in plant.truth_columns]
        self._bounds = [
            (names.index(column), hazard)
            for hazard in hazards
            if not hazard.only_safe and not hazard.is_rate
            for column in hazard.columns
        ]
        motion, view = plan.motion.foreseen, type(rig.mechanism)
        excerpts = Excerpts(view, motion, fastest(view, motion)) if in_excerpts else None
        followed = motion if excerpts is None else excerpts
        self._instants: list[_Instant] = []
        every = max(1, round(_EVERY / plan.profile.loop.period))

        def note(cycle: int, row: Sequence[float]) -> None:
            at = row[_TIME] if excerpts is None else excerpts.original(row[_TIME])
            if row[_PHASE] == Phase.RUN and cycle % every == 0 and at is not None:
                self._instants.append(_Instant(at, plant.snapshot()))

        states = StateMachine()
        states.move(RigState.IDLE)
        with rig:
            controller = copy.copy(plan.controller)  # what it believes here is not of the real rig
            rig.mechanism.attach(controller, plan.motion)
            plan.motion.attach(rig.devices)
            rig.arm(torque=motion.has_torque)
            loop: Loop[Any, Any, Any] = Loop(
                clock=rig.clock, period=plan.profile.loop.period, buses=(),
                devices=tuple(rig.devices.values()), mechanism=rig.mechanism,
                controller=controller, states=states,
            )  # fmt: skip
            self._fault = loop.run(
                followed, recorder=_Rows(note), events=lambda *_: None, stop=StopRequests(),
                timings=Timings(approach=plan.experiment.approach, release=0.0, settle=0.0),
            ).fault  # fmt: skip

    def longest(self) -> Freeze | Unfollowed:
        """Look at every fifth instant, then around the worst, then at the others."""
        instants, started = self._instants, perf_counter()
        if self._fault is not None:
            at = f"after {instants[-1].t:.2g} s of it" if instants else "before it begins"
            return Unfollowed(f"on the simulated rig this motion ends {at}: {self._fault}")
        order = list(range(0, len(instants), 5))
        waiting = [k for k in range(len(instants)) if k % 5]
        found = Freeze(HORIZON, 0.0, "")
        worst = 0
        while order and perf_counter() - started < _PATIENCE:
            k = order.pop(0)
            shorter = self._shorten(instants[k], found)
            if shorter is not None:
                found, worst = shorter, k
            if not order and waiting:
                waiting.sort(key=lambda other: abs(other - worst))
                order, waiting = waiting[:8], waiting[8:]
        return found

    def _shorten(self, instant: _Instant, found: Freeze) -> Freeze | None:
        """Return a shorter time if this instant needs one."""
        what = self._passes(instant, found.longest)
        if not what:
            return None
        low, high = 0.0, found.longest
        while high - low > _RESOLUTION:
            middle = 0.5 * (low + high)
            passed = self._passes(instant, middle)
            if passed:
                high, what = middle, passed
            else:
                low = middle
        return Freeze(low, instant.t, what)

    def _passes(self, instant: _Instant, freeze: float) -> str:
        """Freeze the setpoints for some time, vent, and return what passes its limit, if any.

        The plant knows its setpoints. What holds its pressure when it is safe holds that of the
        end of the run.
        """
        devices = self._rig.devices.values()
        self._plant.restore(instant.plant)
        for device in devices:
            device.arm()
        start = self._plant.time
        passed = self._advance(start, start + freeze)
        if passed:
            return passed
        for device in devices:
            device.make_safe()
        return self._advance(start + freeze, start + freeze + _VENTING)

    def _advance(self, t: float, end: float) -> str:
        while t < end:
            t = min(t + _LOOK_EVERY, end)
            self._plant.advance(t)
            truth = self._plant.truth()
            for index, hazard in self._bounds:
                value = hazard.of(truth[index])
                if not hazard.low <= value <= hazard.high:
                    return hazard.name
        return ""


class _Rows:
    """A log that nothing is written to: each row is looked at."""

    def __init__(self, note: Callable[[int, Sequence[float]], None]) -> None:
        self._note = note

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        self._note(cycle, row)
