"""Tell that something pulls a pair that its pressure monitors do not show.

A monitor sits at its regulator. Between it and the chamber is a tube: what leaks behind that is
felt by the rods long before the monitor shows it, and a push is never shown.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final

from rig.mechanisms.pneumatic.alarms.missing import (
    CERTAIN,
    LASTS,
    LOOK,
    Instant,
    LastWay,
    UnseenPull,
    late_of,
    missing_pull,
    stands,
)
from rig.mechanisms.pneumatic.settings import SealFriction

_EMPTIED: Final = 15e3
"""A pressure that falls by so much meanwhile (Pa) as its rod is drawn out has lost air."""
_KEPT: Final = 256
"""So many cycles are remembered: rods run from rest to a limit within 0.2 s …"""
_OF_LATE: Final = 64
"""… and so many tell how encoders scatter."""
_MEASURES: Final = "`rig calibrate RIG friction` measures it"
_STUCK: Final = f", or has more friction than the profile says ({_MEASURES})"
"""What holds a pair that stands, beside air and hands …"""
_WORN: Final = 2.0
_LACKS: Final = 1.0
"""Seals with more friction are the likeliest up to so many times the breakaway that is told: of
what pulls a pair back, and of what is missing beyond what they may hold."""
_SLIDES: Final = (
    "; or its seals have far less friction than the profile says (`rig calibrate RIG friction`)"
)
"""… and what lets one go on that moves …"""
UNSTABLE: Final = (
    "; or its loop is not stable, as its regulators are later or its friction is less than the "
    "profile says"
)
"""… or run off by what moves it."""

_Entry = tuple[float, Sequence[float], Sequence[float]]
"""Of a cycle: s, the rods, m, and the pressures, Pa gauge."""


class PullBalance:
    """Remembers how pairs moved and what their monitors said, and tells what does not fit.

    Parameters
    ----------
    area : float
        Effective piston area, m².
    mass : float
        That a pair moves, kg.
    friction : SealFriction
        Of a pair, as the profile has it.
    pairs : sequence of tuple of int
        Agonist and antagonist of each.
    channels : sequence of str
        Their names, for messages.
    device : str
        The regulators' name, for messages.
    moved : str
        What the pairs move, for messages: ``the carriage``.
    falls : callable, optional
        Takes how far a pair and the other one are off the middle, m, and returns the force with
        which tensions pull it on, over the mean pull of a chamber; default: nothing falls.
    """

    def __init__(
        self,
        area: float,
        mass: float,
        friction: SealFriction,
        pairs: Sequence[tuple[int, int]],
        channels: Sequence[str],
        device: str,
        moved: str,
        falls: Callable[[float, float], float] | None = None,
    ) -> None:
        self._area = area
        self._mass, self._friction, self._falls = mass, friction, falls
        self._pairs, self._channels = tuple(pairs), tuple(channels)
        self._device, self._moved = device, moved
        self._history: deque[_Entry] = deque(maxlen=_KEPT)
        self.restart()

    def restart(self) -> None:
        """Forget the past: a new motion starts."""
        self._history.clear()
        self._ways = [LastWay() for _ in self._pairs]
        self._unseen = [UnseenPull(self._mass, self._friction) for _ in self._pairs]

    def note(self, now: float, rods: Sequence[float], pressures: Sequence[float]) -> None:
        """Take a cycle's rods (m, run in) and what the monitors say, Pa gauge."""
        self._history.append((now, rods, pressures))
        for pair, way, unseen in zip(self._pairs, self._ways, self._unseen, strict=True):
            instant = Instant(now, *self._place_and_pull(pair, rods, pressures))
            way.note(instant.place, instant.pull)
            unseen.note(instant)

    def explain_unseen(self) -> str | None:
        """Return why a pair moves on that its pressures do not drive; None: none does for long."""
        if not any(unseen.lasts for unseen in self._unseen):
            return None
        cause = self.explain()
        least = CERTAIN * self._friction.coulomb
        if cause and _SLIDES not in cause:
            cause += _SLIDES
        return cause and f"{cause} [{least:.2g} N for {LASTS * 1e3:g} ms, while it moves]"

    def runs(self, pair: int = 0) -> bool:
        """Return whether a pair has gone farther of late than one that is led."""
        return self._unseen[pair].runs

    @property
    def rods(self) -> list[Sequence[float]]:
        """The rods of the last cycles, the latest last."""
        return [rods for _, rods, _ in self._history][-_OF_LATE:]

    def explain(self, *, sticks: bool = False) -> str | None:
        """Return that a chamber has other air than its monitor says, or that somebody pushes.

        Of two pairs the one is blamed of which something was missing first: a ring that is thrown
        takes the other one along.

        Parameters
        ----------
        sticks : bool
            Only of a pair that sticks.
        """
        short = [(*self._missing(pair, sticks), pair) for pair in self._pairs]
        short = [one for one in short if one[1]]
        if not short:
            return None
        began = min(when for when, _, _ in short)
        found = [(missing, pair) for when, missing, pair in short if when < began + 0.5 * LOOK]
        found.sort(key=lambda one: -abs(one[0]))
        weak = " or ".join(
            self._channels[pair[0 if missing < 0.0 else 1]] for missing, pair in found
        )
        most, stood = abs(found[0][0]), stands(late_of(self._instants(found[0][1])))
        if stood and most <= _LACKS * self._friction.breakaway:
            blamed = self._blame_seals(weak)
        else:
            blamed = f"{self._blame(weak)}{_STUCK if stood else ''}"
        slides = _SLIDES if not stood and most <= self._friction.coulomb else ""
        return f"{blamed}: {most:.0f} N are not those of the pressures{slides}"

    def explain_off(self, off: float, pair: int = 0) -> str | None:
        """Return why a pair stays off its reference though its pressures pull it back.

        None: they do not, or by less than its seals take.

        Parameters
        ----------
        off : float
            How far, m; positive where its agonist pulls to.
        pair : int
            Its number.
        """
        late = late_of(self._instants(self._pairs[pair]))
        if not late:
            return None
        pull = sum(instant.pull for instant in late) / len(late)
        against = -pull if off > 0.0 else pull
        if not against > self._friction.coulomb:
            return None
        weak = self._pulls_back(off, pair)
        if against <= _WORN * self._friction.breakaway:
            blamed = self._blame_seals(weak)
        else:
            blamed = f"{self._blame(weak)}{_STUCK}"
        return f"{blamed}: it stays off though {against:.0f} N pull it back"

    def explain_crept(self, pair: int) -> str | None:
        """Return why a pair that sticks now was last moved by more than its pressures.

        None: it was not. A chamber that has lost its air lets a pair creep against what its
        monitor says, too slowly for `explain`.

        Parameters
        ----------
        pair : int
            Its number.
        """
        missing = self._ways[pair].missing(self._friction)
        if missing == 0.0:
            return None
        weak = self._channels[self._pairs[pair][0 if missing < 0.0 else 1]]
        return (
            f"{self._blame(weak)}: what last moved it was {abs(missing):.0f} N more than pressures"
        )

    def drives(self, off: float, pair: int) -> bool:
        """Return whether a pair's own pressures pull it to where it is off, and nothing beside.

        Beyond its friction, and with the energy that it has got. Parameters as `explain_off`.
        """
        late = late_of(self._instants(self._pairs[pair]))
        if not late:
            return False
        pull = sum(instant.pull for instant in late) / len(late)
        if math.copysign(1.0, off) * pull <= self._friction.coulomb:
            return False
        return off * missing_pull(late, self._mass, self._friction) <= 0.0

    def explain_strayed(self, off: float, pair: int = 0, *, ran: bool, lasted: bool) -> str | None:
        """Return why a pair has strayed from its reference; parameters as `explain_off`.

        What has run there and stands by now may have been led there too fast: only if more pulls it
        back than its seals hold, something else keeps it there.

        Parameters
        ----------
        ran, lasted : bool
            Whether it has run there by itself, and has had the time to come to rest.
        """
        late = late_of(self._instants(self._pairs[pair]))
        if ran and not (lasted and late and stands(late)):
            return f"{self.explain_gone(off, pair)}{UNSTABLE}"
        return self.explain_off(off, pair) or self.explain_crept(pair)

    def explain_gone(self, off: float, pair: int) -> str:
        """Return why a pair has run off its reference by itself; parameters as `explain_off`."""
        return self._blame(self._pulls_back(off, pair))

    def explain_emptied(self, pair: int) -> str | None:
        """Return that a chamber of a pair has lost its air, if it falls as its rod is drawn out.

        A push that draws the rod out presses the air in its chamber.

        Parameters
        ----------
        pair : int
            Its number.
        """
        late = [entry for entry in self._history if entry[0] >= self._history[-1][0] - LOOK]
        if not late:
            return None
        (_, rods_then, then), (_, rods_now, now) = late[0], late[-1]
        for weak in self._pairs[pair]:
            if rods_now[weak] < rods_then[weak] and then[weak] - now[weak] > _EMPTIED:
                return self._blame(self._channels[weak])
        return None

    def _pulls_back(self, off: float, pair: int) -> str:
        """Return which chamber should pull a pair back that is off."""
        one, other = self._pairs[pair]
        return self._channels[other if off > 0.0 else one]

    def _blame(self, weak: str) -> str:
        """Return that a chamber has less air than it shows."""
        return (
            f"{self._device}: the chamber of {weak} leaks behind its tube, or its monitor is off, "
            f"or {self._moved} is pushed or held"
        )

    def _blame_seals(self, weak: str) -> str:
        """Return the same of a pair that stands, which worn or other seals would hold as well."""
        return (
            f"{self._device}: {self._moved} has more friction than the profile says ({_MEASURES}), "
            f"or is pushed or held, or the chamber of {weak} leaks behind its tube, or its "
            "monitor is off"
        )

    def _missing(self, pair: tuple[int, int], sticks: bool) -> tuple[float, float]:
        """Return when the pull of a pair was first missing, s, and how much, N; 0: it was not.

        A run is explained by how it began: near its end wires and a ring that falls pull as well.
        """
        if sticks:
            late = self._instants(pair)
            return 0.0, missing_pull(late, self._mass, self._friction, sticks=True)
        history, first = self._instants(pair, math.inf), (0.0, 0.0)
        while history:
            missing = missing_pull(history, self._mass, self._friction)
            late = late_of(history)
            if missing:
                first = late[0].t, missing
            del history[1 - len(late) :]  # all of it, where the one before is long ago
            if history and stands(late_of(history)):
                break
        return first

    def _instants(self, pair: tuple[int, int], over: float = LOOK) -> list[Instant]:
        """Return the last instants of a pair, over a time (s)."""
        instants: list[Instant] = []
        for t, rods, pressures in reversed(self._history):
            if t < self._history[-1][0] - over:
                break
            instants.append(Instant(t, *self._place_and_pull(pair, rods, pressures)))
        return instants[::-1]

    def _place_and_pull(
        self, pair: tuple[int, int], rods: Sequence[float], pressures: Sequence[float]
    ) -> tuple[float, float]:
        one, other = pair
        place = 0.5 * (rods[one] - rods[other])
        pull = pressures[one] - pressures[other]
        if self._falls is not None:
            beside = [0.5 * (rods[a] - rods[b]) for a, b in self._pairs if a != one]
            pull += self._falls(place, *beside) * sum(pressures) / len(pressures)
        return place, self._area * pull
