"""Tell that a pair moves which a procedure leaves alone.

Where pairs are pushed, and no controller leads the ring, nothing else sees what gets away from it.
"""

from typing import Final

from controllers.spherical_joint.geometry import PAIRS, Quadruple
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.pneumatic.alarms.tracking import Shifted

_CALM: Final = 0.25
"""A pair that was pushed has come to rest this much later, s."""


class UnpushedWatch:
    """Checks that a pair stands while the other one is pushed.

    Parameters
    ----------
    most : float
        How far it may go, m.
    """

    def __init__(self, most: float) -> None:
        self._most = most
        self.restart()

    def restart(self) -> None:
        """Forget the past: something else leads the ring."""
        self._alone_since: list[float | None] = [None] * len(PAIRS)
        self._stood: list[float | None] = [None] * len(PAIRS)

    def check(self, push: tuple[float, float], rods: Quadruple, now: float) -> None:
        """Take a cycle's push of each pair (N) and rods (m).

        Raises
        ------
        Shifted
            A pair moves that nothing pushes.
        """
        for k, (one, other) in enumerate(PAIRS):
            if push[k]:
                self._alone_since[k] = self._stood[k] = None
                continue
            since = self._alone_since[k]
            if since is None:
                self._alone_since[k] = now
                continue
            place, stood = 0.5 * (rods[one] - rods[other]), self._stood[k]
            if stood is None:
                if now - since >= _CALM:
                    self._stood[k] = place
            elif not -self._most <= place - stood <= self._most:
                what = f"way of the pair {CHANNELS[one]}, {CHANNELS[other]} that nothing pushes"
                raise Shifted(what, place - stood, -self._most, self._most, "m")
