"""Air locked into the chambers for a while, at two places of the rods: the excitation of a leak."""

from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, NamedTuple, TypeVar

from annotated_types import Gt, Unit

from controllers.cylinder.types import PairReference
from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import EstimatingController, GuidedScript, between
from rig.config import format_quantity
from rig.hal import ConfigurationError, Device
from rig.hal.motion import Motion, Segment
from rig.mechanisms.pneumatic.calibration.pneumatics import Pneumatics

State = TypeVar("State")
Reference = TypeVar("Reference")
Command = TypeVar("Command", bound=tuple[float, ...])

BEFORE, SHUT, OPENED = "before", "shut", "opened"
"""The three looks at a cycle: pressurised, locked in, and right after the valves opened."""

_HALT: Final = (0.02, 0.2)
"""At a place the chambers get pressures that turn nothing, in case the controller shook the rods:
within the first time, until the second one, s."""

_RAMP: Final = 0.3
_LOOK: Final = 0.3
_BLINK: Final = 0.06
"""For how long the chamber is looked at after the valves have opened, s."""

_REST: Final = 0.25
"""Time for the regulators to come to rest after that, s."""


class LockCycle(NamedTuple):
    """One cycle: pressurise, lock, wait, open.

    Parameters
    ----------
    name : str
        Of its stretches, before what is looked at.
    place : int
        +1 or -1: where the rods are.
    start, lock, open, end : float
        s.
    """

    name: str
    place: int
    start: float
    lock: float
    open: float
    end: float


