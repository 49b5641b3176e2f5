"""One run's way from energising over the approach and its motion to an orderly release."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, Final, Generic, NamedTuple

from rig.hal import SafetyError
from rig.hal.controller import Controller
from rig.hal.mechanism import Command, Mechanism, Reference, State
from rig.hal.motion import Motion, Note
from rig.runtime.braking import Braking
from rig.runtime.states import RigState, StateMachine

Events = Callable[[float, str, str, dict[str, Any]], None]
"""``events(t, kind, message, data)``."""


class Phase(IntEnum):
    """The phase that a run is in; recorded with every cycle."""

    APPROACH = 0
    RUN = 1
    STOP = 2


_APPROACH, _RUN, _STOP = Phase  # a name is found five times faster than an enumeration's member
_STRAYS = (
    "what an orderly stop released moved off by itself, and was released at once: "
    "find out what let it go before it runs again"
)


class Timings(NamedTuple):
    """Durations that shape a run, s.

    Parameters
    ----------
    energise : float
        From the measured pressures or torques to the ones that control starts from.
    approach : float
        From the measured state to the start of the reference.
    release : float
        From rest to the released rig, in an orderly stop.
    brake : float
        From the reference's speed to its rest, in an orderly stop under control.
    settle : float
        For how long control then holds the rig, which lags behind its reference.
    """

    energise: float = 1.0
    approach: float = 2.0
    release: float = 0.5
    brake: float = 0.25
    settle: float = 0.25


UNANSWERED: Final = object()
"""In the place of the controller's answer until it has given one."""


class Phases(Generic[State, Reference, Command]):
    """One run's way through its phases, cycle by cycle, and how far it has come.

    Parameters
    ----------
    mechanism : Mechanism
        Whose commands lead from one phase into the next.
    controller : Controller
        Reset where it takes over.
    states : StateMachine
        Told when the rig stops.
    motion : Motion
        What to follow.
    timings : Timings
        Durations of energising, approach and release.
    period : float
        Of the cycle, s.

    Attributes
    ----------
    state, reference, command : object or None
        Of the last cycle, to be looked at if it failed; the command as it is asked for.
    answer : object or None
        The last command of the controller itself.
    """

    def __init__(
        self,
        mechanism: Mechanism[Any, State, Reference, Command],
        controller: Controller[Reference, State, Command],
        states: StateMachine,
        motion: Motion[Reference],
        timings: Timings,
        *,
        period: float,
    ) -> None:
        self.phase = _APPROACH
        self.duration = motion.duration
        self.start = self.t = 0.0
        self.reference_time = -(timings.energise + timings.approach)
        self.cycles = 0
        self.missed = 0
        self.finished = False
        self.notes: list[Note] = []
        """What the motion wants written among the events, until somebody has taken it."""
        self.is_controlling = False
        self.state: State | None = None
        self.reference: Reference | None = None
        self.command: Command | None = None
        self.answer: Command | object | None = UNANSWERED
        self._mechanism = mechanism
        self._controller = controller
        self._states = states
        self._period = period
        self._motion = motion
        self._waits = motion.waits
        self._stands = motion.stands
        self._watches = motion.watches
        self._timings = timings
        self._resting: Command | None = None
        self._home: Reference
        self._braking: Braking[Reference] | None = None
        self._stop_at: float
        self._stopped_from: Command | None = None

    def step(self, t: float, state: State, stops: int) -> tuple[Reference, Command]:
        """Return the reference and command of this cycle, and move on to the next phase."""
        mechanism = self._mechanism
        self.state = state
        if self._resting is None:
            self._resting = mechanism.resting_command(state)
            self._home = mechanism.reference_of(state)
            mechanism.start_limiting(state)
        energise, approach = self._timings[:2]
        # A motion that waits is held by a late cycle: nothing of it is left out.
        held = self.missed * self._period if self._waits else 0.0
        self.reference_time = reference_time = t - energise - approach - held

        if self._watches and reference_time >= 0.0 and self.phase is not _STOP and not stops:
            self._show(reference_time, state)
        if self.phase is not _STOP and (stops or reference_time >= self.duration):
            self._begin_stop(t)
        if stops > 1:  # at once: the loop makes safe right after this cycle
            self.finished = True
        if self.phase is _STOP:
            return self._stop(t, state)
        if t < energise:
            if mechanism.has_slipped(state):  # it is held where it is, and not pulled back
                mechanism.start_limiting(state)
                self._home = mechanism.reference_of(state)
                self._resting = mechanism.energised_command(state)
            mechanism.check_still(self._home)
            share = t / energise
            command = mechanism.blend(self._resting, mechanism.energised_command(state), share)
            return self._home, command

        if not self.is_controlling:
            self._home = mechanism.reference_of(state)
            self._controller.reset(state)
            self.is_controlling = True
        if self._stands:
            mechanism.check_still(self._home)
        if reference_time < 0.0:
            reference = self._approach(t - energise)
        else:
            self.phase = _RUN
            reference = self._motion.at(reference_time)
        return reference, self._control(state, reference)

    def hand_over(self, events: Events) -> None:
        """Give what the motion wants written to the run's events."""
        for kind, message in self.notes:
            events(self.t, kind, message, {})
        self.notes.clear()

    def _show(self, reference_time: float, state: State) -> None:
        """Let a motion that depends on it see what was measured; it may end here."""
        motion = self._motion
        self.notes += motion.see(reference_time, state, self._mechanism.reference_of(state))
        self.duration = motion.duration

    def _approach(self, t: float) -> Reference:
        start = self._motion.at(0.0)
        return self._mechanism.approach(self._home, start, self._timings.approach, t)

    def _control(self, state: State, reference: Reference) -> Command:
        try:
            self.reference = reference
            self.answer = command = self._controller.update(state, reference)
        except (ValueError, OSError) as error:  # of its own: no disk's, and no socket's
            said = str(error).encode(errors="backslashreplace").decode() or type(error).__name__
            raise SafetyError(f"the controller cannot go on: {said}") from error
        self._mechanism.check_command(reference, command)
        return command

    def _begin_stop(self, t: float) -> None:
        timings = self._timings
        if self.is_controlling and not self._mechanism.brakes_itself:
            path, at, end = self._motion.at, self.reference_time, self.duration
            if self.phase is _APPROACH:
                path, at, end = self._approach, t - timings.energise, timings.approach
            self._braking = Braking(self._mechanism.slow_down, path, at, end, timings.brake)
        self.phase = _STOP
        self._stop_at = t
        self._states.move(RigState.STOPPING)

    def _stop(self, t: float, state: State) -> tuple[Reference, Command]:
        """Return the reference and command of a cycle of the orderly stop."""
        if self._braking is not None:
            since = t - self._stop_at
            if since < self._timings.brake + self._timings.settle:
                reference = self._braking.at(since)
                return reference, self._control(state, reference)
            self._braking = None
            self._stop_at = t
        return self._mechanism.reference_of(state), self._release(t, state)

    def _release(self, t: float, state: State) -> Command:
        mechanism = self._mechanism
        if self._stopped_from is None:
            # From what the rig has, not from the last command, which may lead it by far.
            self._stopped_from = mechanism.balanced_command(state)
        duration = self._timings.release
        if duration > 0.0:
            duration = max(duration, mechanism.releasing_time(self._stopped_from))
        share = min((t - self._stop_at) / duration, 1.0) if duration > 0.0 else 1.0
        if share >= 1.0:
            self.finished = True
        elif mechanism.strays(state):
            self.finished = True
            self.notes.append(Note("stop", _STRAYS))
        return mechanism.blend(self._stopped_from, mechanism.released_command(), share)
