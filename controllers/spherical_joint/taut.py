"""Tensions that keep every wire taut and turn the ring no more than they should."""

import math
from typing import NamedTuple

from controllers.compiled import inlined
from controllers.spherical_joint.geometry import Pair, Quadruple

_MOST_LIFTS = 25
_LIFTED = 1e-3
"""How often the lowest tension is lifted, which may lower another a little, and by what more, N."""

_WORTH = 0.5
"""What a newton of the other pair's mean must take from a wire at its greatest tension, N. Below 35
degrees of tilt it takes less, and a swing would empty and fill the other pair for little."""


class SlackWire(ValueError):
    """No tensions hold the pose with every wire taut."""


def raised(tensions: Quadruple, shares: Quadruple, least: float) -> Quadruple:
    """Return tensions (N) that turn the ring as much, none below `least`.

    Parameters
    ----------
    tensions : tuple of float
        Of the four wires, N.
    shares : tuple of float
        Of the pose; see `PoseTensions`.
    least : float
        N.

    Raises
    ------
    SlackWire
        The wires have no force closure here.
    """
    if not min(shares) > 0.0:
        number = shares.index(min(shares)) + 1
        raise SlackWire(
            f"wire {number} would have to push: no tensions hold this pose with all wires taut"
        )
    return lifted(tensions, shares, least)


@inlined
def lifted(tensions: Quadruple, shares: Quadruple, least: float) -> Quadruple:
    """Return what `raised` does, for shares that are positive."""
    (a, b, c, d), (e, f, g, h) = tensions, shares
    if a >= least and b >= least and c >= least and d >= least:
        return tensions
    level = max((least - a) / e, (least - b) / f, (least - c) / g, (least - d) / h)
    return (a + level * e, b + level * f, c + level * g, d + level * h)


class PoseTensions(NamedTuple):
    """The effect of the wires' tensions on the ring in one pose.

    Parameters
    ----------
    shares : tuple of float
        Tensions that turn the ring nowhere, of sum 1: the null vector of the wires' Jacobian. One
        that is not positive means that no four taut wires hold this pose.
    first, second : tuple of float
        What a newton in each wire adds to the force of the pairs (1, 3) and (4, 2): the
        difference of a pair's two tensions that alone would tilt the ring as much. At home that
        is ±1 for the pair's own wires; the further the ring tilts, the more it is a matter of
        all four, because two equal tensions of a pair no longer cancel.
    """

    shares: Quadruple
    first: Quadruple
    second: Quadruple

    def kept_taut(self, tensions: Quadruple, least: float) -> Quadruple:
        """Return tensions (N) that tilt the ring as much, none below `least`.

        Unlike raising all four (`raised`) this leaves the spin to the friction of the seat, and so
        takes no more than it must: where a wire's share is small, at great tilts, raising would
        multiply every newton that a controller takes from it. For differences that come and go.
        """
        return kept_taut(self.first, self.second, tensions, least)


@inlined
def pair_forces(first: Quadruple, second: Quadruple, tensions: Quadruple) -> Pair:
    """Return the force of each pair (N) that four tensions (N) amount to; see `PoseTensions`."""
    return _weighted(first, tensions), _weighted(second, tensions)


@inlined
def _weighted(weights: Quadruple, tensions: Quadruple) -> float:
    return (
        tensions[0] * weights[0]
        + tensions[1] * weights[1]
        + tensions[2] * weights[2]
        + tensions[3] * weights[3]
    )


@inlined
def kept_taut(first: Quadruple, second: Quadruple, tensions: Quadruple, least: float) -> Quadruple:
    """Return what `PoseTensions.kept_taut` does, for that pose's `first` and `second`."""
    a, b, c, d = tensions
    if a >= least and b >= least and c >= least and d >= least:
        return tensions
    for _ in range(_MOST_LIFTS):
        lowest = min(a, b, c, d)
        if lowest >= least:
            break
        # A mean tension in the wire's own pair, and what makes up for the tilt by it.
        if lowest in (a, c):
            half, along = 0.5 * (first[0] + first[2]), 0.5 * (second[0] + second[2])
            lift = (least + _LIFTED - lowest) / (1.0 - half if lowest == a else 1.0 + half)
            a += lift * (1.0 - half)
            c += lift * (1.0 + half)
            d -= lift * along
            b += lift * along
        else:
            half, along = 0.5 * (second[3] + second[1]), 0.5 * (first[3] + first[1])
            lift = (least + _LIFTED - lowest) / (1.0 - half if lowest == d else 1.0 + half)
            d += lift * (1.0 - half)
            b += lift * (1.0 + half)
            a -= lift * along
            c += lift * along
    return a, b, c, d


@inlined
def kept_within(
    first: Quadruple, second: Quadruple, tensions: Quadruple, least: float, most: float
) -> Quadruple:
    """Return tensions (N) that tilt the ring as much, the highest at most `most` if it can be.

    A wire that is cut off at its greatest tension would lack the rest in its pair's force, while
    at great tilts the other pair's wires together pull against it. So they give way, or help;
    its own opposite wire keeps its tension, which is the least one where this is needed.

    Parameters
    ----------
    first, second : tuple of float
        See `PoseTensions`.
    tensions : tuple of float
        Of the four wires, N; taut (see `kept_taut`).
    least, most : float
        N.
    """
    a, b, c, d = tensions
    highest = max(a, b, c, d)
    if highest <= most:
        return tensions
    half, along = 0.5 * (first[0] + first[2]), 0.5 * (second[0] + second[2])
    other_half, other_along = 0.5 * (second[3] + second[1]), 0.5 * (first[3] + first[1])
    if highest == a:
        a, d, b = _relieved(a, d, b, -half, along, -other_along, other_half, least, most)
    elif highest == c:
        c, d, b = _relieved(c, d, b, half, along, other_along, other_half, least, most)
    elif highest == d:
        d, a, c = _relieved(d, a, c, -other_half, other_along, -along, half, least, most)
    else:
        b, a, c = _relieved(b, a, c, other_half, other_along, along, half, least, most)
    return a, b, c, d


@inlined
def _relieved(
    high: float,
    one: float,
    other: float,
    half: float,
    along: float,
    cross: float,
    other_half: float,
    least: float,
    most: float,
) -> tuple[float, float, float]:
    """Return the highest tension relieved by the other pair's two, and these."""
    share = cross / (1.0 - half)  # of the own pair's mean that keeps its opposite wire's tension
    relief = share * (1.0 + half) + cross
    if abs(relief) < _WORTH:
        return high, one, other
    sign = -1.0 if relief > 0.0 else 1.0
    rate = sign * (1.0 - other_half - share * along)
    other_rate = sign * (1.0 + other_half + share * along)
    way = min(
        (high - most) / abs(relief),
        _room(one, rate, least, most),
        _room(other, other_rate, least, most),
    )
    return high - way * abs(relief), one + way * rate, other + way * other_rate


@inlined
def _room(tension: float, rate: float, least: float, most: float) -> float:
    """Return how far a tension may go on at a rate before it is at a bound."""
    if rate == 0.0:
        return math.inf
    return max(((most if rate > 0.0 else least) - tension) / rate, 0.0)
