"""A law whose gains change while it runs: checked, within bounds, and not in one jump."""

import math
from collections.abc import Callable
from typing import NamedTuple

from controllers.base import AnyLaw, Tunable
from rig.steering.mailbox import Mailbox, Wish
from rig.tuning.gains import values_of, widened, with_gains

LEAST_RAMP, MOST_RAMP = 0.2, 30.0
"""A gain takes at least and at most so long to change, s."""
_STEPS = 50
"""Of a ramp: new gains are worked out so often, and not in each cycle."""
HOLD = 0.5
"""On hardware a wish counts for so long after the last sign that its page is held on to, s."""


class Said(NamedTuple):
    """Something to be written among the run's events.

    Parameters
    ----------
    cycle : int
        Of the law, when it happened.
    message : str
        One sentence.
    data : dict
        ``key``, ``old``, ``new``, ``ramp``, ``accepted``.
    """

    cycle: int
    message: str
    data: dict[str, object]


class _Ramp(NamedTuple):
    """The way of one gain from a value to another."""

    gain: Tunable
    start: float
    end: float
    cycles: int
    begun: int


class OnlineGains:
    """Runs a law as it is, and changes its gains when the mailbox says so.

    It is the loop's controller in the place of the law. What it has to tell is kept until somebody
    takes it: nothing is written in the midst of a cycle.

    Parameters
    ----------
    law : Law
        With `online` gains.
    box : Mailbox
        Looked into once a cycle.
    needs_hold : bool
        Whether wishes count only while somebody holds on: on hardware.

    Attributes
    ----------
    said : list of Said
        What has happened since somebody has looked.
    cycle : int
        Updates of the law so far.
    """

    def __init__(self, law: AnyLaw, box: Mailbox, *, needs_hold: bool) -> None:
        self.said: list[Said] = []
        self.cycle = 0
        self.reset: Callable[[object], None] = law.reset
        self._law, self._box, self._needs_hold = law, box, needs_hold
        self._update = law.update
        self._newest = box.newest
        self._heard = box.newest()
        self._ramp: _Ramp | None = None
        self._first = law.settings
        self._gains = widened(law.online, law.settings)
        self._beats, self._beaten = box.beats(), -math.inf
        self._patience = HOLD / law.period

    @property
    def changed(self) -> dict[str, float]:
        """The gains that are others than at the start, by their keys."""
        before = values_of(self._law.online, self._first)
        now = values_of(self._law.online, self._law.settings)
        return {key: value for key, value in now.items() if value != before[key]}

    def update(self, state: object, reference: object) -> object:
        """Return the law's command, of this cycle's gains; see `Law.update`."""
        if self._needs_hold:
            self._listen_for_beats()
        if self._newest() != self._heard:
            self._take()
        if self._ramp is not None:
            self._advance(self._ramp)
        self.cycle += 1
        return self._update(state, reference)

    @property
    def _is_held(self) -> bool:
        return not self._needs_hold or self.cycle - self._beaten <= self._patience

    def _listen_for_beats(self) -> None:
        beats = self._box.beats()
        if beats != self._beats:
            self._beats, self._beaten = beats, self.cycle

    def _take(self) -> None:
        """Begin what is wished for, or say why not."""
        wish = self._box.read()
        if wish is None or wish.number == self._heard:
            return  # it is just being written: the next cycle will see it
        self._heard = wish.number
        why = self._refusal(wish)
        if why is not None:
            self._say(f"refused: {why}", accepted=False)
            return
        gain = self._gains[wish.gain]
        now = values_of((gain,), self._law.settings)[gain.key]
        ramp = min(max(wish.ramp, LEAST_RAMP), MOST_RAMP)
        self._ramp = _Ramp(gain, now, wish.value, round(ramp / self._law.period), self.cycle)
        self._say(
            f"{gain.key}: {now:.6g} -> {wish.value:.6g} within {ramp:g} s",
            key=gain.key, old=now, new=wish.value, ramp=ramp, accepted=True,
        )  # fmt: skip

    def _refusal(self, wish: Wish) -> str | None:
        gains = self._gains
        if wish.gain >= len(gains):
            return f"there is no gain {wish.gain}"
        gain = gains[wish.gain]
        if not (math.isfinite(wish.value) and gain.low <= wish.value <= gain.high):
            return f"{gain.key} has to be {gain.low:g} … {gain.high:g}, not {wish.value:g}"
        if not math.isfinite(wish.ramp):
            return f"a ramp of {wish.ramp} s"
        if self._ramp is not None:
            return f"{self._ramp.gain.key} is still on its way"
        return None if self._is_held else "nobody holds on to the page"

    def _advance(self, ramp: _Ramp) -> None:
        done = self.cycle - ramp.begun + 1
        if not self._is_held:
            self._ramp = None
            now = values_of((ramp.gain,), self._law.settings)[ramp.gain.key]
            self._say(
                f"{ramp.gain.key} stays at {now:.6g}: nobody holds on to the page",
                key=ramp.gain.key, old=ramp.start, new=now, accepted=True,
            )  # fmt: skip
            return
        if done < ramp.cycles and done % max(ramp.cycles // _STEPS, 1):
            return
        share = min(done / ramp.cycles, 1.0)
        value = ramp.end if share == 1.0 else ramp.start + share * (ramp.end - ramp.start)
        value = min(max(value, ramp.gain.low), ramp.gain.high)
        self._law.retune(with_gains(self._law.settings, {ramp.gain.key: value}))
        if share == 1.0:
            self._ramp = None

    def _say(self, message: str, **data: object) -> None:
        self.said.append(Said(self.cycle, message, data))