@dataclass(frozen=True, slots=True)
class LockCycles(Motion[PairReference]):
    """Locked waits at two places, one place after the other.

    Parameters
    ----------
    travel : float
        Half the way between the places, m.
    pressure : float
        Mean pressure of the chambers when they are locked, Pa gauge.
    below : float
        How much lower the regulators' set-points are behind the shut valves, Pa.
    names : tuple of str
        Of the cycles.
    places : tuple of int
        +1 or -1 for each.
    times : tuple of float
        How long each is locked, s.
    settle : float
        Time at pressure before the valves shut, s.
    move : float
        Time of the way between the places, and again to come to rest there, s.
    """

    travel: Annotated[float, Unit("m"), Gt(0)]
    pressure: Annotated[float, Unit("Pa"), Gt(0)]
    below: Annotated[float, Unit("Pa"), Gt(0)]
    names: tuple[str, ...]
    places: tuple[int, ...]
    times: tuple[Annotated[float, Unit("s"), Gt(0)], ...]
    settle: Annotated[float, Unit("s"), Gt(0)] = 1.0
    move: Annotated[float, Unit("s"), Gt(0)] = 1.5

    def cycles(self) -> Iterator[LockCycle]:
        """Yield the cycles in their order."""
        t, last = 0.0, 0
        for name, place, wait in zip(self.names, self.places, self.times, strict=True):
            if place != last:
                # The first place is where the approach ends.
                t += self.move * (2.0 if last else 1.0)
                last = place
            lock = t + self.settle
            end = lock + wait + _REST
            yield LockCycle(name, place, t, lock, lock + wait, end)
            t = end

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return max((cycle.end for cycle in self.cycles()), default=0.0)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Three for each cycle."""
        return tuple(
            Segment(f"{cycle.name} {look}", start, end)
            for cycle in self.cycles()
            for look, start, end in (
                (BEFORE, cycle.lock - _LOOK, cycle.lock),
                (SHUT, cycle.open - _LOOK, cycle.open),
                (OPENED, cycle.open, cycle.open + _BLINK),
            )
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        before: LockCycle | None = None
        for cycle in self.cycles():
            if t < cycle.end:
                here = cycle.place * self.travel
                if before is not None and before.place != cycle.place:
                    start = before.place * self.travel
                    if t < before.end + self.move:
                        return PairReference(*minimum_jerk(start, here, self.move, t - before.end))
                return PairReference(here, 0.0, 0.0)
            before = cycle
        return PairReference(0.0 if before is None else before.place * self.travel, 0.0, 0.0)


class LockScript(GuidedScript[Reference, State, Command]):
    """Follows a motion between its cycles; in them it sets pressures and shuts the valves.

    Parameters
    ----------
    cycles : LockCycles
        What is to be done when.
    pneumatics : Pneumatics
        Of the mechanism, with the profile that it is done under.
    controller : EstimatingController
        Who follows from place to place.
    """

    def __init__(
        self,
        cycles: LockCycles,
        pneumatics: Pneumatics[Reference, Command],
        controller: EstimatingController[Reference, State, Command],
    ) -> None:
        super().__init__(cycles.duration, cycles.segments, controller)
        self._cycles = list(cycles.cycles())
        self._below = cycles.below
        self._pneumatics = pneumatics
        self._base = pneumatics.gentle_pressure
        self._motion = pneumatics.along_line(cycles, controller, ((0.0, self._base),))
        first = {cycle.place: cycle.start for cycle in reversed(self._cycles)}
        self.pressures = {
            place: pneumatics.balanced(self._motion.at(start), cycles.pressure)
            for place, start in first.items()
        }
        self._lock: Callable[[tuple[bool, ...]], None] | None = None

    def attach(self, devices: Mapping[str, Device]) -> None:
        """Take the valves of the rig.

        Raises
        ------
        ConfigurationError
            The regulators have none.
        """
        name = self._pneumatics.regulators
        device: Any = devices[name]
        if not device.lockable or not all(device.lockable):
            raise ConfigurationError(f"{name}: not every chamber has a lock valve")
        self._lock = device.lock

    def describe(self) -> Iterator[str]:
        """Yield what each chamber is given."""
        for number, column in enumerate(zip(*self.pressures.values(), strict=True), 1):
            low, high = min(column) - self._below, max(column)
            shown = f"{format_quantity(low, 'Pa')} … {format_quantity(high, 'Pa')}"
            yield f"chamber {number}: set-points {shown}, locked in {len(self._cycles)} times"
        yield "while they are locked, no controller holds the rods: friction does"

    def reference_at(self, t: float) -> Reference:
        """Return the motion's reference."""
        return self._motion.at(t)

    def play(self) -> Iterator[Command]:
        """Go to each cycle's place; pressurise, lock, wait and open there."""
        last: tuple[float, ...] = ()
        for number, cycle in enumerate(self._cycles):
            wanted = self.pressures[cycle.place]
            if self.t < cycle.start:
                if number:
                    self.controller.reset(self.state)
                while self.t < cycle.start:
                    command = self.follow(self.wanted)
                    last = tuple(command)
                    yield command
                last = yield from self._halt(cycle, last)
                begun = self.t - cycle.start
            else:
                begun = 0.0
            while self.t < cycle.lock:
                share = (self.t - cycle.start - begun) / _RAMP
                yield self._pneumatics.command(*between(last or wanted, wanted, share))
            self._shut(True)
            last = tuple(p - self._below for p in wanted)
            locked = self._pneumatics.command(*last)
            while self.t < cycle.open:
                yield locked
            self._shut(False)
            while self.t < cycle.end or cycle is self._cycles[-1]:
                yield locked

    def _halt(
        self, cycle: LockCycle, last: tuple[float, ...]
    ) -> Generator[Command, None, tuple[float, ...]]:
        """Give the chambers pressures that turn nothing; return the ones that they have then."""
        wanted = self.pressures[cycle.place]
        low = self._base * len(wanted) / sum(wanted)
        goal = tuple(low * p for p in wanted)
        while self.t - cycle.start < _HALT[1]:
            share = (self.t - cycle.start) / _HALT[0]
            yield self._pneumatics.command(*between(last, goal, share))
        return goal

    def _shut(self, shut: bool) -> None:
        if self._lock is not None:
            self._lock((shut,) * len(self._pneumatics.channels))
