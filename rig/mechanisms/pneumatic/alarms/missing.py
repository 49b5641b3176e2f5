"""The force on a pair that its pressure monitors and its seals do not explain."""

import math
from collections import deque
from collections.abc import Iterator, Reversible, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from rig.mechanisms.pneumatic.settings import SealFriction

LOOK: Final = 0.02
"""Over this time forces are balanced, s …"""
_ENDS: Final = 0.004
"""… with speeds over this time at its two ends, s."""
MOVED: Final = 0.5e-3
"""A pair that has moved less than this (m) sticks, and its seals hold as much as they can."""
_LEAST_FRICTION, _MOST_FRICTION = 0.8, 1.6
"""Seals take so much of the profile's friction at least while they slide, and hold so much at
most. E: with 0.6, as `rig tune` has it, a chamber that empties in mid-motion is not told."""
_STEP: Final = 20e-6
"""Ways shorter than this (m) are added up: encoder noise is no motion …"""
_PASSED: Final = 256
"""… and so many of them are remembered."""
_SURE: Final = 0.7
"""So much of the Coulomb friction is missing at least: less may be friction other than told."""
CERTAIN: Final = 0.9
"""So much, and the rig is stopped. Of 29 healthy runs with up to 0.7 of the friction none came to
more than 0.26; a light push (0.5 N s) comes to 0.9 where the friction is 0.6 of what is told."""
LASTS: Final = 3e-3
"""s: for so long; what one cycle reads may be wrong."""
_RAN: Final = 1.5e-3
"""m: what is led goes less within that time, at a third of the shipped limits of speed."""


class Instant(NamedTuple):
    """Readings of one cycle.

    Parameters
    ----------
    t : float
        s.
    place : float
        Of the pair, m.
    pull : float
        Of its agonist less that of its antagonist, as the monitors say, N.
    """

    t: float
    place: float
    pull: float


def missing_pull(
    history: Sequence[Instant], mass: float, friction: SealFriction, *, sticks: bool = False
) -> float:
    """Return the force that the monitors and the seals leave unexplained, N; 0: nothing.

    While the pair moves, by the energy that it has gained and its seals have taken at least,
    over what the monitors' pull has done. While it sticks, by what its seals can hold at most.

    Parameters
    ----------
    history : sequence of Instant
        Of every cycle, the latest last.
    mass : float
        That the pair moves, kg.
    friction : SealFriction
        As the profile has it.
    sticks : bool
        Only if it sticks. A pair that slides fast has other pressures than late monitors say.
    """
    late = late_of(history)
    if not late or late[-1].t - late[0].t < 2.0 * _ENDS:
        return 0.0
    way = late[-1].place - late[0].place
    if stands(late):
        held = sum(instant.pull for instant in late) / len(late)
        missing, sign = abs(held) - _MOST_FRICTION * friction.breakaway, -held
    elif sticks:
        return 0.0
    else:
        missing, sign = _unexplained_energy(late, mass, friction) / abs(way), way
    return math.copysign(missing, sign) if missing > _SURE * friction.coulomb else 0.0


def late_of(history: Sequence[Instant]) -> list[Instant]:
    """Return the instants over which forces are balanced."""
    return [instant for instant in history if instant.t >= history[-1].t - LOOK]


def stands(late: Sequence[Instant]) -> bool:
    """Return whether a pair has not moved over some instants."""
    return abs(late[-1].place - late[0].place) < MOVED


class LastWay:
    """Work of the monitors' pull on a pair's last half millimetre, however slow that was."""

    def __init__(self) -> None:
        self._work = 0.0
        self._passed: deque[tuple[float, float]] = deque(maxlen=_PASSED)

    def note(self, place: float, pull: float) -> None:
        """Take a place, m, and the pull there, N."""
        passed = self._passed
        if not passed:
            passed.append((place, 0.0))
            return
        way = place - passed[-1][0]
        if abs(way) < _STEP:
            return
        self._work += pull * way
        passed.append((place, self._work))

    def missing(self, friction: SealFriction) -> float:
        """Return the force that moved it beside the pull, N, as `missing_pull` does."""
        for then, before in reversed(self._passed):
            now, done = self._passed[-1]
            way = now - then
            if abs(way) >= MOVED:  # what only gives takes nothing: net ways count
                missing = _LEAST_FRICTION * friction.coulomb - (done - before) / abs(way)
                return math.copysign(missing, way) if missing > _SURE * friction.coulomb else 0.0
        return 0.0


class UnseenPull:
    """Finds a pair that is driven on by a pull that its monitors do not show.

    Parameters
    ----------
    mass : float
        That the pair moves, kg.
    friction : SealFriction
        As the profile has it.
    """

    def __init__(self, mass: float, friction: SealFriction) -> None:
        self._mass, self._friction = mass, friction
        self._late: deque[Instant] = deque()
        self._lost: deque[float] = deque()
        """What its seals have taken at least and its pull has not done, up to each of these, J."""
        self._since: float | None = None

    def note(self, instant: Instant) -> None:
        """Take a cycle's readings."""
        late, lost = self._late, self._lost
        lost.append(lost[-1] + _lost_between(late[-1], instant, self._friction) if late else 0.0)
        late.append(instant)
        while instant.t - late[0].t > LOOK:
            late.popleft()
            lost.popleft()
        way = abs(instant.place - late[0].place)
        if way < MOVED or instant.t - late[0].t < 2.0 * _ENDS:
            self._since = None
            return
        missing = (_gained(late, self._mass) + lost[-1] - lost[0]) / way
        if missing < CERTAIN * self._friction.coulomb:
            self._since = None
        elif self._since is None:
            self._since = instant.t

    @property
    def lasts(self) -> bool:
        """Whether it has been so for a while."""
        return self._since is not None and self._late[-1].t - self._since >= LASTS

    @property
    def runs(self) -> bool:
        """Whether the pair has gone farther of late than one that is led."""
        late = self._late
        return bool(late) and abs(late[-1].place - late[0].place) > _RAN


def _unexplained_energy(late: Sequence[Instant], mass: float, friction: SealFriction) -> float:
    """Return the energy that a sliding pair has got and not from the monitors' pull, J."""
    lost = sum(_lost_between(before, after, friction) for before, after in pairwise(late))
    return _gained(late, mass) + lost


def _lost_between(before: Instant, after: Instant, friction: SealFriction) -> float:
    """Return what seals have taken at least, less what the monitors' pull has done, J."""
    way, time = after.place - before.place, after.t - before.t
    done = 0.5 * (before.pull + after.pull) * way
    if not time > 0.0:
        return -done
    drag = friction.coulomb + friction.viscous * abs(way) / time
    return _LEAST_FRICTION * drag * abs(way) - done


def _gained(late: Reversible[Instant], mass: float) -> float:
    """Return the kinetic energy that a pair has got over some instants, J."""
    fast, slow = _speed(reversed(late)), _speed(iter(late))
    return 0.5 * mass * (fast * fast - slow * slow)


def _speed(instants: Iterator[Instant]) -> float:
    """Return the mean speed over the first of some instants, m/s."""
    first = next(instants)
    other = next(one for one in instants if abs(one.t - first.t) >= _ENDS)
    return (other.place - first.place) / (other.t - first.t)
