"""Tell that setpoints, or pressures about them, swing: then nothing need be stuck.

A regulator that answers later than its profile says, or a spool that is slower, makes its loop
swing. At the instant at which a pressure has been off for too long it looks like one that is stuck.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Final

from rig.mechanisms.pneumatic.alarms.turns import Turns

_LOOK: Final = 0.5
"""Swings are looked for in the last time, s; loops that hold a rig up swing ten times in it."""
_KEPT: Final = 1000
"""So many cycles are remembered."""
_SWING: Final = 25e3
"""What counts as a swing, Pa from one end to the next: as valves' reversals are counted."""
_RESTLESS: Final = 13
"""So many of a setpoint within that time are more than any shipped experiment permits …"""
_SWINGS: Final = 2
"""… and so many of a pressure about one that goes more quietly are no answer to it."""

_Cycle = tuple[float, Sequence[float], Sequence[float]]
"""s, setpoints and what monitors say, Pa gauge."""


class PressureSwings:
    """Remembers what was asked of the chambers of late, and what came.

    Parameters
    ----------
    channels : sequence of str
        Their names, for messages.
    part : str
        What feeds a chamber, for messages.
    """

    def __init__(self, channels: Sequence[str], part: str) -> None:
        self._channels, self._part = tuple(channels), part
        self._cycles: deque[_Cycle] = deque(maxlen=_KEPT)

    def clear(self) -> None:
        """Forget the past."""
        self._cycles.clear()

    def note(self, now: float, setpoints: Sequence[float], pressures: Sequence[float]) -> None:
        """Take a cycle: s, Pa gauge."""
        self._cycles.append((now, setpoints, pressures))

    def explain(self) -> str:
        """Return what swings, to be put behind another cause; empty if nothing does."""
        cycles = [cycle for cycle in self._cycles if cycle[0] > self._cycles[-1][0] - _LOOK]
        if len(cycles) < 2:
            return ""
        over = cycles[-1][0] - cycles[0][0]
        asked = [_swings(sent[k] for _, sent, _ in cycles) for k in range(len(self._channels))]
        came = [
            _swings(pressures[k] - sent[k] for _, sent, pressures in cycles)
            for k in range(len(self._channels))
        ]
        k = max(range(len(asked)), key=lambda k: len(asked[k]))
        if len(asked[k]) >= _RESTLESS:
            return (
                f"; or the loop swings, as its gains are too high for this rig's {self._part}s and "
                f"friction: the setpoint of {self._channels[k]} has turned round "
                f"{len(asked[k]) / over:.0f} times a second, by {_middle(asked[k]) * 1e-3:.0f} kPa"
            )
        k = max(range(len(came)), key=lambda k: len(came[k]))
        if len(came[k]) >= _SWINGS + len(asked[k]):
            rate, size = 0.5 * len(came[k]) / over, _middle(came[k]) * 1e-3
            return (
                f"; or the {self._part}s are slower or later than the profile says, and their loop "
                f"swings: the pressure of {self._channels[k]} has swung about its setpoint at "
                f"{rate:.1f} Hz, {size:.0f} kPa peak to peak"
            )
        return ""

    def explain_jump(self, channel: int, far: float) -> str:
        """Return that a setpoint has jumped so far (Pa) that its answer may look like nobody's."""
        sent = [each[channel] for now, each, _ in self._cycles if now > self._cycles[-1][0] - _LOOK]
        if not sent or max(sent) - min(sent) < far:
            return ""
        return (
            f"; or it answers a setpoint of before, which has gone to and fro by "
            f"{(max(sent) - min(sent)) * 1e-3:.0f} kPa, later or farther than the profile says"
        )


def _swings(signal: Iterable[float]) -> list[float]:
    """Return the ways of a signal (Pa) from one end to the next."""
    turns = Turns(_SWING)
    ends = [end for value in signal if (end := turns.update(value)) is not None]
    return [abs(after - before) for before, after in pairwise(ends)]


def _middle(ways: Sequence[float]) -> float:
    return sorted(ways)[len(ways) // 2]
