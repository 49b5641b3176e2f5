"""Tell a loop that swings, or no longer follows, by its rods and by where they should be.

A loop whose gains are too high for its regulators' dead time swings to and fro between the ends
of its pressures. Nothing is broken then, and no reading is wrong: only what was asked for shows it.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Self

from rig.hal import LimitExceeded, SafetyError
from rig.hal.hindsight import STICKS, STRAYED
from rig.hal.motion import Note
from rig.mechanisms.pneumatic.alarms.rests import RodRests
from rig.mechanisms.pneumatic.alarms.runs_off import RunsOff
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm
from rig.mechanisms.pneumatic.alarms.turns import Turns

_AWAY = 1.5
"""Who was farther off than so many times what is permitted, if for a moment, is told of."""
_HELD = 0.05
"""What is held is behind its reference for longer than this, s: seals let go before."""
_KEPT = 0.7
"""A swing that dies away is below this share of the one before; one that stays is above it."""
_DUE = 1.5
"""A swing that goes on has turned round again within so many times what it took before."""
_TURN = 0.5
"""The reference turns round if it comes back by this share of the amplitude that counts."""
_RAN = 0.01
"""Over this time, s, what should stand still is watched for a start …"""
START = 0.5e-3
"""… of so much, m: 100 times what healthy ones move then. Pressures can still be vented in time."""
_ONE_STEP = 0.6
"""What runs goes no more than this share of that way from one cycle to the next."""

_STICKS = (
    "it sticks, with more friction than the profile says, or is held: "
    "`rig calibrate RIG friction` measures that"
)


class Strayed(LimitExceeded):
    """A distance from the reference that has lasted for too long; positive beyond it."""

    rod: int = 0
    """Number of the rod or pair."""

    offs: Sequence[float] = ()
    """How far all of them are off, m."""

    ran: bool = False
    """Whether it has run there by itself, and has not lagged behind."""

    lasted: bool = False
    """Whether it has been there for as long as is permitted: it may have come to rest."""


class Shifted(LimitExceeded):
    """A way while the chambers fill, and nothing is controlled."""

    rod: int = 0
    """Number of the rod or pair."""

    ran: bool = False
    """Whether it was gone within a moment."""

    @classmethod
    def by(cls, rod: int, what: str, way: float, most: float, *, ran: bool = False) -> Self:
        """Return the error of a rod that has gone a way, m, and may go `most` to either side."""
        shifted = cls(what, way, -most, most, "m")
        shifted.rod, shifted.ran = rod, ran
        return shifted


class Gone(LimitExceeded):
    """A position beyond its range."""


class _Swings:
    """The swings of one rod about its reference since that last turned round."""

    wild: bool
    """Whether the last swing counts by itself."""

    def __init__(self, alarm: OscillationAlarm, following: float) -> None:
        self._slowest = alarm.slowest
        self._enough = alarm.swings
        self._following = following
        self._error = Turns(alarm.amplitude)
        self._turn = _TURN * alarm.amplitude
        self._wanted = Turns(self._turn)
        self._goal = math.nan
        self._turned: list[tuple[float, float]] = []
        self.step = math.nan, -math.inf
        """The last jump of the reference, m, and when it was, s."""
        self.size = math.nan
        """Of the last swing from one extreme to the next, m."""

    def update(self, wanted: float, error: float, now: float) -> float | None:
        """Return the frequency (Hz) of a swing that has lasted; None as long as there is none."""
        turned = self._turned
        jump, self._goal = wanted - self._goal, wanted
        if self._wanted.update(wanted) is not None:
            turned.clear()
        if abs(jump) > self._turn:  # what is left behind by a step is no swing's end
            self.step = jump, now
            turned.clear()
            self._error = Turns(self._error.distance, rises=error < 0.0)
        extreme = self._error.update(error)
        if extreme is None:
            return None
        if turned:
            before, then = turned[-1]
            size, last = abs(extreme - before), self.size
            if size < _KEPT * last or now - then > self._slowest:
                turned.clear()
            self.size = size
        self.wild = bool(turned) and self._is_wild(turned[-1][0], extreme)
        turned.append((extreme, now))
        del turned[: -self._enough - 1]  # what sticks and slips goes on
        return self.frequency(1 if self.wild else self._enough, now)

    def _is_wild(self, before: float, extreme: float) -> bool:
        """Return whether one swing leads beyond `following` on both sides and does not die away."""
        following = self._following
        both = min(before, extreme) < -following and max(before, extreme) > following
        return both and abs(extreme) > _KEPT * abs(before)

    def goes_on(self, now: float) -> bool:
        """Return whether the next extreme is not long due after the last two."""
        (_, before), (_, last) = self._turned[-2:]
        return now - last <= _DUE * (last - before)

    def is_single(self, now: float) -> bool:
        """Return whether only the last swing was so wide; before it the rod was nearer.

        From there a push may have thrown it to the first end of that swing.
        """
        lasted = self.frequency(self._enough, now) is not None
        extremes = [abs(extreme) for extreme, _ in self._turned[-3:]]
        return not lasted and (len(extremes) < 3 or extremes[0] < _KEPT * extremes[2])

    def frequency(self, swings: int, now: float) -> float | None:
        """Return the frequency, Hz, if so many swings have lasted until now; else None."""
        turned = self._turned
        if len(turned) <= swings or now - turned[-1][1] > self._slowest:
            return None
        return 0.5 * (len(turned) - 1) / (turned[-1][1] - turned[0][1])


class TrackingWatch:
    """Checks how rods follow where they should be while a controller moves them.

    Parameters
    ----------
    names : sequence of str
        Of what moves, for messages: ``the pair``, ``the rod of ch1``.
    following : float
        How far each may be off, m.
    alarm : OscillationAlarm
        For how long, and what is an oscillation.
    start : float
        How far each may go within 10 ms while nothing is controlled, m.
    run_off : float, optional
        How far each may be off by its own motion, m; twice `following` without one.
    """

    def __init__(
        self,
        names: Sequence[str],
        following: float,
        alarm: OscillationAlarm,
        start: float = START,
        run_off: float | None = None,
    ) -> None:
        self._names, self._start = tuple(names), start
        self._following = following
        self._run_off = 2.0 * following if run_off is None else run_off
        self._alarm = alarm
        self._most_sticking = alarm.sticking * alarm.amplitude
        self._stuck = 0.0, ""
        """The widest swing of one that sticks and slips without a fault, m, and what it was."""
        self._farthest = 0.0, 0
        """How far one was off for less than a fault, m, and its number."""
        self.restart()

    def restart(self) -> None:
        """Forget the past: nothing was controlled."""
        self._swings = [_Swings(self._alarm, self._following) for _ in self._names]
        self._followed: list[tuple[float, float] | None] = [None] * len(self._names)
        """When each was last near enough, s, and where it was, m."""
        self._away = [0.0] * len(self._names)
        """How far each has been off since then, m."""
        self._runs_off = RunsOff(len(self._names), self._run_off)
        self._rests = [RodRests() for _ in self._names]
        self._stood: deque[tuple[float, Sequence[float]]] = deque()
        """Where they were of late while nothing was controlled: s, m."""

    def check(
        self,
        wanted: Sequence[float],
        measured: Sequence[float],
        now: float,
        held: Callable[[], str | None] = lambda: None,
        driven: Callable[[int, float], bool] = lambda k, error: False,
    ) -> None:
        """Take a cycle's positions, m, and raise if one swings or does not follow.

        Parameters
        ----------
        wanted, measured : sequence of float
            Positions, m.
        now : float
            s.
        held : callable
            Returns why something sticks that should move, if it is known: asked before an error
            has lasted for as long as is permitted.
        driven : callable
            Takes the number of a rod and how far it is off, m; returns whether its own pressures
            have driven it there, as a loop does that swings. That has a name of its own.

        Raises
        ------
        SafetyError
            It oscillates, or is held.
        Strayed
            It has been too far off for too long; or it is twice as far off and has run there by
            itself, as no rod does that lags behind its reference: pushed, or no longer held.
        """
        following = self._following
        for k, swings in enumerate(self._swings):
            goal = wanted[k]
            error = measured[k] - goal
            rests = self._rests[k]
            rests.update(measured[k], now)
            try:
                if self._runs_off.has_run(k, error, measured[k], driven):
                    what = f"following error of {self._names[k]} that its own motion brought about"
                    raise self._strayed(what, k, error, self._run_off, ran=True)
                self._check_far(k, error, measured[k], now, held)
            except Strayed as strayed:
                strayed.offs = [at - to for at, to in zip(measured, wanted, strict=True)]
                raise
            frequency = swings.update(goal, error, now)
            if frequency is None:
                continue
            if swings.wild or swings.size > self._most_sticking or not rests.sticks:
                raise SafetyError(
                    f"{self._say_why(k, frequency, now)} [{self._alarm.swings} swings of more than "
                    f"{self._alarm.amplitude * 1e3:g} mm, or one of {following * 1e3:g} mm to "
                    "either side]"
                )
            if swings.size > self._stuck[0]:
                self._stuck = swings.size, self._say(k, frequency)

    def remarks(self) -> tuple[Note, ...]:
        """Return what has stuck and slipped, or strayed, worst, by less than is a fault."""
        notes = [Note(STICKS, self._stuck[1])] if self._stuck[1] else []
        off, k = self._farthest
        if off:
            permitted = f"{self._following * 1e3:.3g} mm of `limits.following`"
            far = f"{self._names[k]} was up to {off * 1e3:.2g} mm off its reference, beyond the"
            notes.append(Note(STRAYED, f"{far} {permitted}, for less than {self._alarm.lost:g} s"))
        return tuple(notes)

    def _check_far(
        self, k: int, error: float, place: float, now: float, held: Callable[[], str | None]
    ) -> None:
        """Raise if a rod is too far off for too long."""
        following, followed = self._following, self._followed[k]
        if -following <= error <= following or followed is None:
            self._followed[k] = now, place
            if self._away[k]:
                stepped = now - self._swings[k].step[1] <= self._alarm.slowest
                if self._away[k] > _AWAY * following and not stepped:  # nobody follows a step
                    self._farthest = max(self._farthest, (self._away[k], k))
                self._away[k] = 0.0
            return
        self._away[k] = max(self._away[k], abs(error))
        since, left_at = followed
        way = place - left_at if error > 0.0 else left_at - place
        name = self._names[k]
        if now - since > self._alarm.lost:
            ran = way > 0.5 * (abs(error) - following)
            what = f"following error of {name} for {now - since:.3g} s"
            strayed = self._strayed(what, k, error, following, ran=ran)
            strayed.lasted = True
            raise strayed
        if now - since > _HELD and (cause := held()) is not None:
            raise SafetyError(f"{cause} [{name} stays {error * 1e3:.2g} mm off its reference]")

    def _strayed(self, what: str, k: int, error: float, most: float, *, ran: bool) -> Strayed:
        """Return the error of a rod that has strayed; what has run there by itself sticks not."""
        why = _STICKS if not ran and self._rests[k].sticks else None
        strayed = Strayed(what, error, -most, most, "m", why)
        strayed.rod, strayed.ran = k, ran
        return strayed

    def check_still(
        self,
        wanted: Sequence[float],
        measured: Sequence[float],
        now: float,
        most: float = math.inf,
    ) -> None:
        """Raise if a rod moves while the chambers fill, and nothing is controlled.

        Parameters
        ----------
        wanted, measured : sequence of float
            Positions, m.
        now : float
            s.
        most : float
            How far one may move in any case, m: a procedure that looks for friction follows
            nothing, and has a rod stray as far as it likes.

        Raises
        ------
        Shifted
            It is farther off than that, or than a rod may be that follows; or it has just run.
        """
        following = min(self._following, most)
        stood = self._stood
        stood.append((now, measured))
        while now - stood[0][0] > _RAN:
            stood.popleft()
        before = stood[0][1]
        for k, name in enumerate(self._names):
            off, way = measured[k] - wanted[k], measured[k] - before[k]
            if not -following <= off <= following:
                raise Shifted.by(k, f"way of {name} while nothing controls it", off, following)
            if not -self._start <= way <= self._start and not self._jumped(k, way):
                what = f"way of {name} in {_RAN * 1e3:g} ms while nothing controls it"
                raise Shifted.by(k, what, way, self._start, ran=True)

    def _jumped(self, rod: int, way: float) -> bool:
        """Return whether most of a way was one reading's: an encoder's, that has its own alarm."""
        steps = [after[rod] - before[rod] for (_, before), (_, after) in pairwise(self._stood)]
        return max(map(abs, steps)) > _ONE_STEP * abs(way)

    def suspicion(self, now: float) -> str | None:
        """Return which rod has begun to swing, for a limit that was exceeded before it lasted.

        Or which one goes after a step of its reference.
        """
        for k, swings in enumerate(self._swings):
            frequency = swings.frequency(1, now)
            if frequency is not None and swings.size > self._following and swings.goes_on(now):
                return self._say_why(k, frequency, now)
            step, at = swings.step
            if now - at <= self._alarm.lost:
                return f"{self._names[k]} follows a step of its reference by {step * 1e3:.3g} mm"
        return None

    def _say_why(self, k: int, frequency: float, now: float) -> str:
        """Say how a rod swings; a single swing may as well be what a push left behind."""
        pushed = "; unless it was pushed" if self._swings[k].is_single(now) else ""
        return self._say(k, frequency) + pushed

    def _say(self, k: int, frequency: float) -> str:
        size, rests = self._swings[k].size * 1e3, self._rests[k]
        if rests.sticks:
            return (
                f"{self._names[k]} sticks and slips at {frequency:.1f} Hz, {size:.2g} mm peak to "
                f"peak, about its reference, and stands for {100.0 * rests.share:.0f} % of the "
                "time: its friction is more than the profile says, its regulators are slower or "
                "later, or its gains bear neither; `rig calibrate RIG friction response` measures "
                "both, then `rig tune RIG` looks for gains"
            )
        return (
            f"{self._names[k]} oscillates at {frequency:.1f} Hz, {size:.2g} mm peak to peak, about "
            "its reference: the gains are too high for this rig's regulators and friction; "
            "`rig calibrate RIG response` tells their response and dead time"
        )
