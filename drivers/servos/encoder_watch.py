"""Whether the encoder of a servo shows what its motor does."""

from collections import deque
from itertools import pairwise
from typing import Final

_SPAN: Final = 0.03  # s: three of these windows fit into a tenth of a second
_LEAST: Final = 5e-3  # rad of motion, below which nothing is said
_COUNTS: Final = 6.0  # of motion as well: a coarse encoder shows less of it
_SAMPLES: Final = 4  # of a window at least: a gap between two of them says nothing
_AGAINST: Final = 0.5  # of the motion
_STEADY: Final = 0.5  # of its way, there and back: a joint that rattles is sampled too slowly
_ALONG: Final = 0.1  # of its way, along with the motor: what counts backwards does so at each step
_LONG: Final = 0.5  # s, over which a zero that wanders shows
_APART: Final = 0.02  # rad in that time; on the shipped rigs it is 0.002 at most
_RESTING: Final = 0.03  # rad: only of a joint that hardly moves in that time
_EVERY: Final = 0.01  # s between the samples that are kept for so long
_LAG: Final = 10  # of them: what freezes or goes backwards is named by then


class EncoderWatch:
    """Compare the way of a position with the integral of the drive's own velocity.

    A drive takes its velocity from the motor, or at least from another filter. In sound motion of
    the shipped rigs the two differ by less than half of the way, beside every singularity, and a
    position never stands still while the velocity says more than two counts. A drive that derives
    its velocity from the encoder's counts alone shows none of these faults: then its joint does
    not follow, which is seen later. Nor does a zero show that wanders by less than 0.04 rad/s, or
    while the joint is to move.

    Parameters
    ----------
    step : float
        Of the position, rad.
    """

    __slots__ = ("_gone", "_least", "_still", "_trail", "_velocity", "_way", "_wide")

    def __init__(self, step: float) -> None:
        self._least = max(_LEAST, _COUNTS * abs(step))
        self._still = 1.5 * abs(step)
        self._trail: deque[tuple[float, float, float, float]] = deque()
        self._wide: deque[tuple[float, float, float]] = deque()
        self._way = self._gone = self._velocity = 0.0

    def reset(self) -> None:
        """Forget what was seen."""
        self._trail.clear()
        self._wide.clear()

    def look(self, t: float, position: float, velocity: float) -> str | None:
        """Take a sample, and say what is wrong with the encoder, if anything.

        Parameters
        ----------
        t : float
            Of the sample, s; one that was seen before is left alone.
        position, velocity : float
            rad and rad/s.
        """
        trail = self._trail
        if trail:
            elapsed = t - trail[-1][0]
            if elapsed <= 0.0:
                return None
            self._way += 0.5 * (velocity + self._velocity) * elapsed
            self._gone += 0.5 * (abs(velocity) + abs(self._velocity)) * elapsed
        self._velocity = velocity
        trail.append((t, position, self._way, self._gone))
        while t - trail[0][0] > _SPAN:
            trail.popleft()
        return self._look_near(position) or self._look_far(t, position)

    def _look_near(self, position: float) -> str | None:
        """Say whether the position goes along with the motor."""
        trail = self._trail
        way = self._way - trail[0][2]
        if len(trail) < _SAMPLES or -self._least < way < self._least:
            return None
        shown = (position - trail[0][1]) * (1.0 if way > 0.0 else -1.0)
        is_steady = abs(way) >= _STEADY * (self._gone - trail[0][3])
        if is_steady and shown <= -_AGAINST * abs(way) and not self._goes_along():
            return "its encoder is mirrored: the position goes against the motor"
        if abs(shown) > self._still:  # it has moved, wherever it was in between
            return None
        positions = [sample[1] for sample in trail]
        if max(positions) - min(positions) <= self._still:
            return "its encoder is frozen: the position does not change while the motor turns"
        return None

    def _goes_along(self) -> bool:
        """Return whether some of the position's steps go along with the motor.

        A blow turns a joint between two samples, and no velocity shows it: one that rattles on
        the floor goes along with its motor from blow to blow.
        """
        along = gone = 0.0
        for before, after in pairwise(self._trail):
            step = after[1] - before[1]
            gone += abs(step)
            along += abs(step) if step * (after[2] - before[2]) > 0.0 else 0.0
        return along > _ALONG * gone

    def _look_far(self, t: float, position: float) -> str | None:
        """Say whether the position leaves the motor's, little by little."""
        wide = self._wide
        if not wide or t - wide[-1][0] >= _EVERY:
            wide.append((t, position, self._way))
            while t - wide[0][0] > _LONG:
                wide.popleft()
        if len(wide) <= _LAG:
            return None
        (_, start, before), (_, end, since) = wide[0], wide[-_LAG]
        shown, way = end - start, since - before
        # A drive that tells no velocity has a motor that never moves: that says nothing.
        if abs(way) <= abs(shown) or abs(way - shown) <= _APART + _AGAINST * abs(shown):
            return None
        shows = [sample[1] for sample in wide]
        if max(shows) - min(shows) > _RESTING:  # a velocity may be coarse where it changes fast
            return None
        return f"its encoder wanders: the motor left the position by {way - shown:+.3g} rad"
