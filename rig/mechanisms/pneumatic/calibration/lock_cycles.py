"""Air locked into the chambers for a while, at two places of the rods: the excitation of a leak."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, NamedTuple

from annotated_types import Gt, Unit

from controllers.cylinder.types import PairReference
from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import ScriptedMotion
from rig.hal import ConfigurationError
from rig.hal.motion import Segment

BEFORE, SHUT, OPENED = "before", "shut", "opened"
"""The three looks at a cycle: pressurised, locked in, and right after the valves opened."""

_HALT: Final = (0.02, 0.2)
"""When a place is reached: within how long the chambers get pressures that turn nothing, in case
the controller shook the rods, and when those rest, s."""

_RAMP: Final = 0.3
_LOOK: Final = 0.3
_BLINK: Final = 0.06
"""For how long the chamber is looked at after the valves have opened, s."""

_REST: Final = 0.25
"""Time for the regulators to come to rest after that, s."""


class Cycle(NamedTuple):
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
class LockCycles:
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
    waits : tuple of float
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
    waits: tuple[Annotated[float, Unit("s"), Gt(0)], ...]
    settle: Annotated[float, Unit("s"), Gt(0)] = 1.0
    move: Annotated[float, Unit("s"), Gt(0)] = 1.5

    def cycles(self) -> Iterator[Cycle]:
        """Yield the cycles in their order."""
        t, last = 0.0, 0
        for name, place, wait in zip(self.names, self.places, self.waits, strict=True):
            if place != last:
                # The first place is where the approach ends.
                t += self.move * (2.0 if last else 1.0)
                last = place
            lock = t + self.settle
            end = lock + wait + _REST
            yield Cycle(name, place, t, lock, lock + wait, end)
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
        before: Cycle | None = None
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


class Locking(ScriptedMotion[Any]):
    """Follows a motion between its cycles, and in them gives pressures and shuts the valves.

    To the runtime it is the motion and its controller in one; see `OpenLoop`.

    Parameters
    ----------
    cycles : LockCycles
        What is to be done when.
    motion : object
        `cycles` as a motion of the mechanism.
    controller : object
        Who follows it from place to place.
    pressures : mapping of int to sequence of float
        By the place: what each chamber has when it is locked, Pa gauge; in balance.
    base : float
        Their mean while the controller works, Pa gauge.
    command : callable
        Makes the mechanism's command of one pressure per channel.
    regulators : str
        The device that has the valves.
    """

    def __init__(
        self,
        cycles: LockCycles,
        motion: Any,
        controller: Any,
        pressures: Mapping[int, Sequence[float]],
        base: float,
        command: Callable[..., Any],
        regulators: str,
    ) -> None:
        self.pressures = pressures
        super().__init__(cycles.duration, cycles.segments)
        self.estimate = controller.estimate
        self.learning = None
        self._cycles = list(cycles.cycles())
        self.below = cycles.below
        self.count = len(self._cycles)
        self._motion = motion
        self._controller = controller
        self._command = command
        self._regulators = regulators
        self._lock: Callable[[tuple[bool, ...]], None] | None = None
        self._shut = False
        self._base = base
        self._following = True
        self._from: tuple[float, ...] = ()
        self._number = 0
        self._since = self._t = 0.0

    def attach(self, devices: Mapping[str, Any]) -> None:
        """Take the valves of the rig.

        Raises
        ------
        ConfigurationError
            The regulators have none.
        """
        device = devices[self._regulators]
        if not device.lockable or not all(device.lockable):
            raise ConfigurationError(f"{self._regulators}: not every chamber has a lock valve")
        self._lock = device.lock

    def at(self, t: float) -> Any:
        """Take the time, and return the motion's reference."""
        self._t = t
        return self._motion.at(t)

    def reset(self, state: Any) -> None:
        """Start over."""
        self._number, self._shut, self._following = 0, False, True
        self._controller.reset(state)

    def update(self, state: Any, reference: Any) -> Any:
        """Return the command of this instant, and work the valves."""
        t, cycles = self._t, self._cycles
        while self._number < len(cycles) - 1 and t >= cycles[self._number].end:
            self._number += 1
        cycle = cycles[self._number]
        self._set_valves(cycle.lock <= t < cycle.open)
        if t < cycle.start:
            if not self._following:
                self._following = True
                self._controller.reset(state)
            command = self._controller.update(state, reference)
            self.estimate = self._controller.estimate
            self._from = tuple(command)
            return command
        wanted = tuple(self.pressures[cycle.place])
        since = t - cycle.start
        if t >= cycle.lock:
            goal, share = tuple(p - self.below for p in wanted), 1.0
        elif self._following and since < _HALT[1]:
            low = self._base * len(wanted) / sum(wanted)
            goal, share = tuple(low * p for p in wanted), min(since / _HALT[0], 1.0)
        else:
            if self._following:
                self._following, self._since = False, since
            goal, share = wanted, min((since - self._since) / _RAMP, 1.0)
        now = tuple(a + share * (b - a) for a, b in zip(self._from or goal, goal, strict=True))
        if share >= 1.0:
            self._from, self._since = goal, 0.0
        return self._command(*now)

    def _set_valves(self, shut: bool) -> None:
        if shut is not self._shut and self._lock is not None:
            self._lock((shut,) * len(next(iter(self.pressures.values()))))
            self._shut = shut
