"""How a rig comes to rest after a fault, for the log: its drives slow the joints down."""

import contextlib
import math
from collections.abc import Callable
from typing import Any

from rig.hal import Column, Mechanism

_PATIENCE = 1.0
"""So much longer than a stop takes it is recorded, s: a disk that is slow must not draw it out."""
_MADE_SAFE = 2.0
"""What the column ``fault`` says in these cycles."""


class StopRecording:
    """Records the cycles in which the safe setpoints are repeated after a fault.

    Only for a mechanism that says by `stopping_time` (s) how long its stop takes; the log of
    any other ends with the cycle that saw the fault.

    Parameters
    ----------
    mechanism : Mechanism
        Whose state is read and recorded.
    write : callable
        ``write(cycle, t, row)``.
    measured : callable
        The values of the devices' own columns.
    truth : callable
        The plant's true values, where there is one.
    timing : sequence of Column
        Columns at the end of a row that have no meaning after a fault.
    period : float
        s.
    start : float
        Time of the first cycle on the clock, s.
    phase, reference_time : float
        What the columns of these names say during the stop; the latter at the fault, s.
    """

    def __init__(
        self,
        mechanism: Mechanism[Any, Any, Any, Any],
        write: Callable[[int, float, tuple[float, ...]], None],
        measured: Callable[[], tuple[float, ...]],
        truth: Callable[[], tuple[float, ...]],
        timing: tuple[Column, ...],
        period: float,
        start: float,
        *,
        phase: float,
        reference_time: float,
        last: float,
    ) -> None:
        self._mechanism = mechanism
        self._write = write
        self._measured = measured
        self._truth = truth
        self._idle = (0.0,) * len(timing)
        self._period = period
        self._start = start
        self._phase = phase
        self._offset = reference_time - last
        self._cycle = round(last / period)
        self._until = last + mechanism.stopping_time + _PATIENCE
        self._state: Any  # none until a device answers: then there is nothing to record

    @property
    def cycles(self) -> int:
        """How many cycles the stop takes; 0 if there is nothing to record."""
        return math.ceil(self._mechanism.stopping_time / self._period)

    def __call__(self, now: float) -> None:
        """Record what is read now; never raises: the stop goes on whatever becomes of the log."""
        t = now - self._start
        cycle = round(t / self._period)
        if not self.cycles or cycle <= self._cycle or t > self._until:
            return
        with contextlib.suppress(Exception):
            mechanism = self._mechanism
            with contextlib.suppress(Exception):  # a silent device: the others' last readings stay
                self._state = mechanism.read(now)
            state = self._state
            reference, command = mechanism.reference_of(state), mechanism.released_command()
            row = mechanism.row(state, reference, command, command)
            row = (*row, *self._measured(), *self._idle, *self._truth())
            self._write(cycle, t, (self._phase, now, _MADE_SAFE, t + self._offset, *row))
            self._cycle = cycle
