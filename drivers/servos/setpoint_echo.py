"""Whether a device has been told what it was sent."""

from collections import deque
from typing import Final

_PATIENCE: Final = 0.03  # s, for a drive that holds its joint meanwhile
_EXACT_PATIENCE: Final = 0.01  # s, for a device whose last setpoint goes on to act
_PERIODS: Final = 3
_TRANSIT: Final = 2
"""Periods until a setpoint can be echoed, as a rule: sent in one, obeyed to the end of the next."""
_CONFIRMED: Final = 2  # echoes in a row: one may fall between two setpoints of a reversal


class SetpointEcho:
    """Compare the demand that a drive reports with the setpoints of the last cycles.

    A drive that obeys goes through them one after the other. So its demand lies between the
    least and the greatest that it was sent within the bound: 30 ms (10 ms if `exact`) or three
    periods, and the time that each takes to be sent, obeyed and echoed. One that lies outside was
    overtaken: setpoints come too late, or not at all. At rest there is nothing to be late.

    Parameters
    ----------
    period : float
        Of the cycle, s.
    slack : float
        Of the demand, in the unit of the setpoints: rounding.
    exact : bool
        The device interpolates nothing: what it reports is one of the setpoints.
    transit : int
        Periods until a setpoint is echoed. 1: the echo is asked for behind the setpoint.

    Attributes
    ----------
    lost : int
        Setpoints that differed from those before them and left no trace in the demand.
    """

    __slots__ = ("_echo", "_exact", "_outside", "_sent", "_slack", "_transit", "lost")

    def __init__(
        self, period: float, slack: float, *, exact: bool = False, transit: int = _TRANSIT
    ) -> None:
        patience = _EXACT_PATIENCE if exact else _PATIENCE
        cycles = max(_PERIODS, round(patience / period) if period else 0) + transit
        self._transit = transit
        self._slack = slack
        self._exact = exact
        self._sent: deque[float] = deque(maxlen=cycles)
        self.lost = 0
        self.reset()

    def reset(self) -> None:
        """Forget what was sent."""
        self._sent.clear()
        self._echo: float | None = None
        self._outside = 0

    def count_lost(self) -> int:
        """Return `lost`."""
        return self.lost

    def send(self, setpoint: float) -> None:
        """Take a setpoint that is sent in this cycle."""
        self._sent.append(setpoint)

    def hear(self, demand: float) -> None:
        """Take the demand of a new sample; call it before the cycle's setpoint is sent."""
        sent, slack, transit = self._sent, self._slack, self._transit
        before, self._echo = self._echo, demand
        if len(sent) < transit + 1:
            return
        # A demand from before the reset is none of these, and may come as late as any other.
        is_judged = len(sent) == sent.maxlen
        self._outside = 0 if not is_judged or self._is_among(demand) else self._outside + 1
        stands = before is not None and abs(demand - before) <= slack
        if stands and abs(sent[-transit] - sent[-transit - 1]) > 2.0 * slack:
            self.lost += 1

    def _is_among(self, demand: float) -> bool:
        sent, slack = self._sent, self._slack
        if self._exact:
            # As good as always it is the very number.
            return demand in sent or any(abs(demand - setpoint) <= slack for setpoint in sent)
        return min(sent) - slack <= demand <= max(sent) + slack

    @property
    def missing(self) -> float | None:
        """How far the demand is behind all that was sent within the bound; None if it is not."""
        if self._outside < _CONFIRMED or self._echo is None:
            return None
        nearest = min(self._sent, key=lambda setpoint: abs(setpoint - (self._echo or 0.0)))
        return nearest - self._echo
