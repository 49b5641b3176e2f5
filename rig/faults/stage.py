"""The stage of a case: a simulated world whose truth is watched and in which faults happen."""

import resource
import signal
import time
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import NamedTuple, Protocol

from rig.hal.world import BreakableWorld

SAMPLE = 1e-3
"""Between two looks at the truth, s."""

Row = tuple[float, ...]


class PausableClock(Protocol):
    """The clock of a simulation, which a host's stall makes late."""

    world: BreakableWorld

    def now(self) -> float:
        """Return the virtual time, s."""

    def pause(self, duration: float) -> None:
        """Have the sleep that goes on now take longer, s."""

    def sleep_until(self, t: float) -> None:
        """Let the world go on until `t`, s."""


class Cue(NamedTuple):
    """Something that is to happen on the stage.

    Parameters
    ----------
    at : float
        World time, s.
    act : callable
        Makes it happen.
    """

    at: float
    act: Callable[[], None]


class Truth(NamedTuple):
    """The truth over time: times (s) and a row for each, of the plant's columns and its drives'."""

    times: list[float]
    rows: list[Row]


class Stage:
    """Stands between the program's clock and the world, and has both fail on cue.

    Parameters
    ----------
    clock : PausableClock
        Of a rig that has been built and not yet opened; its world is replaced by this stage.
    program : Program
        The program's own failures.
    """

    def __init__(self, clock: PausableClock, program: "Program") -> None:
        self.clock = clock
        self.program = program
        self.world = clock.world
        self.truth = Truth([], [])
        self.changed: Callable[[], None] | None = None
        """Called when setpoints that a fault of theirs has befallen say something else."""
        self._cues: list[Cue] = []
        self._before: list[Cue] = []
        self._next_look = 0.0

    def cue(self, at: float, act: Callable[[], None]) -> None:
        """Have something happen at a world time, s; at once if that has passed."""
        self._cues.append(Cue(at, act))
        self._cues.sort(key=lambda cue: cue.at)

    def cue_before(self, at: float, act: Callable[[], None]) -> None:
        """Have something happen at the last look before a world time, s.

        The world does not halt for it: who goes another way from here leaves no trace in it. A
        halt is another step of the plant's, and where rods stick its last digit may decide.
        """
        self._before.append(Cue(at, act))
        self._before.sort(key=lambda cue: cue.at)

    def forget_cues(self) -> None:
        """Have nothing happen that was to."""
        self._cues.clear()
        self._before.clear()

    def advance(self, t: float) -> None:
        """Let the world go on until `t` (s), with a halt at every cue and every look."""
        now = self.world.time
        while now < t:
            while self._before and self._before[0].at < self._next_look:
                self._before.pop(0).act()
            due = self._cues[0].at if self._cues else t
            now = min(t, max(due, now), self._next_look)
            self.world.advance(now)
            if now >= self._next_look:
                self._look(now)
            while self._cues and self._cues[0].at <= now:
                self._cues.pop(0).act()

    def watch_on(self, duration: float) -> None:
        """Go on watching for `duration` (s) when the program has ended or is dead."""
        self.program.has_ended = True
        self.advance(self.world.time + duration)

    def interrupt(self) -> None:
        """Ask the program to stop, as Ctrl-C does; nobody is left to hear it when it has ended."""
        if not self.program.has_ended:
            signal.raise_signal(signal.SIGINT)

    def _look(self, now: float) -> None:
        self.truth.times.append(now)
        plant = self.world.plant
        self.truth.rows.append((*plant.truth(), *map(float, plant.powered().values())))
        self._next_look = now + SAMPLE


class RehearsalStage(Stage):
    """The stage of a rehearsal: only the program and its computer can fail on it.

    No device and no bus is touched, so there is no truth that anybody could be hurt by.

    Parameters
    ----------
    clock : PausableClock
        Of the rig that is rehearsed on; its world has no time of its own.
    program : Program
        See `Stage`.
    """

    def __init__(self, clock: PausableClock, program: "Program") -> None:
        clock.world = _Timed(clock.world)  # type: ignore[assignment]
        super().__init__(clock, program)
        self._next_look = inf

    def finish(self) -> None:
        """Have happen now what was to: there is no time left for it."""
        while self._cues:
            self._cues.pop(0).act()


class _Timed:
    """A world that tells how far it has gone."""

    def __init__(self, world: BreakableWorld) -> None:
        self._world = world
        self.time = 0.0

    def advance(self, t: float) -> None:
        self._world.advance(t)
        self.time = t


class Program:
    """The failures of the program itself, in the process that a case has for its own.

    Attributes
    ----------
    spoils : callable or None
        What becomes of each command of the controller from now on, see `spoil`.
    dies : callable
        Ends this process without another word of the program.
    """

    def __init__(self, dies: Callable[[], None]) -> None:
        self._disk: tuple[int, int] | None = None
        self.spoils: Callable[[object], object] | None = None
        self.dies = dies
        self.has_ended = False
        self.log: Path | None = None
        """Path of the run's log, once there is one."""

    def fill_disk(self) -> None:
        """Let no file grow beyond the log, as on a full disk: the error comes from the system."""
        self._disk = self._disk or resource.getrlimit(resource.RLIMIT_FSIZE)
        size = self.log.stat().st_size if self.log is not None and self.log.exists() else 0
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, self._disk[1]))

    def free_disk(self) -> None:
        """Let files grow again."""
        if self._disk is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, self._disk)

    def step_clock(self, by: float) -> None:
        """Have the wall's clock say another time than it did, s; virtual time knows nothing of it.

        The system's own clock is everybody's; so this process alone is told another time.
        """
        now, now_ns = time.time, time.time_ns
        time.time = lambda: now() + by
        time.time_ns = lambda: now_ns() + round(by * 1e9)
