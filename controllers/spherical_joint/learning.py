"""Learning over the laps of a repeated motion: what one lap needed the next one gets beforehand.

A correction ``u`` as a function of the place in the lap is improved by the error ``e`` that it
left there, ``u <- Q(u + gain e(. + advance))``: the advance makes up for the time in which the rig
answers, the low-pass Q without phase keeps what does not repeat out of it.

Everything is done cycle by cycle, nothing at the end of a lap: a Fourier transform of ten thousand
cycles would cost the loop its deadlines. Q is three moving averages in a row, centred by the delay
with which their output is filed.
"""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Unit

from controllers.spherical_joint.types import Lap

_PASSES = 3
_HALF_POWER = 0.2624
"""Frequency times width at which three equal moving averages in a row pass half of the power:
``sinc(x)³ = 1/sqrt(2)``."""


@dataclass(frozen=True, slots=True)
class LearningSettings:
    """Gain and resolution with which one signal is learnt.

    Parameters
    ----------
    gain : float
        Share of the error that is added per lap.
    bandwidth : float
        Of Q, where it passes half of the power, Hz.
    advance : float
        By which a correction comes before the error that it answers, s.
    """

    gain: Annotated[float, Gt(0), Le(1)] = 0.4
    bandwidth: Annotated[float, Unit("Hz"), Gt(0), Le(200)] = 20.0
    advance: Annotated[float, Unit("s"), Ge(0), Le(0.5)] = 20e-3


@dataclass(frozen=True, slots=True)
class StopSettings:
    """Conditions under which learning ends by itself.

    Parameters
    ----------
    patience : int
        Laps in a row that may be no better than the best.
    improvement : float
        Share by which a lap has to be better than the best so far to count as better.
    """

    patience: Annotated[int, Interval(ge=1, le=100)] = 2
    improvement: Annotated[float, Ge(0), Le(0.5)] = 0.01


class LapMemory:
    """One learnt signal of several components.

    Parameters
    ----------
    settings : LearningSettings
        Gain, Q and advance.
    components : int
        Values per cycle.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: LearningSettings, components: int, period: float) -> None:
        self._gain = settings.gain
        self._advance = round(settings.advance / period)
        width = max(1, round(_HALF_POWER / (settings.bandwidth * period)))
        self._width = width + 1 - width % 2
        self._offset = self._advance + _PASSES * (self._width - 1) // 2
        self._components = components
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._applied: list[tuple[float, ...]] = []
        self._next: list[tuple[float, ...]] = []
        self._first = True
        self._smoothers = [
            [_MovingAverage(self._width) for _ in range(_PASSES)] for _ in range(self._components)
        ]

    def begin(self, ticks: int) -> None:
        """Start the first lap, of so many cycles, with nothing learnt.

        Raises
        ------
        ValueError
            The lap is shorter than the filter.
        """
        if ticks <= 2 * self._offset:
            raise ValueError(f"a lap of {ticks} cycles is too short to learn from")
        self._applied = [(0.0,) * self._components] * ticks
        self._next = list(self._applied)

    def turn(self) -> list[tuple[float, ...]]:
        """Go on to the next lap; return what was applied in the last one."""
        last = self._applied
        self._first = False
        self._applied = self._next
        self._next = list(self._next)
        return last

    def keep(self, table: list[tuple[float, ...]]) -> None:
        """Apply a table from now on and learn no more."""
        self._applied = table
        self._next = []

    def at(self, tick: int) -> tuple[float, ...]:
        """Return the correction at a cycle of the lap."""
        return self._applied[tick % len(self._applied)]

    def learn(self, tick: int, error: tuple[float, ...]) -> None:
        """Take the error of a cycle; `tick` counts up by one, or starts again with a lap."""
        if not self._next:
            return
        before = self._applied[tick - self._advance]
        gain, smoothed = self._gain, []
        for one, other, (first, second, third) in zip(before, error, self._smoothers, strict=True):
            smoothed.append(third.update(second.update(first.update(one + gain * other))))
        place = tick - self._offset
        if place >= 0:
            self._next[place] = tuple(smoothed)
        elif not self._first:
            # What the end of a lap needed is only known within the next one.
            self._applied[place] = self._next[place] = tuple(smoothed)


class LapLearning:
    """Several signals that are learnt together and judged by one score per lap.

    The best lap's corrections are kept: once `patience` laps in a row were no better, they are
    applied for good.

    Parameters
    ----------
    stop : StopSettings
        When to end.
    memories : tuple of LapMemory
        What is learnt.
    """

    def __init__(self, stop: StopSettings, memories: tuple[LapMemory, ...]) -> None:
        self._stop = stop
        self._memories = memories
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        for memory in self._memories:
            memory.reset()
        self._best: list[list[tuple[float, ...]]] = []
        self._failures = 0
        self._sum = 0.0
        self._lap = -1
        self._ticks = 0
        self.finished = False
        """Whether learning has ended."""
        self.scores: list[float] = []
        """Root mean square of each completed lap's score."""

    def start_cycle(self, lap: Lap) -> None:
        """Go on to a cycle, and to the next lap if it is the first of one.

        The first lap that is seen has to begin at its beginning; until then nothing is learnt.
        Laps of another length, or counted anew, are another motion: what was learnt is forgotten.
        """
        if lap.number == self._lap and lap.ticks == self._ticks:
            return
        if lap.tick != 0:
            return
        if self._lap >= 0 and (lap.ticks != self._ticks or lap.number < self._lap):
            self.reset()
        self._ticks = lap.ticks
        if self._lap < 0:
            for memory in self._memories:
                memory.begin(lap.ticks)
        elif not self.finished:
            self._judge(math.sqrt(self._sum / lap.ticks))
        self._sum = 0.0
        self._lap = lap.number

    def add_score(self, squared: float) -> None:
        """Add a cycle's squared error to the lap's score."""
        self._sum += squared

    @property
    def active(self) -> bool:
        """Whether a lap is going on that corrections apply to."""
        return self._lap >= 0

    def _judge(self, score: float) -> None:
        stop = self._stop
        tables = [memory.turn() for memory in self._memories]
        if not self.scores or score < (1.0 - stop.improvement) * min(self.scores):
            self._best = tables
            self._failures = 0
        else:
            self._failures += 1
        self.scores.append(score)
        if self._failures >= stop.patience:
            self.finished = True
            for memory, table in zip(self._memories, self._best, strict=True):
                memory.keep(table)


class _MovingAverage:
    """Mean of the last values.

    Parameters
    ----------
    width : int
        Number of values.
    """

    def __init__(self, width: int) -> None:
        self._values = [0.0] * width
        self._next = 0
        self._width = width
        self._sum = 0.0

    def update(self, value: float) -> float:
        place = self._next
        self._sum += value - self._values[place]
        self._values[place] = value
        self._next = place + 1
        if self._next == self._width:
            self._next = 0
            # What rounding has left in the running sum does not grow from lap to lap.
            self._sum = math.fsum(self._values)
        return self._sum / self._width
