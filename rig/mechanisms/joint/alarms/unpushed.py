"""Tell that a pair moves which a procedure leaves where it stands.

Where pairs are pushed, and no controller leads the ring, nothing else sees what gets away from it.
"""

from typing import Final, NamedTuple

from controllers.spherical_joint.geometry import PAIRS, Quadruple
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.pneumatic.alarms.tracking import Shifted

_CALM: Final = 0.25
"""A pair that was pushed has come to rest this much later, s."""

_STANDS: Final = 0.5e-3
"""A pair that is pushed has come to rest if it goes less than this in that time, m."""


class UnpushedWatch:
    """Checks that a pair stands once its push does not change any more.

    One that nothing pushes has to; one that is pushed evenly may slide first.

    Parameters
    ----------
    most : float
        How far it may go, m.
    """

    def __init__(self, most: float) -> None:
        self._pairs = [_Stands(most, number) for number in range(len(PAIRS))]

    def restart(self) -> None:
        """Forget the past: something else leads the ring."""
        for pair in self._pairs:
            pair.restart()

    def check(self, push: tuple[float, float], rods: Quadruple, now: float) -> None:
        """Take a cycle's push of each pair (N) and rods (m).

        Raises
        ------
        Shifted
            A pair moves though its push does not change.
        """
        for pair, force in zip(self._pairs, push, strict=True):
            pair.check(force, rods, now)


class _Even(NamedTuple):
    """A push that has not changed, N, since when, s, and where its pair was then, m."""

    push: float
    since: float
    place: float


class _Stands:
    """One pair."""

    def __init__(self, most: float, number: int) -> None:
        self._most = most
        self._one, self._other = PAIRS[number]
        self.restart()

    def restart(self) -> None:
        """Forget the past."""
        self._even: _Even | None = None
        self._stood: float | None = None

    def check(self, push: float, rods: Quadruple, now: float) -> None:
        """See `UnpushedWatch.check`."""
        place = 0.5 * (rods[self._one] - rods[self._other])
        even, stood = self._even, self._stood
        if even is None or push != even.push:
            self._even, self._stood = _Even(push, now, place), None
        elif stood is None:
            if push != 0.0 and abs(place - even.place) > _STANDS:  # it slides
                self._even = _Even(push, now, place)
            elif now - even.since >= _CALM:
                self._stood = place
        elif abs(place - stood) > self._most:
            pair = f"the pair {CHANNELS[self._one]}, {CHANNELS[self._other]}"
            what = f"way of {pair} that nothing pushes{' any further' if push else ''}"
            raise Shifted.by(self._one, what, place - stood, self._most)
