"""Pressures that every chamber is given alike, one after the other, without a controller."""

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, TypeVar

from annotated_types import Gt, MinLen, Unit

from rig.calibration.sequence import ScriptedMotion
from rig.config import format_quantity
from rig.hal.motion import Segment

Reference = TypeVar("Reference")
Command = TypeVar("Command")


@dataclass(frozen=True, slots=True)
class PressureSteps:
    """Pressures one after the other, the same in every channel.

    Parameters
    ----------
    names : tuple of str
        Of the steps.
    pressures : tuple of float
        Setpoint of each, Pa gauge.
    ramp : float
        Time in which a step is reached, s.
    dwell : float
        Time on it, s.
    judged : float
        So much of the end of each dwell is judged, s.
    """

    names: Annotated[tuple[str, ...], MinLen(1)]
    pressures: Annotated[tuple[Annotated[float, Unit("Pa")], ...], MinLen(1)]
    ramp: Annotated[float, Unit("s"), Gt(0)] = 0.3
    dwell: Annotated[float, Unit("s"), Gt(0)] = 1.5
    judged: Annotated[float, Unit("s"), Gt(0)] = 0.5

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The judged end of each dwell; steps without a name are passed and not judged."""
        each = self.ramp + self.dwell
        return tuple(
            Segment(name, (k + 1) * each - self.judged, (k + 1) * each)
            for k, name in enumerate(self.names)
            if name
        )

    def knots(self, start: float) -> tuple[list[float], list[float]]:
        """Return times and pressures between which setpoints run straight."""
        each = self.ramp + self.dwell
        times, pressures = [0.0], [start]
        for k, pressure in enumerate(self.pressures):
            times += [k * each + self.ramp, (k + 1) * each]
            pressures += [pressure, pressure]
        return times, pressures


class TogetherByClock(ScriptedMotion[Reference, object, Command]):
    """Gives all chambers the same pressures by the clock.

    Parameters
    ----------
    steps : PressureSteps
        The pressures.
    start : float
        Where they begin, Pa gauge.
    count : int
        Of the chambers.
    still : Reference
        The mechanism's reference to stay where it is.
    command : callable
        Makes the mechanism's command of one pressure per channel.
    estimate : object
        What the log keeps of a controller that believes nothing.
    """

    stands = True

    def __init__(
        self,
        steps: PressureSteps,
        start: float,
        count: int,
        *,
        still: Reference,
        command: Callable[..., Command],
        estimate: object,
    ) -> None:
        self._times, self._pressures = steps.knots(start)
        super().__init__(self._times[-1], steps.segments)
        self.estimate = estimate
        self._count, self._still, self._command = count, still, command

    def describe(self) -> Iterator[str]:
        """Yield each chamber's setpoints."""
        low, high = (format_quantity(f(self._pressures), "Pa") for f in (min, max))
        for number in range(1, self._count + 1):
            yield f"chamber {number}: set-points {low} … {high}"
        yield "all chambers alike: their pulls cancel, and no rod is meant to move"

    def reference_at(self, t: float) -> Reference:
        """Return the reference to stay."""
        return self._still

    def play(self) -> Iterator[Command]:
        """Yield the pressures of each instant."""
        while True:
            yield self._command(*(self.pressure_at(self.t),) * self._count)

    def pressure_at(self, t: float) -> float:
        """Return the pressure at an instant, Pa gauge."""
        times = self._times
        k = min(max(bisect_right(times, t), 1), len(times) - 1)
        start, end = times[k - 1], times[k]
        share = 1.0 if end <= start else min(max((t - start) / (end - start), 0.0), 1.0)
        before, after = self._pressures[k - 1], self._pressures[k]
        return before + share * (after - before)
